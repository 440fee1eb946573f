#include "core/small_solve.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace saccade {
namespace {

constexpr int max_size = 12;
constexpr double smallest = std::numeric_limits<double>::min();
constexpr double epsilon = std::numeric_limits<double>::epsilon();

/// The sum of n >= 1 numbers as a balanced tree, every `step`th of them.
double tree_sum(const double* x, int n, int step) {
  if (n == 1) return *x;
  const int half = n / 2;
  return tree_sum(x, half, step) + tree_sum(x + half * step, n - half, step);
}

/// The sum in the order of two interleaved lanes.
double lane_sum(const double* x, int n) {
  if (n < 2) return *x;
  const double pairs = tree_sum(x, n / 2, 2) + tree_sum(x + 1, n / 2, 2);
  return n % 2 == 0 ? pairs : pairs + x[n - 1];
}

}  // namespace

void solve_cholesky(double* a, double* b, int n) {
  const auto at = [a, n](int row, int column) -> double& { return a[column * n + row]; };
  for (int k = 0; k < n; ++k) {
    double pivot = at(k, k);
    if (k > 0) {
      double sum = 0.0;
      for (int j = 0; j < k; ++j) sum += at(k, j) * at(k, j);
      pivot -= sum;
    }
    if (pivot <= 0.0) break;
    pivot = std::sqrt(pivot);
    at(k, k) = pivot;
    for (int i = k + 1; i < n; ++i) {
      double sum = 0.0;
      for (int j = 0; j < k; ++j) sum += at(i, j) * at(k, j);
      at(i, k) = (at(i, k) - sum) / pivot;
    }
  }
  std::array<double, max_size> products{};
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) products[static_cast<std::size_t>(j)] = at(i, j) * b[j];
    if (i > 0) b[i] -= tree_sum(products.data(), i, 1);
    b[i] /= at(i, i);
  }
  for (int i = n - 1; i >= 0; --i) {
    const int below = n - 1 - i;
    for (int j = 0; j < below; ++j) products[static_cast<std::size_t>(j)] = at(i + 1 + j, i) * b[i + 1 + j];
    if (below > 0) b[i] -= lane_sum(products.data(), below);
    b[i] /= at(i, i);
  }
}

Eigen::Vector3d ldlt_solution(const Eigen::Matrix3d& matrix, const Eigen::Vector3d& b) {
  constexpr int n = 3;
  Eigen::Matrix3d m = matrix;  // L below the diagonal, D on it
  std::array<int, n> swapped_with{};
  for (int k = 0; k < n; ++k) {
    int largest = k;
    for (int i = k + 1; i < n; ++i) {
      if (std::abs(m(i, i)) > std::abs(m(largest, largest))) largest = i;
    }
    swapped_with[static_cast<std::size_t>(k)] = largest;
    if (largest != k) {
      for (int j = 0; j < k; ++j) std::swap(m(k, j), m(largest, j));
      for (int i = largest + 1; i < n; ++i) std::swap(m(i, k), m(i, largest));
      std::swap(m(k, k), m(largest, largest));
      for (int i = k + 1; i < largest; ++i) std::swap(m(i, k), m(largest, i));
    }
    std::array<double, n> scaled{};
    for (int j = 0; j < k; ++j) scaled[static_cast<std::size_t>(j)] = m(j, j) * m(k, j);
    for (int i = k; i < n && k > 0; ++i) {
      double sum = 0.0;
      for (int j = 0; j < k; ++j) sum += m(i, j) * scaled[static_cast<std::size_t>(j)];
      m(i, k) -= sum;
    }
    if (!(std::abs(m(k, k)) > 0.0)) {
      if (k > 0) continue;
      for (int j = 0; j < n; ++j) swapped_with[static_cast<std::size_t>(j)] = j;  // the matrix is zero
      break;
    }
    for (int i = k + 1; i < n; ++i) m(i, k) /= m(k, k);
  }
  Eigen::Vector3d x = b;
  for (int k = 0; k < n; ++k) std::swap(x[k], x[swapped_with[static_cast<std::size_t>(k)]]);
  x[1] -= m(1, 0) * x[0];
  x[2] -= m(2, 0) * x[0] + m(2, 1) * x[1];
  for (int k = 0; k < n; ++k) x[k] = std::abs(m(k, k)) > smallest ? x[k] / m(k, k) : 0.0;
  x[1] -= m(2, 1) * x[2];
  x[0] -= m(1, 0) * x[1] + m(2, 0) * x[2];
  for (int k = n - 1; k >= 0; --k) std::swap(x[k], x[swapped_with[static_cast<std::size_t>(k)]]);
  return x;
}

