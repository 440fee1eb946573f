#include "recording/block_reader.h"

#include <algorithm>

namespace saccade {

std::size_t BlockReader::read(std::vector<Event>& events, std::size_t max_events) {
  std::size_t done = 0;
  while (done < max_events) {
    if (begin_ < end_) {
      const std::size_t count = std::min(max_events - done, end_ - begin_);
      const auto first = block_.begin() + static_cast<std::ptrdiff_t>(begin_);
      events.insert(events.end(), first, first + static_cast<std::ptrdiff_t>(count));
      begin_ += count;
      done += count;
    } else if (over_ || failure_) {
      break;
    } else if (max_events - done >= block_events) {
      // A whole block finds room: it is not copied.
      const std::size_t before = events.size();
      std::size_t count = 0;
      events.resize(before + block_events);
      try {
        over_ = !decode(std::span(events).subspan(before), count);
      } catch (const InputError& error) {
        failure_ = error;
      } catch (...) {
        events.resize(before + count);
        throw;
      }
      events.resize(before + count);
      done += count;
    } else {
      begin_ = end_ = 0;
      try {
        over_ = !decode(block_, end_);
      } catch (const InputError& error) {
        failure_ = error;
      }
    }
  }
  if (done == 0 && failure_ && max_events > 0) throw InputError(*failure_);
  return done;
}

}  // namespace saccade
