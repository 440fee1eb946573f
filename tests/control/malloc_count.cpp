#include "tests/control/malloc_count.h"

#include <atomic>
#include <cstdlib>

namespace {
std::atomic<long> allocations{0};
thread_local long thread_allocations = 0;
}  // namespace

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// glibc's own name for malloc.
extern "C" void* __libc_malloc(std::size_t);
extern "C" void* malloc(std::size_t bytes) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  ++thread_allocations;
  return __libc_malloc(bytes);
}
constexpr bool counts = true;
#else
constexpr bool counts = false;
#endif

namespace saccade {

long malloc_count() { return allocations.load(); }
long thread_malloc_count() { return thread_allocations; }
bool malloc_is_counted() { return counts; }

}  // namespace saccade