namespace {

/// The reflection I - tau v v' with v = (1, essential), which turns a vector into (beta, 0, ...).
struct Reflection {
  double tau = 0.0;
  double beta = 0.0;
};

/// Of the vector `x` of n <= 3 elements, every `step`th number; what comes after the first becomes the essential part.
Reflection reflect(double* x, int n, int step) {
  double rest = 0.0;
  for (int i = 1; i < n; ++i) rest += x[i * step] * x[i * step];
  if (rest <= smallest) {
    for (int i = 1; i < n; ++i) x[i * step] = 0.0;
    return {0.0, x[0]};
  }
  double beta = std::sqrt(x[0] * x[0] + rest);
  if (x[0] >= 0.0) beta = -beta;
  for (int i = 1; i < n; ++i) x[i * step] /= x[0] - beta;
  return {(beta - x[0]) / beta, beta};
}

/// The inner product of (1, essential) with `x` of n elements.
double along(const double* essential, int essential_step, const double* x, int n, int step) {
  double sum = 0.0;
  for (int i = 1; i < n; ++i) sum += essential[(i - 1) * essential_step] * x[i * step];
  return sum + x[0];
}

/// Applies a reflection to the column `x` of n elements.
void apply(const double* essential, int essential_step, double tau, double* x, int n) {
  if (n == 1) {
    x[0] *= 1.0 - tau;
    return;
  }
  if (tau == 0.0) return;
  const double a = along(essential, essential_step, x, n, 1);
  x[0] -= tau * a;
  for (int i = 1; i < n; ++i) x[i] -= tau * essential[(i - 1) * essential_step] * a;
}

/// The same for a row of n >= 2 elements, every `step`th number. Products round in another order.
void apply_to_row(const double* essential, double tau, double* x, int n, int step) {
  if (tau == 0.0) return;
  const double a = along(essential, step, x, n, step);
  x[0] -= tau * a;
  for (int i = 1; i < n; ++i) x[i * step] -= tau * a * essential[(i - 1) * step];
}

constexpr int rows = 3;

/// A = Q R P' with R = (T 0) Z where A has not full rank, for `columns` <= 3 columns.
class OrthogonalFactors {
 public:
  OrthogonalFactors(const double* a, int columns) : columns_(columns) {
    std::copy(a, a + rows * columns, qr_.begin());
    factorise();
    rank_ = rank();
    for (int k = rank_ - 1; k >= 0 && rank_ < columns_; --k) annihilate_right_of_rank(k);
  }

  /// `x` has `columns` elements.
  void solve(Eigen::Vector3d b, double* x) const {
    for (int k = 0; k < rank_; ++k) {
      apply(&at(k, k) + 1, 1, tau_[index(k)], b.data() + k, rows - k);
    }
    for (int i = rank_ - 1; i >= 0; --i) {
      b[i] /= at(i, i);
      for (int j = 0; j < i; ++j) b[j] -= b[i] * at(j, i);
    }
    for (int i = rank_; i < columns_; ++i) b[i] = 0.0;
    for (int k = 0; k < rank_ && rank_ < columns_; ++k) {
      std::swap(b[k], b[rank_ - 1]);
      apply(&at(k, rank_), rows, z_tau_[index(k)], b.data() + rank_ - 1, columns_ - rank_ + 1);
      std::swap(b[k], b[rank_ - 1]);
    }
    for (int i = 0; i < columns_; ++i) x[order_[index(i)]] = b[i];
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }
  double& at(int row, int column) { return qr_[index(column * rows + row)]; }
  const double& at(int row, int column) const { return qr_[index(column * rows + row)]; }

