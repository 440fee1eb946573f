#include "apps/session/interrupt.h"

#include <csignal>

namespace saccade::inline v0_1 {
namespace {

volatile std::sig_atomic_t flag = 0;  // the one global: signals have no other way in

extern "C" void on_signal(int number) {
  if (flag != 0) {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
  flag = 1;
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

bool interrupted() { return flag != 0; }

}  // namespace saccade::inline v0_1
