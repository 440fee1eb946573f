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

}  // namespace saccade
