#include "tests/control/malloc_count.h"

#include <atomic>
#include <cstdlib>

namespace {
std::atomic<long> allocations{0};
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// glibc's own name for malloc.
extern "C" void* __libc_malloc(std::size_t);
extern "C" void* malloc(std::size_t bytes) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  return __libc_malloc(bytes);
}
constexpr bool counts = true;
#else
constexpr bool counts = false;
#endif

namespace saccade {

long malloc_count() { return allocations.load(); }
bool malloc_is_counted() { return counts; }

}  // namespace saccade
