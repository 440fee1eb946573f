// What docs/safety.md says of faults of processes, one by one; the campaign draws them at random.
#include "tests/deploy/fault_trial.h"

#include <gtest/gtest.h>

#include "tests/control/genova02.h"

namespace saccade {
namespace {

Faults no_faults() {
  Faults faults;
  faults.script.limits = genova02_limits();
  return faults;
}

TEST(FaultCampaign, SigcontNeverMovesTheHeadAgain) {
  for (std::int64_t halt_us = 40'000; halt_us <= 1'000'000; halt_us += 37'000) {
    for (const bool with_gaze : {false, true}) {
      Faults faults = no_faults();
      faults.halted_us = {700'000 + halt_us / 100, 700'000 + halt_us / 100 + halt_us};
      faults.list = {{FaultKind::deploy_halted, faults.halted_us->first}};
      const TrialResult result = run_trial(faults, with_gaze, 0);
      EXPECT_EQ(result.problem, "") << halt_us;
      EXPECT_TRUE(result.stops) << halt_us;
      EXPECT_LE(result.stop_ms, 40.0) << halt_us;
    }
  }
}

TEST(FaultCampaign, AKilledDeployIsStoppedByItsGuardWithin40Ms) {
  for (std::int64_t at_us = 500'000; at_us < 520'000; at_us += 700) {
    Faults faults = no_faults();
    faults.killed_us = at_us;
    faults.list = {{FaultKind::deploy_killed, at_us}};
    const TrialResult result = run_trial(faults, false, 0);
    EXPECT_EQ(result.problem, "") << at_us;
    EXPECT_GT(result.stop_ms, 30.0) << "not before the bound";
    EXPECT_LE(result.stop_ms, 40.0) << at_us;
  }
}

TEST(FaultCampaign, AGuardAndADeployThatDieTogetherLeaveNobodyWhoStopsTheHead) {
  Faults faults = no_faults();
  faults.killed_us = 500'000;
  faults.guard_killed_us = 490'000;
  faults.list = {{FaultKind::guard_killed, 490'000}, {FaultKind::deploy_killed, 500'000}};
  EXPECT_EQ(run_trial(faults, false, 0).problem, "no stop") << "the limit that docs/safety.md states";
}

}  // namespace
}  // namespace saccade
