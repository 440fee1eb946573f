// A helper process as helper_reader_test needs it: sends COUNT events and then fails in the way that HOW names, or fails
// when it opens the recording. usage: saccade_fragile_reader COUNT HOW [SECONDS]
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <new>
#include <string>

#include "core/error.h"
#include "recording/helper_server.h"
#include "tests/recording/counting_reader.h"

namespace {

void fail(const std::string& how) {
  if (how == "segv") ::kill(::getpid(), SIGSEGV);
  if (how == "bus") ::kill(::getpid(), SIGBUS);
  if (how == "abort") std::abort();
  if (how == "exit") ::_exit(7);
  if (how == "hang") {
    for (;;) ::pause();
  }
  if (how == "bad input") throw saccade::InputError("a.h5: event 9", "rubbish", "sense");
  if (how == "no memory") throw std::bad_alloc();
  if (how == "nonsense") {
    const std::string bytes(1000, '\x7f');
    (void)!::write(STDOUT_FILENO, bytes.data(), bytes.size());
    ::_exit(0);
  }
}

}  // namespace

int main(int argc, char** argv) {
  using namespace saccade;
  if (argc < 3) return 2;
  const long count = std::atol(argv[1]);
  const std::string how = argv[2];
  const std::string open = "open: ";
  const auto opened = [&]() -> std::unique_ptr<EventReader> {
    if (how.starts_with(open)) fail(how.substr(open.size()));
    return std::make_unique<CountingReader>(count, [&] { fail(how); });
  };
  serve_events(STDOUT_FILENO, opened, argc > 3 ? static_cast<unsigned>(std::atoi(argv[3])) : 60);
}
