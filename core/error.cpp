#include "core/error.h"

#include <cstdio>
#include <cstdlib>

namespace saccade {
namespace {

std::string join(const std::vector<Problem>& problems) {
  std::string text;
  for (const Problem& problem : problems) {
    if (!text.empty()) text += '\n';
    text += problem.text();
  }
  return text;
}

}  // namespace

std::string Problem::text() const {
  std::string line = place;
  if (!value.empty()) line += ": found " + value;
  return line + (value.empty() ? ": expected " : ", expected ") + expectation;
}

InputError::InputError(std::vector<Problem> problems)
    : std::runtime_error(join(problems)), problems_(std::move(problems)) {}

InputError::InputError(std::string place, std::string value, std::string expectation)
    : InputError(std::vector<Problem>{{std::move(place), std::move(value), std::move(expectation)}}) {}

void abort_broken_invariant(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "saccade: broken invariant at %s:%d: %s\n", file, line, condition);
  std::abort();
}

}  // namespace saccade
