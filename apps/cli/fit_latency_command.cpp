#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "config/latency_section.h"
#include "config/scenario.h"
#include "recording/output_file.h"
#include "session/fit_latency.h"
#include "session/interrupt.h"
#include "session/scenario_loop.h"

namespace saccade {
namespace {

struct FitLatencyOptions {
  std::filesystem::path scenario = "scenarios/gaze_square_45cm.yaml";
  std::filesystem::path out = "latency.yaml";
  std::optional<std::int64_t> seed;
  std::vector<std::string> assignments;
  bool force = false;
};

int fit(const FitLatencyOptions& options, const Registry& registry) {
  if (std::filesystem::exists(options.out) && !options.force)
    throw InputError(options.out.string(), "a file that exists", "a new name, or --force");
  const Scenario scenario = read_scenario(options.scenario, options.assignments, options.seed, registry);
  set_rasterisers(scenario.run.threads);
  catch_interrupts();
  const LatencyConfig latency = fit_latency(scenario);
  write_file(options.out, latency_yaml(latency));
  fmt::print("{:<24}{:>12}{:>12}\n", "", "us a call", "us an event");
  for (const auto& [name, work] : latency.detectors)
    fmt::print("{:<24}{:>12.2f}{:>12.4f}\n", name, work.per_call_us, work.per_event_us);
  fmt::print("{:<24}{:>12.2f}\n{}\n", "controller", latency.controller_us, options.out.string());
  return 0;
}

}  // namespace

void add_fit_latency_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<FitLatencyOptions>();
  Command command = line.add_command(
      "fit-latency", "Processing times of detectors and controller on this machine, for latency.kind: model");
  command.option("scenario", options->scenario, "Scenario with the detectors; it runs without its latency")
      .show_default()
      .offers_scenarios();
  command.option("--out", options->out, "The file (YAML), for a scenario's latency.file").show_default();
  command.option("--seed", options->seed, "Seed, instead of the scenario's");
  command.option("--set", options->assignments, "key.path=value, instead of the scenario's").one_value_each();
  command.flag("--force", options->force, "Replace the file at --out");
  command.action([options, &registry] { return fit(*options, registry); });
}

}  // namespace saccade
