// The least that uses saccade::sim.
#include <saccade/sim/data_directory.h>
#include <saccade/sim/lab.h>

#include <cstdio>
#include <filesystem>

int main() {
  const saccade::Lab lab(saccade::LabConfig{}, 1);
  std::printf("sim: %zu bytes of furniture\n", lab.mjcf().size());
}
