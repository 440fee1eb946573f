#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "recording/other_records.h"

namespace saccade {

/// What a decoder of a sensor's words has done in one call.
struct EvtStep {
  std::size_t words = 0;   ///< decoded
  std::size_t events = 0;  ///< written
};

/// Words that are left out.
struct EvtCounts {
  std::int64_t events_without_time = 0;      ///< before the first time stamp
  std::int64_t triggers = 0;                 ///< that nobody wants, or before the first time stamp
  std::int64_t other_words = 0;              ///< of defined types that are no events
  std::array<std::int64_t, 16> undefined{};  ///< of types that the encoding does not define, by type

  EvtCounts& operator+=(const EvtCounts& other);
};

/// Passes triggers on to who wants them, else counts them.
class EvtTriggers {
 public:
  void pass_to(OtherRecords* others, std::string source) {
    others_ = others != nullptr && others->wants_triggers() ? others : nullptr;
    source_ = std::move(source);
  }
  void found(std::int64_t t_us, unsigned channel, bool rising, EvtCounts& counts) const {
    if (others_ == nullptr) {
      ++counts.triggers;
    } else {
      others_->add(RecordedTrigger{t_us, static_cast<int>(channel),
                                   rising ? TriggerKind::rising : TriggerKind::falling, source_});
    }
  }

 private:
  OtherRecords* others_ = nullptr;
  std::string source_;
};

/// Appends "3 triggers, 1 words of the undefined type 9" to a list of what a reader skipped.
void append_counts(std::string& text, const EvtCounts& counts);

}  // namespace saccade
