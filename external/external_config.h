#pragma once

#include <string>

#include "core/config.h"
#include "external/line_process.h"

namespace saccade {

/// Limits of the wall clock for a program.
struct AnswerLimits {
  double start_limit_s = 20.0;  ///< from the start of the program, or of the connection, to its line `ready`
  double answer_limit_s = 2.0;  ///< from a tick to its answer
};

/// A class written in Python: `detectors: {mine: {python: my_detector.py:Mine}}`, or the section `python` of
/// `gaze.controller: python`.
struct PythonConfig {
  std::string python;                            ///< FILE.py:CLASS
  std::string interpreter = "/usr/bin/python3";  ///< with NumPy
  std::string arguments;
  std::string folder;  ///< working directory; empty: that of this process
  AnswerLimits limits;
};

/// A program: `detectors: {mine: {command: ./mine}}`, or the section `command` of `gaze.controller: command`.
struct CommandConfig {
  std::string command;  ///< a path, or a name in PATH
  std::string arguments;
  std::string folder;  ///< working directory; empty: that of this process
  AnswerLimits limits;
};

/// A program that listens on a socket, on this machine or another one: `detectors: {mine: {socket: localhost:5000}}`, or
/// the section `socket` of `gaze.controller: socket`.
struct SocketConfig {
  std::string socket;
  AnswerLimits limits;
};

/// Keys: python, interpreter, arguments, folder, start_limit_s, answer_limit_s. A path is relative to the file that names
/// it; `folder` is by default the folder of the file that names the program, so that its arguments are relative to that too.
void describe(FieldVisitor& v, PythonConfig& config);
/// Keys: command, arguments, folder, start_limit_s, answer_limit_s; the same.
void describe(FieldVisitor& v, CommandConfig& config);
/// Keys: socket, start_limit_s, answer_limit_s.
void describe(FieldVisitor& v, SocketConfig& config);

/// How to start the program. Throws InputError for a configuration out of range and for a program, file or folder that does
/// not exist; `section`, such as "gaze.command.", goes before the key in its message.
[[nodiscard]] ProgramCall program_call(const PythonConfig& config, const std::string& section = "");
[[nodiscard]] ProgramCall program_call(const CommandConfig& config, const std::string& section = "");
/// Throws InputError for a configuration out of range.
[[nodiscard]] SocketAddress address_of(const SocketConfig& config);

}  // namespace saccade
