#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "recording/output_file.h"

namespace saccade {

/// The log of a run, log.txt: one line per message with its time in seconds, written to the file and to an echo.
class LogFile {
 public:
  /// `echo` receives each line, without line end, as soon as it is written. Throws RunError if the file cannot be
  /// written, as do the others.
  LogFile(const std::filesystem::path& file, std::function<void(const std::string&)> echo);

  void write(std::int64_t t_us, const std::string& text);
  /// Closes the file under its final name.
  void commit() { file_.commit(); }

 private:
  OutputFile file_;
  std::function<void(const std::string&)> echo_;
};

}  // namespace saccade
