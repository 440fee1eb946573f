// The program `saccade` with one more gaze controller, `proportional`.
#include "apps/cli/program.h"
#include "proportional_controller.h"

int main(int argc, char** argv) {
  saccade::Registry registry = saccade::built_in_registry();
  registry.controllers.add(saccade::controller_row(
      "proportional", "eyes alone, speed proportional to the gaze error", example::ProportionalConfig{},
      [](const example::ProportionalConfig& config, const saccade::MotionLimits& limits) {
        return std::make_unique<example::ProportionalController>(config, limits);
      }));
  return saccade::program(argc, argv, registry);
}
