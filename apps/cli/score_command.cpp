#include <cmath>
#include <memory>

#include "apps/cli/commands.h"
#include "core/error.h"
#include "recording/number_text.h"
#include "session/score_detections.h"

namespace saccade {
namespace {

struct ScoreOptions {
  ScoreSettings settings;
  std::vector<std::string> thresholds;
};

/// NAME=V
void add_threshold(const std::string& text, ScoreSettings& settings) {
  const std::size_t equals = text.find('=');
  double threshold = 0.0;
  if (equals == std::string::npos || equals == 0 ||
      !parse_number(std::string_view(text).substr(equals + 1), threshold) || !std::isfinite(threshold)) {
    throw InputError("--threshold", text, "NAME=V, a detector and a number, such as mine=0.5");
  }
  settings.thresholds[text.substr(0, equals)] = threshold;
}

}  // namespace

void add_score_command(CommandLine& line) {
  auto options = std::make_shared<ScoreOptions>();
  ScoreSettings& settings = options->settings;
  Command command = line.add_command("score", "Detections made elsewhere scored against ground truth");
  command.option("detections", settings.detections, "Table t_us,detector,x_px,y_px,r_px,score[,held] (CSV)")
      .required();
  command.option("--truth", settings.truth, "True circles, t_us,x_px,y_px,r_px[,visible,...] (CSV)")
      .required();
  command
      .option("--threshold", options->thresholds,
              "NAME=V: the score from which on detector NAME reports a ball; without it figures at the "
              "threshold are unknown")
      .one_value_each();
  command.flag("--json", settings.json, "As JSON, the detectors of metrics.json");
  command.footer(
      "Truth with rows 1 ms apart is scored as a simulation's: a detection at any other instant is false. Of "
      "other truth the annotated instants alone count. docs/scoring.md defines the figures.");
  command.action([options] {
    for (const std::string& threshold : options->thresholds) add_threshold(threshold, options->settings);
    score_detections(options->settings);
    return 0;
  });
}

}  // namespace saccade
