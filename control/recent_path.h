#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace saccade {

/// The last 2.56 s of a moving point as averages over 20 ms.
class RecentPath {
 public:
  static constexpr std::int64_t capacity = 128;
  static constexpr double spacing_s = 0.02;

  struct Average {
    Eigen::Vector3d point_m = Eigen::Vector3d::Zero();
    bool known = false;
  };

  /// A point at t_s (s, never decreasing), m. `velocity_m_s`: an estimate of its velocity, which moves points to the middle
  /// of their 20 ms. Returns whether an average was closed.
  bool observe(double t_s, const Eigen::Vector3d& point_m, const Eigen::Vector3d& velocity_m_s);
  void clear();

  /// Number of the newest closed average since time 0; -1 if there is none.
  [[nodiscard]] std::int64_t newest() const { return newest_; }
  /// Number of averages from the first one after clear() to the newest, with gaps; at most capacity.
  [[nodiscard]] std::int64_t length() const;
  /// `back` averages before the newest: 0 to length() - 1.
  [[nodiscard]] const Average& at(std::int64_t back) const {
    return averages_[static_cast<std::size_t>((newest_ - back) % capacity)];
  }
  /// The middle of average `number`, s.
  [[nodiscard]] static double time_s(std::int64_t number) {
    return (static_cast<double>(number) + 0.5) * spacing_s;
  }

 private:
  void close();

  std::array<Average, static_cast<std::size_t>(capacity)> averages_{};
  std::int64_t newest_ = -1;
  std::int64_t first_ = 0;
  std::int64_t open_ = -1;  ///< number of the average that points are added to
  Eigen::Vector3d sum_m_ = Eigen::Vector3d::Zero();
  int count_ = 0;
};

}  // namespace saccade
