#pragma once

#include <cstdint>
#include <vector>

#include "core/detector_parts.h"
#include "core/detector_views.h"
#include "core/random.h"

namespace saccade {

/// Particle filter of Glover and Bartolozzi ("Robust visual tracking with a freely-moving event camera", IROS 2017). The
/// defaults are those of the authors' configuration file, the number of particles that of their SpiNNaker version.
struct ParticleFilterConfig {
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest radius
  std::int64_t particles = 60;
  std::int64_t bins = 64;       ///< of the angle around a particle
  double min_likelihood = 0.1;  ///< of a particle, share of the bins
  double inlier_px =
      1.0;  ///< an event counts less from 1 px off the outline on, not at all from 1 px + this on
  double negative_bias = 2.0;  ///< of events inside: a disc full of events, one at each pixel, is worth -bias
  double motion_px = 2.0;  ///< half of the range of a particle's random motion in an update; a fifth for r
  double threshold = 0.5;  ///< share of the bins taken for the ball
  std::int64_t lost_updates = 10;  ///< below the threshold after which the search begins again
  std::int64_t seed = 1;           ///< of the random numbers
};

/// Keys: radius_px, particles, bins, min_likelihood, inlier_px, negative_bias, motion_px, threshold, lost_updates, seed.
void describe(FieldVisitor& v, ParticleFilterConfig& config);

/// The particle filter of 2017. A particle is a circle.
///
/// After every pi r events in the region of interest (10 px more than the radius on each side of the estimate) the filter
/// is updated. The likelihood of a particle grows with each bin of angle in which an event lies on its outline, and falls
/// with each event inside. It is evaluated over windows of increasing length, from the newest event on: the largest value
/// counts, and the window that has it. The window of the filter is the weighted mean of those. The estimate is the
/// weighted mean of the particles, which are then resampled and moved at random. As in the authors' code, a resampled
/// particle keeps its weight.
///
/// The original is given the first circle. Here, while nothing is tracked, every particle of an update is a circle
/// through three events of the newest 1000 of the whole image; tracking begins where one reaches the threshold, and ends
/// after `lost_updates` updates below it.
///
/// Score: largest likelihood of a particle over the number of bins, at most 1.
class ParticleFilter final : public Detector, public DetectorViews {
 public:
  /// Throws InputError for a configuration out of range.
  ParticleFilter(const ParticleFilterConfig& config, ImageSize size);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t, const CameraMotion*) override {}
  [[nodiscard]] Estimate estimate() override { return estimate_; }
  [[nodiscard]] double threshold() const override { return config_.threshold; }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    return std::make_unique<ParticleFilter>(*this);
  }

 private:
  struct Pixel {
    std::uint16_t x, y;
  };
  struct Polar {
    float distance_px;
    std::uint16_t bin;
  };
  struct Particle {
    Circle circle;
    double weight = 0.0;
    double likelihood = 0.0;  // in bins, of the last update
    double window = 0.0;      // number of events before the one that made the likelihood largest
  };
  /// An event by age, 0 the newest.
  [[nodiscard]] const Pixel& event(std::size_t age) const {
    return window_[(end_ + window_.size() - 1 - age) % window_.size()];
  }
  [[nodiscard]] double uniform(std::size_t particle, std::uint64_t which, double low, double high) const;
  void add(const Event& event);
  void update();
  void search();
  [[nodiscard]] Circle through_three_events(std::size_t particle) const;
  void observe(Particle& particle);
  void resample();

  ParticleFilterConfig config_;
  ImageSize size_;
  EventSieve sieve_;
  RandomStream random_;
  std::uint64_t updates_ = 0;
  std::vector<Particle> particles_, parents_;
  std::vector<double> covered_;  // of each bin, in the particle that is observed
  int table_px_;                 // offsets in the table reach this far on each side
  std::vector<Polar> polar_;     // of offsets from a centre
  std::vector<Pixel> window_;    // a ring
  std::size_t end_ = 0;          // of the ring
  std::size_t count_ = 0;
  double added_ = 0.0;  // events since the last update
  bool tracking_ = false;
  std::int64_t updates_below_ = 0;
  Estimate estimate_;
};

}  // namespace saccade
