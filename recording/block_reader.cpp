#include "recording/block_reader.h"

#include <algorithm>

namespace saccade::inline v0_1 {

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

}  // namespace saccade::inline v0_1
