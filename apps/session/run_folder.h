#pragma once

#include <filesystem>

namespace saccade {

/// Makes the folder of a run. An existing one that is not empty is refused without `force`; with it, what an
/// earlier run left there is removed (nothing else is, and a folder that holds no run is refused).
/// Throws InputError, RunError.
void prepare_run_folder(const std::filesystem::path& folder, bool force);

}  // namespace saccade
