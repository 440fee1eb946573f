#pragma once

#include <array>
#include <optional>

#include "control/recent_path.h"

namespace saccade {

/// Motion on an ellipse or a line with one frequency: centre + cosine cos(w (t - t0)) + sine sin(w (t - t0)), w = 2 pi f.
struct Sinusoid {
  double frequency_hz = 0.0;
  double t0_s = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d cosine_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sine_m = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d position_m(double t_s) const;
  [[nodiscard]] Eigen::Vector3d velocity_m_s(double t_s) const;
  [[nodiscard]] Eigen::Vector3d acceleration_m_s2(double t_s) const;
  /// Length of the larger semi-axis, or more: root of the sum of squares of both coefficients, m.
  [[nodiscard]] double amplitude_m() const;
};

/// Finds the frequency of a point that moves periodically, and the sinusoid that fits its last periods.
///
/// A candidate of frequency f is the least-squares sinusoid of the last 1.5 / f seconds (0.6 s at least). search() evaluates one candidate per call, so that
/// its cost is bounded: a scan from 0.4 to 3.2 Hz in steps of 0.1 Hz, then a search around the best one, which each new
/// average repeats. Every second scan starts from the beginning, so that a new frequency is found.
///
/// A sinusoid is reported from one observed period on, if it explains at least 92 % of the motion's variance and its
/// amplitude is at least 1 cm, and until it explains less than 85 %.
class PeriodicFit {
 public:
  /// Evaluates the next candidate. `path` is the same object in every call until clear().
  void search(const RecentPath& path);
  void clear();
  /// The newest sinusoid; none if the motion is not periodic, or not known for a period.
  [[nodiscard]] const std::optional<Sinusoid>& sinusoid() const { return sinusoid_; }

 private:
  static constexpr int scan_steps = 29;

  struct Candidate {
    Sinusoid sinusoid;
    double periods = 0.0;    ///< for which it was observed
    double explained = 0.0;  ///< share of the variance
  };
  enum class Stage { scan, refine, follow };

  [[nodiscard]] static Candidate evaluate(const RecentPath& path, double frequency_hz);
  void scan(const RecentPath& path);
  void refine(const RecentPath& path);
  void report(const Candidate& found);
  void start_scan();

  Stage stage_ = Stage::scan;
  int step_ = 0;  ///< of the scan, or of the three candidates of a refinement
  double spacing_hz_ = 0.0;
  int refinements_ = 0;
  std::int64_t refined_ = -1;  ///< number of the newest average at the last refinement
  std::int64_t scanned_ = 0;   ///< the same at the end of the last scan
  Candidate best_;
  std::array<Candidate, 2> sides_{};
  std::optional<Sinusoid> sinusoid_;
};

}  // namespace saccade
