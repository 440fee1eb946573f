#pragma once

#include <stdexcept>
#include <string>
#include <vector>

namespace saccade {

/// One thing that is wrong with what a user gave us.
struct Problem {
  std::string place;        ///< file, line and key, or file and byte offset
  std::string value;        ///< what was found there; empty where nothing was
  std::string expectation;  ///< what would have been right

  /// "place: found VALUE, expected EXPECTATION"
  [[nodiscard]] std::string text() const;
};

/// Bad input or usage, with every problem found at once. The command ends with status 2.
class InputError : public std::runtime_error {
 public:
  explicit InputError(std::vector<Problem> problems);
  InputError(std::string place, std::string value, std::string expectation);

  [[nodiscard]] const std::vector<Problem>& problems() const { return problems_; }

 private:
  std::vector<Problem> problems_;
};

/// The run itself failed (no OpenGL, a full disk, an unstable simulation). The command ends with status 1.
class RunError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

[[noreturn]] void abort_broken_invariant(const char* condition, const char* file, int line);

}  // namespace saccade

/// A promise inside the program: checked in every build, aborts with the place when broken.
#define SACCADE_CHECK(condition) \
  (static_cast<bool>(condition) ? void(0) : ::saccade::abort_broken_invariant(#condition, __FILE__, __LINE__))
