// Prints the resident memory of loop, tables and scores over many ticks of the fake robot: one line of comma-separated
// values per SAMPLE ticks. saccade_endurance [TICKS [SAMPLE]], by default 36 million, ten hours at 1 kHz, and a million.
#include <cstdio>
#include <cstdlib>

#include "tests/session/run_over_ticks.h"

int main(int argc, char** argv) {
  const std::int64_t ticks = argc > 1 ? std::atoll(argv[1]) : 36'000'000;
  const std::int64_t sample = argc > 2 ? std::atoll(argv[2]) : 1'000'000;
  std::printf("ticks,rss_kb\n");
  saccade::run_over_ticks(ticks, sample, [](std::int64_t done) {
    std::printf("%lld,%lld\n", static_cast<long long>(done), static_cast<long long>(saccade::resident_kb()));
    std::fflush(stdout);
  });
  return 0;
}
