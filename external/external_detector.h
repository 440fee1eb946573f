#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "core/detector.h"
#include "core/detector_parts.h"
#include "external/external_config.h"
#include "external/line_process.h"

namespace saccade {

/// A detector in a program of its own, by the protocol of docs/external_detectors.md. Simulated time waits for its
/// answers. A crash, an answer that is no estimate, or an answer after the time limit ends it: from then on it has no
/// estimate, and failure() says why. Nothing else is affected.
class ExternalDetector final : public Detector {
 public:
  /// Starts the program or connects to it, and waits for its line `ready`. `name`: for messages. Throws RunError, and ends
  /// the program, where that line does not come.
  ExternalDetector(std::string name, const LineProcess::Place& place, const AnswerLimits& limits,
                   const Camera& camera);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override;
  /// Exchanges what came since the last call with the program.
  [[nodiscard]] Estimate estimate() override;
  [[nodiscard]] double threshold() const override { return threshold_; }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  [[nodiscard]] std::string_view failure() const override { return failure_; }

 private:
  void start(const AnswerLimits& limits, const Camera& camera);
  void write_tick();
  void write_motion();
  void fail(LineProcess::Status status, const std::string& moment, std::chrono::milliseconds limit);

  std::string name_;
  LineProcess process_;
  EventSieve sieve_;
  std::chrono::milliseconds answer_limit_;
  double threshold_ = 0.0;
  bool binary_ = false;
  bool wants_motion_ = false;

  std::vector<Event> events_;  // since the last exchange
  std::int64_t now_us_ = 0;
  std::optional<CameraMotion> motion_;
  bool changed_ = false;  // since the last exchange
  std::string message_;
  std::string answer_;
  Estimate estimate_;
  std::string failure_;
};

/// What a program answers, see docs/external_detectors.md.
struct ReadyLine {
  double threshold = 0.0;
  bool binary = false;  ///< events as records of 16 bytes instead of lines
  bool motion = false;  ///< a line of motion in each tick
};
/// None where the line is no such answer.
[[nodiscard]] std::optional<ReadyLine> parse_ready(std::string_view line);
[[nodiscard]] std::optional<Estimate> parse_estimate(std::string_view line);

}  // namespace saccade
