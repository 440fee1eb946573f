#pragma once

#include <cstddef>
#include <vector>

namespace saccade {

namespace detail {
/// Memory for arrays; from half a megabyte on, on Linux, in pages of 2 MB where the kernel has them. Throws std::bad_alloc.
[[nodiscard]] void* allocate_array(std::size_t bytes);
void free_array(void* memory, std::size_t bytes) noexcept;
}  // namespace detail

template <class T>
struct LargePageAllocator {
  using value_type = T;
  LargePageAllocator() = default;
  template <class Other>
  explicit LargePageAllocator(const LargePageAllocator<Other>& /*other*/) {}
  [[nodiscard]] T* allocate(std::size_t count) {
    return static_cast<T*>(detail::allocate_array(count * sizeof(T)));
  }
  void deallocate(T* values, std::size_t count) noexcept { detail::free_array(values, count * sizeof(T)); }
  bool operator==(const LargePageAllocator& /*other*/) const { return true; }
};

/// A vector for large arrays whose values are read in no order. With pages of 4 KB the processor often has to look up the address
/// of a value's page in memory first.
template <class T>
using LargeVector = std::vector<T, LargePageAllocator<T>>;

}  // namespace saccade
