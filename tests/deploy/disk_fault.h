#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "apps/deploy/deploy_recorder.h"
#include "config/robot_file.h"
#include "tests/deploy/fault_kinds.h"

namespace saccade {

/// A recording (DeployRecorder) on a disk that is full, slow or fails after some hundred ticks. Files are in a folder of
/// their own, which is removed at the end.
class DiskFault {
 public:
  /// `loop` outlives it.
  DiskFault(FaultKind kind, const Loop& loop, std::uint64_t number);
  DiskFault(const DiskFault&) = delete;
  DiskFault& operator=(const DiskFault&) = delete;
  ~DiskFault();

  [[nodiscard]] DeployObserver& observer() { return *recorder_; }
  /// After the last tick: what the recording did wrong; empty if nothing.
  [[nodiscard]] std::string problem();

 private:
  /// Discards what this process prints, for its lifetime.
  class Quiet {
   public:
    Quiet();
    Quiet(const Quiet&) = delete;
    Quiet& operator=(const Quiet&) = delete;
    ~Quiet();

   private:
    int out_, error_;
  };

  Quiet quiet_;
  FaultKind kind_;
  std::filesystem::path folder_;
  RobotFile file_;
  std::unique_ptr<DeployRecorder> recorder_;
};

}  // namespace saccade