  /// Householder reflections with column pivoting.
  void factorise() {
    std::array<double, rows> norm{}, direct_norm{};
    double largest_norm = 0.0;
    for (int k = 0; k < columns_; ++k) {
      norm[index(k)] = std::sqrt(at(0, k) * at(0, k) + at(1, k) * at(1, k) + at(2, k) * at(2, k));
      direct_norm[index(k)] = norm[index(k)];
      largest_norm = std::max(largest_norm, norm[index(k)]);
    }
    const double negligible = largest_norm * epsilon * (largest_norm * epsilon) / rows;
    for (int k = 0; k < columns_; ++k) order_[index(k)] = k;
    nonzero_pivots_ = columns_;
    for (int k = 0; k < columns_; ++k) {
      int pivot = k;
      for (int j = k + 1; j < columns_; ++j) {
        if (norm[index(j)] > norm[index(pivot)]) pivot = j;
      }
      const double squared = norm[index(pivot)] * norm[index(pivot)];
      if (nonzero_pivots_ == columns_ && squared < negligible * (rows - k)) nonzero_pivots_ = k;
      if (pivot != k) {
        for (int i = 0; i < rows; ++i) std::swap(at(i, k), at(i, pivot));
        std::swap(norm[index(k)], norm[index(pivot)]);
        std::swap(direct_norm[index(k)], direct_norm[index(pivot)]);
        std::swap(order_[index(k)], order_[index(pivot)]);
      }
      const Reflection reflection = reflect(&at(k, k), rows - k, 1);
      tau_[index(k)] = reflection.tau;
      at(k, k) = reflection.beta;
      largest_pivot_ = std::max(largest_pivot_, std::abs(reflection.beta));
      for (int j = k + 1; j < columns_; ++j) {
        apply(&at(k, k) + 1, 1, reflection.tau, &at(k, j), rows - k);
        update_norm(k, j, norm[index(j)], direct_norm[index(j)]);
      }
    }
  }

  /// The norm of what is below row k in a column (LAPACK working note 176).
  void update_norm(int k, int column, double& norm, double& direct_norm) const {
    if (norm == 0.0) return;
    const double share = std::abs(at(k, column)) / norm;
    const double left = std::max(0.0, (1.0 + share) * (1.0 - share));
    const double ratio = norm / direct_norm;
    if (left * (ratio * ratio) > std::sqrt(epsilon)) {
      norm *= std::sqrt(left);
      return;
    }
    double sum = 0.0;
    for (int i = k + 1; i < rows; ++i) sum += at(i, column) * at(i, column);
    norm = direct_norm = std::sqrt(sum);
  }

  [[nodiscard]] int rank() const {
    const double threshold = largest_pivot_ * (epsilon * columns_);
    int count = 0;
    for (int i = 0; i < nonzero_pivots_; ++i) count += std::abs(at(i, i)) > threshold ? 1 : 0;
    return count;
  }

  /// A reflection from the right that leaves in row k nothing right of the first `rank` columns.
  void annihilate_right_of_rank(int k) {
    const auto swap_columns = [&] {
      for (int i = 0; i <= k; ++i) std::swap(at(i, k), at(i, rank_ - 1));
    };
    if (k != rank_ - 1) swap_columns();
    const Reflection reflection = reflect(&at(k, rank_ - 1), columns_ - rank_ + 1, rows);
    z_tau_[index(k)] = reflection.tau;
    at(k, rank_ - 1) = reflection.beta;
    for (int i = 0; i < k; ++i) {
      apply_to_row(&at(k, rank_), reflection.tau, &at(i, rank_ - 1), columns_ - rank_ + 1, rows);
    }
    if (k != rank_ - 1) swap_columns();
  }

  int columns_;
  int rank_ = 0;
  int nonzero_pivots_ = 0;
  double largest_pivot_ = 0.0;
  std::array<double, rows * rows> qr_{};  // by columns
  std::array<double, rows> tau_{}, z_tau_{};
  std::array<int, rows> order_{};
};

}  // namespace

Eigen::Vector3d least_norm_solution(const Eigen::Matrix3d& a, const Eigen::Vector3d& b) {
  Eigen::Vector3d x;
  OrthogonalFactors(a.data(), 3).solve(b, x.data());
  return x;
}

Eigen::Vector2d least_norm_solution(const Eigen::Matrix<double, 3, 2>& a, const Eigen::Vector3d& b) {
  Eigen::Vector2d x;
  OrthogonalFactors(a.data(), 2).solve(b, x.data());
  return x;
}

}  // namespace saccade
