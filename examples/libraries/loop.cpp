// The least that uses saccade::loop.
#include <saccade/loop/run_log.h>

#include <cstdio>

int main() {
  saccade::RunLog log([](std::int64_t, const std::string& text) { std::printf("%s\n", text.c_str()); });
  log.finish();
  std::printf("loop: a log\n");
}
