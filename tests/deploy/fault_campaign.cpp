// Seeded random faults of a deployed robot in virtual time: COUNT [SEED] [TABLE.md]. Prints a table of the times to the
// safe state by class of fault. Status 1 if a fault was not answered as docs/safety.md says.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "core/random.h"
#include "tests/deploy/fault_kinds.h"
#include "tests/deploy/fault_trial.h"

namespace saccade {
namespace {

struct Class {
  int faults = 0;
  std::vector<double> stop_ms;
  int unsafe = 0;
};

std::string table_of(std::map<std::string, Class>& classes, std::uint64_t count, std::uint64_t seed) {
  std::string table = fmt::format(
      "{} random faults, seed {}, virtual time. From the fault to the stop command, ms.\n\n"
      "| class | faults | stops | median | 99.9 % | worst | unsafe |\n|---|---|---|---|---|---|---|\n",
      count, seed);
  for (auto& [name, found] : classes) {
    std::ranges::sort(found.stop_ms);
    const auto quantile = [&stop_ms = found.stop_ms](double share) {
      const auto at = static_cast<std::size_t>(share * static_cast<double>(stop_ms.size()));
      return stop_ms.empty() ? 0.0 : stop_ms[std::min(at, stop_ms.size() - 1)];
    };
    table += fmt::format("| {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {} |\n", name, found.faults,
                         found.stop_ms.size(), quantile(0.5), quantile(0.999), quantile(1.0), found.unsafe);
  }
  return table;
}

}  // namespace
}  // namespace saccade

int main(int count_of_arguments, char** arguments) {
  using namespace saccade;
  const std::uint64_t count = count_of_arguments > 1 ? std::strtoull(arguments[1], nullptr, 10) : 1000;
  const std::uint64_t seed = count_of_arguments > 2 ? std::strtoull(arguments[2], nullptr, 10) : 1;
  const RandomStream random(seed, "fault campaign");
  std::map<std::string, Class> classes;
  int unsafe = 0;
  for (std::uint64_t number = 0; number < count; ++number) {
    const Faults faults = make_faults(random, number);
    // With a gaze controller of the robot's own deploy sends no references to joints.
    const bool needs_joints = faults.has(FaultKind::joint_taken) || faults.has(FaultKind::command_refused) ||
                              faults.has(FaultKind::joint_stuck);
    const TrialResult result = run_trial(faults, !needs_joints && random.bits(4, number) % 4 == 0, number);
    Class& found = classes[faults.list.size() > 1 ? "several at once" : name_of(faults.list[0].first)];
    ++found.faults;
    if (result.stops) found.stop_ms.push_back(result.stop_ms);
    if (result.problem.empty()) continue;
    ++found.unsafe;
    if (++unsafe <= 20) fmt::print("fault {}: {}; {}\n", number, result.problem, faults.text());
  }
  const std::string table = table_of(classes, count, seed);
  fmt::print("{}", table);
  if (count_of_arguments > 3) std::ofstream(arguments[3]) << table;
  return unsafe == 0 ? 0 : 1;
}
