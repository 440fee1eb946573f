#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/error.h"
#include "recording/event_file.h"
#include "recording/input_file.h"

namespace saccade {

/// Base of the readers of binary files: they decode block by block, and return the events before a broken place before the
/// error.
class BlockReader : public EventReader {
 public:
  explicit BlockReader(InputFile file) : file_(std::move(file)), block_(block_events) {}

  std::size_t read(std::vector<Event>& events, std::size_t max_events) final;
  [[nodiscard]] std::optional<std::uint64_t> broken_record() const final {
    return record_.value_or(file_.offset());
  }

 protected:
  static constexpr std::size_t block_events = 4096;

  /// Takes bytes from file_ and puts the events that they are into `block`, which holds block_events; `count`
  /// is 0 before and how many there are afterwards, also where it throws. False at the end of the file. Throws
  /// InputError where the content is broken; it is not called again then.
  virtual bool decode(std::span<Event> block, std::size_t& count) = 0;

  /// Where a record longer than a decoded block begins, for broken_record(): here.
  void begin_record() { record_ = file_.offset(); }

  InputFile file_;

 private:
  std::vector<Event> block_;  ///< those in [begin_, end_) not yet read
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  bool over_ = false;
  std::optional<std::uint64_t> record_;
  std::optional<InputError> failure_;
};

}  // namespace saccade
