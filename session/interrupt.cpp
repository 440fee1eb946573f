#include "session/interrupt.h"

#include <fcntl.h>
#include <unistd.h>

#include <csignal>
#include <initializer_list>

namespace saccade {
namespace {

volatile std::sig_atomic_t flag = 0;                          // global: signals have no other way in
volatile std::sig_atomic_t null_device = -1;                  // /dev/null, open
volatile std::sig_atomic_t writes_to_terminal[] = {0, 0, 0};  // by file: of standard output and error

extern "C" void on_signal(int number) {
  if (number == SIGHUP) {
    // The terminal, and the programs that a pipe led to, are gone: writing to them must not end the run.
    for (const int file : {STDOUT_FILENO, STDERR_FILENO}) {
      if (writes_to_terminal[file] != 0 && null_device >= 0) ::dup2(null_device, file);
    }
    std::signal(SIGPIPE, SIG_IGN);
  } else if (flag != 0) {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
  flag = 1;
}

}  // namespace

void catch_interrupts() {
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  if (null_device < 0) null_device = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  for (const int file : {STDOUT_FILENO, STDERR_FILENO}) writes_to_terminal[file] = ::isatty(file);
  if (std::signal(SIGHUP, on_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

bool interrupted() { return flag != 0; }

}  // namespace saccade
