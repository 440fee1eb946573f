// The program `saccade` with a detector `disc_inputs`: `best`, which writes what it computes the probabilities of all
// its circles from, at every 4 ms. For scripts/fit:
//   saccade_disc_inputs detect RUN --config FILE
// with FILE holding `detectors: {disc_inputs: {file: OUT, radius_px: [4, 25]}}`. OUT: float32 rows of time (ms), circle
// (x, y, r; px), covariance (upper triangle, px^2), inputs.
// For scripts/fit_patch: with the key `patches: OUT` the polar patches of all its circles, at every 12 ms, and of the circles
// of the file `circles` (float32 rows of time in ms, x, y, r in px, their rates in px/s), which scripts/fit_patch makes.
// OUT: for each patch float32 time (ms), circle, circle shown by the newest edges, 1 for a followed circle and 0 for one of
// the file, the figures of the patch, and its values as 8 bit numbers.
#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "apps/cli/program.h"
#include "core/tracker/ball_tracker.h"

namespace saccade {

struct DiscInputsConfig {
  std::array<double, 2> radius_px = {10, 35};
  std::string file = "disc_inputs.bin";
  std::string patches;
  std::string circles;
};

void describe(FieldVisitor& v, DiscInputsConfig& c) {
  describe_radius_px(v, c.radius_px);
  v.text("file", c.file, "where the inputs are written");
  v.text("patches", c.patches, "where the patches are written");
  v.text("circles", c.circles, "circles whose patches are written too");
}

std::string window_text(const DiscInputsConfig&) { return "edges"; }

namespace {

BallTrackerConfig tracker_config(const DiscInputsConfig& config) {
  BallTrackerConfig tracker;
  tracker.radius_px = config.radius_px;
  return tracker;
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

File opened(const std::string& path, const char* mode) {
  File file(std::fopen(path.c_str(), mode));
  if (file == nullptr) throw InputError(path, "cannot be opened", "a path of a file");
  return file;
}

/// A value in [least, least + 255 step] as 8 bits.
std::uint8_t coded(float value, float least, float step) {
  return static_cast<std::uint8_t>(std::clamp((value - least) / step + 0.5F, 0.0F, 255.0F));
}

class DiscInputWriter final : public Detector {
 public:
  DiscInputWriter(const DiscInputsConfig& config, const Camera& camera)
      : tracker_(tracker_config(config), camera) {
    if (config.patches.empty()) file_ = opened(config.file, "wb");
    if (!config.patches.empty()) patches_ = opened(config.patches, "wb");
    if (config.circles.empty()) return;
    const File file = opened(config.circles, "rb");
    GivenCircle circle{};
    while (std::fread(circle.data(), sizeof(float), circle.size(), file.get()) == circle.size())
      circles_.push_back(circle);
  }

  void process(std::span<const Event> events, const CameraMotion* motion) override {
    if (!events.empty()) now_us_ = events.back().t_us;
    tracker_.process(events, motion);
  }
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override {
    now_us_ = now_us;
    tracker_.advance_to(now_us, motion);
  }
  Estimate estimate() override {
    const std::int64_t now_ms = now_us_ / 1000;
    if (file_ != nullptr && now_ms % 4 == 0) write_inputs(now_ms);
    if (patches_ != nullptr) write_patches(now_ms);
    return tracker_.estimate();
  }
  double threshold() const override { return tracker_.threshold(); }
  RejectedEvents rejected() const override { return tracker_.rejected(); }

 private:
  using GivenCircle = std::array<float, 7>;

  void write_inputs(std::int64_t now_ms) {
    tracker_.for_each_hypothesis([&](const BallTracker::Hypothesis& h) {
      std::vector<float> row = {static_cast<float>(now_ms), static_cast<float>(h.circle.x_px),
                                static_cast<float>(h.circle.y_px), static_cast<float>(h.circle.r_px)};
      for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) row.push_back(static_cast<float>(h.covariance_px2(i, j)));
      }
      row.insert(row.end(), h.inputs.begin(), h.inputs.end());
      std::fwrite(row.data(), sizeof(float), row.size(), file_.get());
    });
  }

  void write_patches(std::int64_t now_ms) {
    if (now_ms % 12 == 0) {
      tracker_.for_each_hypothesis(
          [&](const BallTracker::Hypothesis& h) { write_patch(now_ms, h.circle, h.shown, h.motion, true); });
    }
    for (; next_circle_ < circles_.size() && circles_[next_circle_][0] <= static_cast<float>(now_ms);
         ++next_circle_) {
      const GivenCircle& c = circles_[next_circle_];
      const Circle circle{c[1], c[2], c[3]};
      write_patch(now_ms, circle, circle, tracker_.patch_motion(circle, {c[4], c[5], c[6]}), false);
    }
  }

  void write_patch(std::int64_t now_ms, const Circle& circle, const Circle& shown, const PatchMotion& motion,
                   bool followed) {
    const PolarPatch patch = tracker_.patch(shown, motion);
    std::vector<float> row = {static_cast<float>(now_ms)};
    for (const Circle& c : {circle, shown}) {
      for (const double value : {c.x_px, c.y_px, c.r_px}) row.push_back(static_cast<float>(value));
    }
    row.push_back(followed ? 1.0F : 0.0F);
    row.insert(row.end(), patch.about.begin(), patch.about.end());
    std::fwrite(row.data(), sizeof(float), row.size(), patches_.get());
    std::array<std::uint8_t, std::tuple_size_v<decltype(patch.values)>> codes{};
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const bool signed_value = i % PolarPatch::channels > PolarPatch::event_channels;
      codes[i] =
          signed_value ? coded(patch.values[i], -1.0F, 1.0F / 127.0F) : coded(patch.values[i], 0.0F, 0.01F);
    }
    std::fwrite(codes.data(), 1, codes.size(), patches_.get());
  }

  BallTracker tracker_;
  File file_, patches_;
  std::vector<GivenCircle> circles_;
  std::size_t next_circle_ = 0;
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
