#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>

#include "core/error.h"
#include "core/small_solve.h"

namespace saccade {

/// Minimises 1/2 x'Hx - g'x subject to lower <= x <= upper, N <= 12, H symmetric and positive definite (for
/// least squares |Ax - b|^2: H = A'A, g = A'b). Primal active set method: every iterate is exactly within the bounds.
/// The next call starts from the last solution and active set. At most max_iterations; does not allocate. Where H or g are
/// not finite, or overflow, the solution is the point of the bounds nearest to 0, and not optimal.
template <int N>
class BoundedQp {
  static_assert(N >= 1 && N <= 12);

 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  struct Solution {
    Vector x = Vector::Zero();
    int iterations = 0;
    bool optimal = false;  ///< false: stopped at max_iterations; x is within the bounds and the best so far
  };
  static constexpr int max_iterations = 10 * N;

  /// Bounds must not cross: lower <= upper.
  [[nodiscard]] Solution solve(const Matrix& h, const Vector& g, const Vector& lower, const Vector& upper) {
    Solution s;
    for (int i = 0; i < N; ++i) {
      SACCADE_CHECK(lower[i] <= upper[i]);
      const Side side = active_[index(i)];
      s.x[i] = side == Side::lower   ? lower[i]
               : side == Side::upper ? upper[i]
                                     : std::min(std::max(start_[i], lower[i]), upper[i]);
    }
    // A multiplier of the wrong sign counts when it is above the rounding of the gradient.
    const double tolerance = 1e-13 * (h.cwiseAbs() * s.x.cwiseAbs() + g.cwiseAbs()).maxCoeff();
    while (s.iterations < max_iterations && !s.optimal) {
      ++s.iterations;
      const Vector step = newton_step(h, g - h * s.x);
      if (advance(s.x, step, lower, upper)) continue;
      s.optimal = !release_one(h * s.x - g, lower, upper, tolerance);
    }
    if (!s.x.allFinite()) {
      *this = {};
      s = {Vector::Zero().cwiseMax(lower).cwiseMin(upper), s.iterations, false};
    }
    start_ = s.x;
    return s;
  }

 private:
  enum class Side : std::uint8_t { free, lower, upper };
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  [[nodiscard]] bool is_free(int i) const { return active_[index(i)] == Side::free; }

  /// To the minimum over the free variables; the others stay.
  Vector newton_step(const Matrix& h, const Vector& descent) const {
    Matrix reduced = Matrix::Identity();
    Vector right = Vector::Zero();
    for (int i = 0; i < N; ++i) {
      if (!is_free(i)) continue;
      right[i] = descent[i];
      for (int j = 0; j < N; ++j) {
        if (is_free(j)) reduced(i, j) = h(i, j);
      }
    }
    return cholesky_solution<N>(reduced, right);
  }

  /// Goes along `step` up to the first bound, which becomes active. True when there was one.
  bool advance(Vector& x, const Vector& step, const Vector& lower, const Vector& upper) {
    double length = 1.0;
    int blocking = -1;
    for (int i = 0; i < N; ++i) {
      if (!is_free(i) || step[i] == 0.0) continue;
      const double room = (step[i] < 0.0 ? lower[i] : upper[i]) - x[i];
      if (room / step[i] < length) {
        length = room / step[i];
        blocking = i;
      }
    }
    for (int i = 0; i < N; ++i) {
      if (is_free(i)) x[i] = std::min(std::max(x[i] + length * step[i], lower[i]), upper[i]);
    }
    if (blocking < 0) return false;
    const bool down = step[blocking] < 0.0;
    x[blocking] = down ? lower[blocking] : upper[blocking];
    active_[index(blocking)] = down ? Side::lower : Side::upper;
    return true;
  }

  /// Frees the variable whose multiplier is most wrong. False when all are right: x is the optimum.
  bool release_one(const Vector& gradient, const Vector& lower, const Vector& upper, double tolerance) {
    double worst = tolerance;
    int leaving = -1;
    for (int i = 0; i < N; ++i) {
      if (is_free(i) || lower[i] == upper[i]) continue;
      const double wrong = active_[index(i)] == Side::lower ? -gradient[i] : gradient[i];
      if (wrong > worst) {
        worst = wrong;
        leaving = i;
      }
    }
    if (leaving >= 0) active_[index(leaving)] = Side::free;
    return leaving >= 0;
  }

  std::array<Side, N> active_{};
  Vector start_ = Vector::Zero();
};

}  // namespace saccade
