#include "evaluation/replay/kept_events.h"

#include <algorithm>

namespace saccade {

void KeptEvents::add(const Event& event) {
  if (total_++ % every_ != 0) return;
  if (events_.size() == most_) {
    every_ *= 2;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < events_.size(); i += 2) events_[kept++] = events_[i];
    events_.resize(kept);
    if ((total_ - 1) % every_ != 0) return;
  }
  events_.push_back(event);
}

std::vector<Event> KeptEvents::of(std::uint8_t camera) const {
  std::vector<Event> events;
  std::ranges::copy_if(events_, std::back_inserter(events),
                       [&](const Event& e) { return e.camera == camera; });
  std::ranges::stable_sort(events, {}, &Event::t_us);
  return events;
}

}  // namespace saccade
