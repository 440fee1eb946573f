#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "robot/robot.h"

namespace saccade {

/// The guard's connection to the head. While it is lost, a thread of its own closes it and makes it again until the head
/// answers, so that the guard's looks do not wait for the network. Used from one thread.
class GuardHead {
 public:
  using Open = std::function<std::unique_ptr<HeadStopper>()>;
  /// Opens the first connection and throws as `open` does; later failures are repeated every `retry`. A connection without
  /// an answer for `patience` is made again.
  explicit GuardHead(Open open, std::chrono::milliseconds patience = std::chrono::milliseconds(1000),
                     std::chrono::milliseconds retry = std::chrono::milliseconds(1000));
  GuardHead(const GuardHead&) = delete;
  GuardHead& operator=(const GuardHead&) = delete;
  /// Waits until the connection is closed.
  ~GuardHead();

  /// Whether a stop would reach the head now.
  [[nodiscard]] bool is_connected();
  /// HeadStopper::stop; false without a connection.
  bool stop();
  /// Why the newest attempt to make the connection again failed; empty if none did.
  [[nodiscard]] std::string problem();

 private:
  void renew();

  Open open_;
  std::chrono::milliseconds patience_, retry_;
  std::unique_ptr<HeadStopper> head_;  // of the thread while renewing_, else of the guard
  std::int64_t heard_ns_;              // when the head was connected last
  std::mutex mutex_;                   // of what follows
  std::condition_variable changed_;
  bool renewing_ = false;
  bool over_ = false;
  std::string problem_;
  std::thread thread_;
};

}  // namespace saccade
