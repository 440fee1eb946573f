// Scores detections against ground truth and prints one line per detector:
//   scoring_example detections.csv truth.csv [threshold]
// detections.csv: t_us,detector,x_px,y_px,r_px,score,held. truth.csv: t_us,x_px,y_px,r_px and, if known, visible and the
// ball's position. Truth with positions is taken for that of a simulation, at every millisecond; other truth for
// annotations of a recording.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <set>
#include <string>
#include <vector>

#include "evaluation/scoring/scoring.h"
#include "recording/run_files.h"

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    std::fprintf(stderr, "usage: scoring_example detections.csv truth.csv [threshold]\n");
    return 2;
  }
  try {
    const auto detections = saccade::read_table<saccade::DetectionRow>(argv[1]);
    const auto truth = saccade::read_table<saccade::TruthRow>(argv[2]);
    const double threshold = argc == 4 ? std::atof(argv[3]) : 0.0;
    const bool simulated = !truth.empty() && std::isfinite(truth.front().position_m.x());
    std::set<std::string> names;
    for (const saccade::DetectionRow& row : detections) names.insert(row.detector);
    for (const std::string& name : names) {
      const saccade::DetectorScore score =
          saccade::score_detector(truth, detections, name, threshold,
                                  simulated ? saccade::Chances::simulated : saccade::Chances::annotated);
      std::printf("%s: average precision %.3f, recall %.3f over %lld chances\n", name.c_str(),
                  score.average_precision.value_or(NAN), score.recall.value_or(NAN),
                  static_cast<long long>(score.chances));
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "scoring_example: %s\n", error.what());
    return 1;
  }
  return 0;
}
