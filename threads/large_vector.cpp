#include "threads/large_vector.h"

#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace saccade::detail {
namespace {

constexpr std::size_t large_page = std::size_t{2} << 20U;
constexpr std::size_t least_large = std::size_t{512} << 10U;
// Values that are a cache line each lie in one.
constexpr std::align_val_t small_alignment{64};

std::size_t whole_pages(std::size_t bytes) { return (bytes + large_page - 1) / large_page * large_page; }

}  // namespace

void* allocate_array(std::size_t bytes) {
  if (bytes < least_large) return ::operator new(bytes, small_alignment);
  void* const memory = ::operator new (whole_pages(bytes), std::align_val_t{large_page});
#if defined(__linux__)
  ::madvise(memory, whole_pages(bytes), MADV_HUGEPAGE);  // where it fails, the pages are small
#endif
  return memory;
}

void free_array(void* memory, std::size_t bytes) noexcept {
  if (bytes < least_large)
    ::operator delete(memory, small_alignment);
  else
    ::operator delete (memory, std::align_val_t{large_page});
}

}  // namespace saccade::detail
