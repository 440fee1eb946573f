// Prints the resident memory of loop, tables and scores over many ticks of the fake robot: one line of comma-separated
// values per million ticks. saccade_endurance [TICKS], by default 36 million: ten hours at 1 kHz.
#include <cstdio>
#include <cstdlib>

#include "tests/session/run_over_ticks.h"

int main(int argc, char** argv) {
  const std::int64_t ticks = argc > 1 ? std::atoll(argv[1]) : 36'000'000;
  std::printf("ticks,rss_kb\n");
  saccade::run_over_ticks(ticks, 1'000'000, [](std::int64_t done) {
    std::printf("%lld,%lld\n", static_cast<long long>(done), static_cast<long long>(saccade::resident_kb()));
    std::fflush(stdout);
  });
  return 0;
}
