// The registries of gaze controllers and gates.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "control/continuity_gate.h"
#include "control/controller_registry.h"
#include "control/gate_registry.h"
#include "control/qp_controller.h"
#include "core/error.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ControllerRegistry, HoldsTheShippedControllersAndStartsWithTheFirst) {
  const ControllerRegistry registry = built_in_controllers();
  EXPECT_THAT(registry.rows().names(), ElementsAre("qp", "ikingaze", "script"));
  EXPECT_EQ(registry.config().controller, "qp");
  for (const GazeControllerRow& row : registry.rows()) {
    GazeControllerConfig config = registry.config();
    config.controller = row.name;
    EXPECT_NE(make_gaze_controller(config, genova02_limits()), nullptr) << row.name;
    EXPECT_EQ(config.follows_targets(), row.name != "script");
  }
}

TEST(ControllerRegistry, NamesItsControllersWhereAnotherIsAskedFor) {
  GazeControllerConfig config = built_in_controllers().config();
  config.controller = "by hand";
  EXPECT_THAT(message_of([&] { (void)make_gaze_controller(config, genova02_limits()); }),
              HasSubstr("gaze.controller: found by hand, expected one of qp, ikingaze, script"));
}

TEST(ControllerRegistry, MakesAControllerOfAProgramWithItsOwnDefaults) {
  ControllerRegistry registry = built_in_controllers();
  QpConfig slow;
  slow.eye_time_constant_s = 1.0;
  double made_with_s = 0.0;
  registry.add(
      controller_row("slow", "for this test", slow, [&](const QpConfig& config, const MotionLimits& limits) {
        made_with_s = config.eye_time_constant_s;
        return std::make_unique<QpController>(config, limits);
      }));
  GazeControllerConfig config = registry.config();
  config.controller = "slow";
  EXPECT_NE(make_gaze_controller(config, genova02_limits()), nullptr);
  EXPECT_EQ(made_with_s, 1.0);
  EXPECT_THROW(registry.add(controller_row("slow", "again", slow,
                                           [](const QpConfig& keys, const MotionLimits& limits) {
                                             return std::make_unique<QpController>(keys, limits);
                                           })),
               InputError);
}

TEST(GateRegistry, HoldsTheShippedGatesAndStartsWithItsDefault) {
  const GateRegistry registry = built_in_gates();
  EXPECT_THAT(registry.rows().names(), ElementsAre("none", "authors", "continuity"));
  EXPECT_EQ(registry.config().gate, "continuity");
  for (const GateRow& row : registry.rows()) {
    GateConfig config = registry.config();
    config.gate = row.name;
    EXPECT_NE(make_gate(config), nullptr) << row.name;
  }
}

TEST(GateRegistry, NamesItsGatesWhereAnotherIsAskedFor) {
  GateConfig config = built_in_gates().config();
  config.gate = "sometimes";
  EXPECT_THAT(message_of([&] { (void)make_gate(config); }),
              HasSubstr("gaze.gate: found sometimes, expected one of none, authors, continuity"));
}

TEST(GateConfig, KeepsItsValuesApartFromThoseOfItsCopy) {
  GateConfig config = built_in_gates().config();
  GateConfig copy = config;
  config.get<ContinuityGateConfig>().forget_s = 9.0;
  EXPECT_EQ(copy.get<ContinuityGateConfig>().forget_s, ContinuityGateConfig{}.forget_s);
}

}  // namespace
}  // namespace saccade
