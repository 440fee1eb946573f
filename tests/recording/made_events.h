#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "core/random.h"
#include "recording/event_file.h"

namespace saccade {

inline void write_file(const std::filesystem::path& path, ImageSize size, const std::vector<Event>& events) {
  const auto writer = create_event_file(path, size);
  writer->write(events);
  writer->commit();
}

/// Events all over the image, with the corners among them, and equal times now and then.
inline std::vector<Event> scattered_events(ImageSize size, std::int64_t first_us, int count,
                                           std::int64_t step_us) {
  const RandomStream random(11, "event_file_test");
  std::vector<Event> events;
  for (int i = 0; i < count; ++i) {
    const auto n = static_cast<std::uint64_t>(i);
    const bool right = i < 4 ? (i & 1) != 0 : random.uniform(0, n) < 0.5;
    Event event;
    event.t_us = first_us;
    event.x = static_cast<std::uint16_t>(random.bits(1, n) % static_cast<std::uint64_t>(size.width));
    event.y = static_cast<std::uint16_t>(random.bits(2, n) % static_cast<std::uint64_t>(size.height));
    if (i < 4) event.x = static_cast<std::uint16_t>(right ? size.width - 1 : 0);
    if (i < 4) event.y = static_cast<std::uint16_t>((i & 2) != 0 ? size.height - 1 : 0);
    event.on = (random.bits(3, n) & 1) != 0;
    events.push_back(event);
    first_us += static_cast<std::int64_t>(random.bits(4, n) % static_cast<std::uint64_t>(step_us));
  }
  return events;
}

}  // namespace saccade
