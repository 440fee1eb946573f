// The least that uses saccade::recording.
#include <saccade/recording/format_registry.h>

#include <cstdio>

int main() {
  std::printf("recording: writes %s\n", saccade::built_in_formats().written_extensions().c_str());
}
