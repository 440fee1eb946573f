#pragma once

#include <vector>

namespace saccade {

/// A std::vector whose copies have its capacity too, for what a detector fills in its ticks: a copy of the detector allocates
/// there as little as the original.
template <class T>
class ReservedVector : public std::vector<T> {
 public:
  ReservedVector() = default;
  ReservedVector(const ReservedVector& other) : std::vector<T>() { *this = other; }
  ReservedVector(ReservedVector&&) noexcept = default;
  ReservedVector& operator=(const ReservedVector& other) {
    if (this == &other) return *this;
    this->reserve(other.capacity());
    this->assign(other.begin(), other.end());
    return *this;
  }
  ReservedVector& operator=(ReservedVector&&) noexcept = default;
  ~ReservedVector() = default;
};

}  // namespace saccade
