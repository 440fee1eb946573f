#pragma once

namespace saccade {

/// How often this program has called malloc so far, in any thread: operator new and Eigen both end there.
[[nodiscard]] long malloc_count();
/// The same of the calling thread alone.
[[nodiscard]] long thread_malloc_count();
/// False where a sanitizer owns malloc.
[[nodiscard]] bool malloc_is_counted();

}  // namespace saccade
