// The least that uses saccade::emulator.
#include <saccade/emulator/event_emulator.h>

#include <cstdio>
#include <vector>

int main() {
  saccade::EventEmulator camera(saccade::emulator_preset("dvs128"), {2, 2}, 1);
  std::vector<saccade::Event> events;
  camera.process_image(std::vector<float>{50.0F, 50.0F, 50.0F, 50.0F}, 0, events);
  camera.process_image(std::vector<float>{50.0F, 50.0F, 200.0F, 50.0F}, 10000, events);
  camera.finish(events);
  std::printf("emulator: %zu events\n", events.size());
}
