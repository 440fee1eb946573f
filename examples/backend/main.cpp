// The program `saccade` with one more backend, `circle`.
#include "apps/cli/program.h"
#include "circle_robot.h"

int main(int argc, char** argv) {
  saccade::Registry registry = saccade::built_in_registry();
  registry.backends.add(saccade::backend_row(
      "circle", "a disc that moves along a circle", example::CircleRobotConfig{},
      [](const example::CircleRobotConfig& config, const saccade::RobotContext& context) {
        return std::make_unique<example::CircleRobot>(config, context);
      }));
  return saccade::program(argc, argv, registry);
}
