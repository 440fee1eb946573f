// The least that uses saccade::config.
#include <saccade/config/scenario.h>
#include <saccade/core/detectors/built_in_detectors.h>

#include <cstdio>

int main() {
  saccade::Registry registry;
  registry.detectors = saccade::built_in_detectors();
  registry.controllers = saccade::built_in_controllers();
  registry.gates = saccade::built_in_gates();
  registry.formats = saccade::built_in_formats();
  const saccade::Scenario scenario = saccade::read_scenario("look_at_ball", {}, 7, registry);
  std::printf("config: %s, seed %d\n", scenario.name.c_str(), static_cast<int>(scenario.seed));
}
