#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace saccade {

/// One problem in the input.
struct Problem {
  std::string place;        ///< file, line and key, or file and byte offset
  std::string value;        ///< what was found there; empty if the input is missing
  std::string expectation;  ///< what was expected instead

  /// "place: found VALUE, expected EXPECTATION"
  [[nodiscard]] std::string text() const;
};

/// Bad input or usage, with every problem that was found.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::vector<Problem> problems);
  InputError(std::string place, std::string value, std::string expectation);

  [[nodiscard]] const std::vector<Problem>& problems() const { return problems_; }

 private:
  std::vector<Problem> problems_;
};

/// The run cannot continue: no OpenGL, a full disk, an unstable simulation.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

[[noreturn]] void abort_broken_invariant(const char* condition, const char* file, int line);

}  // namespace saccade

/// Checks an invariant in every build. Aborts with file and line if it does not hold.
#define SACCADE_CHECK(condition) \
  (static_cast<bool>(condition) ? void(0) : ::saccade::abort_broken_invariant(#condition, __FILE__, __LINE__))
