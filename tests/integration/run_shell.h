#pragma once

#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <string>

namespace saccade {

struct Outcome {
  int status = -1;   // as the shell has it; 128 when a signal ended it
  std::string text;  // standard output and error
};

inline Outcome run_shell(const std::string& command) {
  FILE* const pipe = popen(("{ " + command + " ; } 2>&1").c_str(), "r");
  Outcome outcome;
  std::array<char, 4096> buffer;
  while (std::size_t n = std::fread(buffer.data(), 1, buffer.size(), pipe))
    outcome.text.append(buffer.data(), n);
  const int status = pclose(pipe);
  outcome.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128;
  return outcome;
}

/// Starts a command in a process group of its own, sends `signal` to the group as soon as `condition`, a shell command,
/// succeeds, and waits for the end. The text is what the command had written into the file `console` by then; the
/// condition may read it. A command that ends earlier gets no signal.
inline Outcome signal_when(const std::string& condition, const std::string& signal,
                           const std::string& command, const std::string& console) {
  return run_shell(": > " + console + "; setsid " + command + " >> " + console + " 2>&1 & pid=$!; until " +
                   condition + " || ! kill -0 $pid; do sleep 0.02; done 2>/dev/null; kill -s " + signal +
                   " -- -$pid 2>/dev/null; wait $pid; status=$?; cat " + console + "; (exit $status)");
}

}  // namespace saccade
