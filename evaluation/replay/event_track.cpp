#include <map>
#include <nlohmann/json.hpp>

#include "evaluation/replay/foxglove_track.h"
#include "evaluation/report/overlay.h"

namespace saccade {
namespace {

/// The events of a file by the millisecond that they end in. An event may follow ones that are up to 100 ms newer.
class EventsByMs {
 public:
  EventsByMs(std::unique_ptr<EventReader> reader, const ImageInstants& run, std::set<std::uint8_t> cameras)
      : reader_(std::move(reader)),
        start_us_(run.start_us()),
        end_ms_(run.end_ms()),
        cameras_(std::move(cameras)) {}

  /// The events of (ms - 1, ms] after the start, in the first one those at the start too; sorted by time. `ms` grows.
  std::vector<Event> take(std::int64_t ms) {
    constexpr std::int64_t slack_ms = 100;
    while (!at_end_ && newest_ms_ <= ms + slack_ms) read();
    taken_ms_ = ms;
    std::vector<Event> events;
    if (const auto place = by_ms_.find(ms); place != by_ms_.end()) {
      events = std::move(place->second);
      by_ms_.erase(place);
    }
    std::ranges::stable_sort(events, {}, &Event::t_us);
    return events;
  }
  [[nodiscard]] std::int64_t late() const { return late_; }

 private:
  void read() {
    constexpr std::size_t block_events = 65'536;
    block_.clear();
    at_end_ = reader_->read(block_, block_events) == 0;
    for (const Event& event : block_) {
      if (event.t_us < start_us_ || !cameras_.contains(event.camera)) continue;
      const std::int64_t ms = std::max<std::int64_t>(1, (event.t_us - start_us_ + 999) / 1000);
      if (ms > end_ms_) continue;  // of a recording that was not processed to its end
      newest_ms_ = std::max(newest_ms_, ms);
      if (ms <= taken_ms_)
        ++late_;
      else
        by_ms_[ms].push_back(event);
    }
  }

  std::unique_ptr<EventReader> reader_;
  std::int64_t start_us_;
  std::int64_t end_ms_;
  std::set<std::uint8_t> cameras_;
  std::vector<Event> block_;
  std::map<std::int64_t, std::vector<Event>> by_ms_;
  std::int64_t newest_ms_ = 0;
  std::int64_t taken_ms_ = 0;
  std::int64_t late_ = 0;
  bool at_end_ = false;
};

/// Images of the events, and how many there were in each ms.
class EventTrack final : public FoxgloveTrack {
 public:
  EventTrack(const Metrics& metrics, ImageInstants instants, std::unique_ptr<EventReader> reader,
             const std::set<std::uint8_t>& cameras, FoxgloveWriter& writer, FoxgloveSummary& summary)
      : size_(metrics.image),
        instants_(instants),
        events_(std::move(reader), instants, cameras),
        writer_(writer),
        summary_(summary) {
    for (const std::uint8_t camera : cameras) {
      const std::string side = "/" + side_of(camera);
      sides_.push_back(
          {camera,
           writer.add(side + "/events", "foxglove.CompressedImage"),
           writer.add_plain(side + "/event_counts", "saccade.EventCounts", {{"on_per_ms"}, {"off_per_ms"}}),
           {}});
    }
  }

  std::optional<std::int64_t> next_us() override {
    return ms_ <= instants_.end_ms() ? std::optional(instants_.time_us(ms_)) : std::nullopt;
  }
  void write() override {
    const std::vector<Event> events = events_.take(ms_);
    const std::int64_t t_us = instants_.time_us(ms_);
    const bool is_instant = instants_.next_ms() == ms_;
    for (Side& side : sides_) {
      std::int64_t on = 0;
      const std::size_t before = side.events.size();
      for (const Event& event : events) {
        if (event.camera != side.camera) continue;
        side.events.push_back(event);
        on += event.on ? 1 : 0;
      }
      const auto count = static_cast<std::int64_t>(side.events.size() - before);
      summary_.events += count;
      writer_.write(side.counts, t_us,
                    {{"timestamp", foxglove_time(t_us)}, {"on_per_ms", on}, {"off_per_ms", count - on}});
      if (is_instant) write_image(side, t_us);
    }
    summary_.late_events = events_.late();
    if (is_instant) instants_.go_on();
    ++ms_;
  }

 private:
  struct Side {
    std::uint8_t camera;
    std::size_t images;
    std::size_t counts;
    std::vector<Event> events;  ///< since the last image
  };

  void write_image(Side& side, std::int64_t t_us) {
    AnnotatedImage image;
    image.size = size_;
    image.events = side.events;
    writer_.write(side.images, t_us, foxglove_png(t_us, frame_of(side.camera), draw_image(image, 1)));
    side.events.clear();
  }

  ImageSize size_;
  ImageInstants instants_;
  EventsByMs events_;
  FoxgloveWriter& writer_;
  FoxgloveSummary& summary_;
  std::vector<Side> sides_;
  std::int64_t ms_ = 1;
};

}  // namespace

std::unique_ptr<FoxgloveTrack> event_track(const Metrics& metrics, const ImageInstants& instants,
                                           std::unique_ptr<EventReader> reader,
                                           const std::set<std::uint8_t>& cameras, FoxgloveWriter& writer,
                                           FoxgloveSummary& summary) {
  return std::make_unique<EventTrack>(metrics, instants, std::move(reader), cameras, writer, summary);
}

}  // namespace saccade
