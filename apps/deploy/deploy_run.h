#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/live/live_server.h"

namespace saccade {

struct Registry;

/// How deploy() runs.
struct DeployOptions {
  std::filesystem::path robot;           ///< robot file
  std::filesystem::path out;             ///< run folder; empty: runs/NAME
  std::vector<std::string> assignments;  ///< overrides of the robot file
  std::optional<double> duration_s;      ///< none: until the operator quits or the recording ends
  bool dry_run = false;                  ///< nothing is sent to the head
  bool record = false;                   ///< events and joints into the run folder too
  bool activate = false;                 ///< the head moves as soon as it is ready, without a key
  std::optional<LiveAddress> web;        ///< of the live page; none: there is none
  bool force = false;                    ///< replace an earlier run in that folder
};

/// The loop in real time on a robot, into a run folder: opens and checks the robot, ticks under an operator's keys until
/// the end, releases the head, writes the report. Throws InputError; RunError if a start-up check fails, if another deploy
/// moves the head, if the head was not activated on request, or if a fault stopped it and it stayed stopped.
void deploy(const DeployOptions& options, const Registry& registry);

}  // namespace saccade
