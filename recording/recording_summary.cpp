#include "recording/recording_summary.h"

#include <vector>

namespace saccade {

RecordingSummary summarise_recording(const FormatRegistry& formats, const std::filesystem::path& recording,
                                     const EventReadOptions& options, std::int64_t gap_us,
                                     const std::function<void(std::int64_t)>& progress) {
  const auto reader = open_event_file(formats, recording, options);
  RecordingSummary summary{recording.string(),
                           reader->format(),
                           {},
                           reader->image_size(),
                           EventCounter(reader->image_size(), gap_us)};
  constexpr std::size_t block_events = 1 << 16;
  std::vector<Event> block;
  for (block.reserve(block_events); reader->read(block, block_events) > 0; block.clear()) {
    summary.counter.add(block);
    if (progress) progress(summary.counter.all().count);
  }
  summary.skipped = reader->skipped();
  return summary;
}

}  // namespace saccade
