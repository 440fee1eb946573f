#include "recording/evt_counts.h"

#include "recording/codec.h"

namespace saccade {

EvtCounts& EvtCounts::operator+=(const EvtCounts& other) {
  events_without_time += other.events_without_time;
  triggers += other.triggers;
  other_words += other.other_words;
  for (std::size_t type = 0; type < undefined.size(); ++type) undefined[type] += other.undefined[type];
  return *this;
}

void append_counts(std::string& text, const EvtCounts& counts) {
  append_count(text, counts.events_without_time, "events before the first time stamp");
  append_count(text, counts.triggers, "triggers");
  append_count(text, counts.other_words, "words that are no events");
  for (std::size_t type = 0; type < counts.undefined.size(); ++type) {
    append_count(text, counts.undefined[type],
                 std::string("words of the undefined type ") + "0123456789ABCDEF"[type]);
  }
}

}  // namespace saccade
