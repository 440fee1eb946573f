#include "recording/recording_summary.h"

#include <algorithm>
#include <vector>

#include "core/error.h"

namespace saccade {

TornEnd torn_end(const EventReader& reader, const std::filesystem::path& recording, const InputError& error) {
  std::error_code ignored;
  const std::uintmax_t size = std::filesystem::file_size(recording, ignored);
  const std::uint64_t whole = ignored ? 0 : size;
  const std::uint64_t byte = std::min<std::uint64_t>(reader.broken_record().value_or(whole), whole);
  return {byte, whole - byte, error.what(), !reader.breaks_inside()};
}

RecordingSummary summarise_recording(const FormatRegistry& formats, const std::filesystem::path& recording,
                                     const EventReadOptions& options, std::int64_t gap_us,
                                     const std::function<void(std::int64_t)>& progress) {
  const auto reader = open_event_file(formats, recording, options);
  RecordingSummary summary{recording.string(),
                           reader->format(),
                           {},
                           reader->image_size(),
                           EventCounter(reader->image_size(), gap_us)};
  constexpr std::size_t block_events = 1 << 13;  // fits into the processor's cache
  std::vector<Event> block;
  block.reserve(block_events);
  while (!summary.torn) {
    block.clear();
    try {
      if (reader->read(block, block_events) == 0) break;
    } catch (const InputError& error) {
      summary.torn = torn_end(*reader, recording, error);
    }
    summary.counter.add(block);
    if (progress) progress(summary.counter.all().count);
  }
  summary.skipped = reader->skipped();
  return summary;
}

}  // namespace saccade
