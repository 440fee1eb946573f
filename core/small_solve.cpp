#include "core/small_solve.h"

#include <Eigen/Cholesky>
#include <Eigen/QR>

namespace saccade {

template <int N>
Eigen::Matrix<double, N, 1> cholesky_solution(const Eigen::Matrix<double, N, N>& a,
                                              const Eigen::Matrix<double, N, 1>& b) {
  return Eigen::LLT<Eigen::Matrix<double, N, N>>(a).solve(b);
}
template Eigen::Matrix<double, 3, 1> cholesky_solution(const Eigen::Matrix<double, 3, 3>&,
                                                       const Eigen::Matrix<double, 3, 1>&);
template Eigen::Matrix<double, 6, 1> cholesky_solution(const Eigen::Matrix<double, 6, 6>&,
                                                       const Eigen::Matrix<double, 6, 1>&);
template Eigen::Matrix<double, 12, 1> cholesky_solution(const Eigen::Matrix<double, 12, 12>&,
                                                        const Eigen::Matrix<double, 12, 1>&);

Eigen::Vector3d ldlt_solution(const Eigen::Matrix3d& a, const Eigen::Vector3d& b) {
  return a.ldlt().solve(b);
}

Eigen::Vector3d least_norm_solution(const Eigen::Matrix3d& a, const Eigen::Vector3d& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

Eigen::Vector2d least_norm_solution(const Eigen::Matrix<double, 3, 2>& a, const Eigen::Vector3d& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

}  // namespace saccade
