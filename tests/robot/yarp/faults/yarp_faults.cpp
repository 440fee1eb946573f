// Random faults over YARP: SACCADE ROBOT.yaml COUNT [SEED] [KIND]. In each trial `saccade deploy` moves a peer robot (a
// camera and a control board in processes of their own) beside `saccade guard`, which it requires; then one fault comes at
// a random instant. Prints the times from the fault to the newest reference and to the rest of the joints. Status 1 if the
// head was not stopped, if a reference came later, for a wrong cause in the log, or if something stopped the head that must not.
#include <fmt/format.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "apps/deploy/shared_memory.h"
#include "core/random.h"
#include "tests/robot/yarp/faults/yarp_trial.h"

namespace saccade {
namespace {

struct Class {
  int trials = 0;
  std::vector<double> stop_ms, rest_ms;
  int late = 0;
  int unsafe = 0;
};

double quantile(std::vector<double>& ms, double share) {
  std::ranges::sort(ms);
  const auto at = static_cast<std::size_t>(share * static_cast<double>(ms.size()));
  return ms[std::min(at, ms.size() - 1)];
}

std::string figures(std::vector<double>& ms) {
  if (ms.empty()) return "- | - | -";
  return fmt::format("{:.1f} | {:.1f} | {:.1f}", quantile(ms, 0.5), quantile(ms, 0.99), quantile(ms, 1.0));
}

volatile std::sig_atomic_t interrupted = 0;

}  // namespace
}  // namespace saccade

int main(int count_of_arguments, char** arguments) {
  using namespace saccade;
  if (count_of_arguments < 4) {
    fmt::print(stderr, "usage: saccade_yarp_faults SACCADE ROBOT.yaml COUNT [SEED] [KIND]\n");
    return 2;
  }
  const int count = std::atoi(arguments[3]);
  const std::uint64_t seed = count_of_arguments > 4 ? std::strtoull(arguments[4], nullptr, 10) : 1;
  std::vector<YarpFault> kinds;
  for (const YarpFault& fault : yarp_faults()) {
    if (count_of_arguments <= 5 || fault.name == std::string(arguments[5])) kinds.push_back(fault);
  }
  if (kinds.empty()) {
    fmt::print(stderr, "saccade_yarp_faults: KIND: found {}, expected one of:\n", arguments[5]);
    for (const YarpFault& fault : yarp_faults()) fmt::print(stderr, "  {}\n", fault.name);
    return 2;
  }
  const RandomStream random(seed, "faults over YARP");
  YarpTrials trials(arguments[1], arguments[2]);
  std::map<std::string, Class> classes;
  int unsafe = 0;
  int stopped_before = 0;
  std::signal(SIGINT, [](int) { interrupted = 1; });  // the figures so far
  int trial = 0;
  for (; trial < count && interrupted == 0; ++trial) {
    const YarpFault& kind = kinds[static_cast<std::size_t>(trial) % kinds.size()];
    YarpTrialResult result;
    do {
      const double wait_s = random.uniform(0.1, 0.5, 0, static_cast<std::uint64_t>(trial));
      result = trials.run(kind, wait_s);
      if (result.stopped_before) ++stopped_before;
    } while (result.stopped_before && result.problem.empty() && stopped_before < 20 + count);
    Class& found = classes[kind.name];
    ++found.trials;
    if (result.stop_ms) found.stop_ms.push_back(*result.stop_ms);
    if (result.rest_ms) found.rest_ms.push_back(*result.rest_ms);
    if (result.stop_ms && *result.stop_ms > 100.0) ++found.late;
    if (result.problem.empty()) continue;
    ++found.unsafe;
    ++unsafe;
    fmt::print("trial {}, {}: {}\n", trial, kind.name, result.problem);
    std::fflush(stdout);
  }
  fmt::print(
      "{} faults over YARP, seed {}; {} more runs were stopped before their fault, by a late tick or "
      "reference. From the "
      "fault, ms.\n\n"
      "| fault | trials | newest reference, median | 99 % | worst | above 100 ms | joints at rest, median | "
      "99 % | "
      "worst | unsafe |\n|---|---|---|---|---|---|---|---|---|---|\n",
      trial, seed, stopped_before);
  for (auto& [name, found] : classes) {
    fmt::print("| {} | {} | {} | {} | {} | {} |\n", name, found.trials, figures(found.stop_ms), found.late,
               figures(found.rest_ms), found.unsafe);
  }
  return unsafe == 0 ? 0 : 1;
}
