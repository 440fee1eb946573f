// The program `saccade` with a detector `disc_inputs`: `best`, which writes what it computes the probabilities of all
// its circles from, at every 4 ms. For scripts/fit:
//   saccade_disc_inputs detect RUN --config FILE
// with FILE holding `detectors: {disc_inputs: {file: OUT, radius_px: [4, 25]}}`. OUT: float32 rows of time (ms), circle
// (x, y, r; px), covariance (upper triangle, px^2), inputs.
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "apps/cli/program.h"
#include "core/ball_tracker.h"

namespace saccade {

struct DiscInputsConfig {
  std::array<double, 2> radius_px = {10, 35};
  std::string file = "disc_inputs.bin";
};

void describe(FieldVisitor& v, DiscInputsConfig& c) {
  describe_radius_px(v, c.radius_px);
  v.text("file", c.file, "where the inputs are written");
}

std::string window_text(const DiscInputsConfig&) { return "edges"; }

namespace {

BallTrackerConfig tracker_config(const DiscInputsConfig& config) {
  BallTrackerConfig tracker;
  tracker.radius_px = config.radius_px;
  return tracker;
}

class DiscInputWriter final : public Detector {
 public:
  DiscInputWriter(const DiscInputsConfig& config, const Camera& camera)
      : tracker_(tracker_config(config), camera), file_(std::fopen(config.file.c_str(), "wb")) {
    if (file_ == nullptr) throw InputError(config.file, "cannot be written", "a path for the inputs");
  }
  ~DiscInputWriter() override { std::fclose(file_); }
  DiscInputWriter(const DiscInputWriter&) = delete;
  DiscInputWriter& operator=(const DiscInputWriter&) = delete;

  void process(std::span<const Event> events, const CameraMotion* motion) override {
    if (!events.empty()) now_us_ = events.back().t_us;
    tracker_.process(events, motion);
  }
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override {
    now_us_ = now_us;
    tracker_.advance_to(now_us, motion);
  }
  Estimate estimate() override {
    if (now_us_ / 1000 % 4 == 0) {
      tracker_.for_each_hypothesis([&](const BallTracker::Hypothesis& h) {
        std::vector<float> row = {static_cast<float>(now_us_ / 1000), static_cast<float>(h.circle.x_px),
                                  static_cast<float>(h.circle.y_px), static_cast<float>(h.circle.r_px)};
        for (int i = 0; i < 3; ++i) {
          for (int j = i; j < 3; ++j) row.push_back(static_cast<float>(h.covariance_px2(i, j)));
        }
        row.insert(row.end(), h.inputs.begin(), h.inputs.end());
        std::fwrite(row.data(), sizeof(float), row.size(), file_);
      });
    }
    return tracker_.estimate();
  }
  double threshold() const override { return tracker_.threshold(); }
  RejectedEvents rejected() const override { return tracker_.rejected(); }

 private:
  BallTracker tracker_;
  std::FILE* file_;
  std::int64_t now_us_ = 0;
};

}  // namespace
}  // namespace saccade

int main(int argc, char** argv) {
  saccade::Registry registry = saccade::built_in_registry();
  registry.detectors.add(saccade::detector_row(
      "disc_inputs", "writes the inputs of best's probabilities", saccade::DiscInputsConfig{},
      [](const saccade::DiscInputsConfig& config, const saccade::Camera& camera) {
        return std::make_unique<saccade::DiscInputWriter>(config, camera);
      }));
  return saccade::program(argc, argv, registry);
}
