#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace saccade {

/// A file in /dev/shm that several processes map: `saccade-<name>`, with `/` as `_`. Zero when new; stays after the last
/// process. Its content survives a killed process. Every user may open and write it, whoever created it.
class SharedMemory {
 public:
  /// Opens or creates it, `size` bytes. Throws RunError; where another user's file cannot be used, it names that user.
  SharedMemory(const std::string& name, std::size_t size);
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  ~SharedMemory();

  [[nodiscard]] void* data() const { return data_; }
  /// Holds the file for this process alone until its end, however it ends. Returns false if another process holds it.
  [[nodiscard]] bool lock();

 private:
  int file_ = -1;
  std::size_t size_;
  void* data_ = nullptr;
};

/// The clock that all processes of a machine share, ns (CLOCK_MONOTONIC).
[[nodiscard]] std::int64_t machine_ns();

}  // namespace saccade
