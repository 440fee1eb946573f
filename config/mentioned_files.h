#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace saccade {

/// The files that a program's text or a model in MJCF names, and those that these name in turn, each once: what stands in
/// quotes, words with a dot or a slash, and modules that a Python file imports. A name is sought in the folder of the file
/// that holds it, in `folder` (empty: the working directory), and in the folders that the text names in quotes. Files of
/// the system (/usr, /etc, /proc ...) are left out. Binary files and files of more than 1 MiB are listed but not searched.
/// A name that a program puts together while it runs is not found.
[[nodiscard]] std::vector<std::string> mentioned_files(const std::filesystem::path& file,
                                                       const std::filesystem::path& folder);

}  // namespace saccade
