#include "recording/conversion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/time_stamp.h"
#include "recording/codec.h"
#include "recording/event_filter.h"
#include "recording/number_text.h"
#include "recording/other_records.h"

namespace saccade {
namespace {

constexpr std::size_t read_block_events = 1 << 16;

/// Properties of a recording that its writer needs before the first event.
struct Extent {
  std::optional<std::int64_t> first_us;
  ImageSize size{1, 1};  ///< of the file, or the smallest one that contains its events
  int cameras = 1;
};

class Conversion {
 public:
  /// `image`: of the recording; `hot`: of its events.
  Conversion(const ConversionConfig& config, std::string recording, std::int64_t first_us, ImageSize image,
             const HotPixels& hot)
      : config_(config),
        hot_(hot),
        recording_(std::move(recording)),
        first_us_(first_us),
        from_us_(at(config.from_s)),
        until_us_(at(config.until_s)),
        recorded_image_(image),
        image_(config.crop ? ImageSize{config.region->width, config.region->height} : image),
        origin_(config.crop ? *config.region : PixelRegion{}) {}

  /// Size of the written image.
  [[nodiscard]] ImageSize image() const {
    return config_.swap_xy ? ImageSize{image_.height, image_.width} : image_;
  }
  [[nodiscard]] bool is_in_time(std::int64_t t_us) const { return t_us >= from_us_ && t_us < until_us_; }
  /// The time at which the first event that is written is in the recording.
  void begin_at(std::int64_t t_us) {
    if (!zero_us_) zero_us_ = t_us;
  }
  [[nodiscard]] std::int64_t written_time(std::int64_t t_us) const {
    return config_.zero_time && zero_us_ ? saturated_difference(t_us, *zero_us_) : t_us;
  }
  [[nodiscard]] bool changes_images() const {
    return config_.crop || config_.swap_xy || config_.flip_x || config_.flip_y;
  }
  /// The pixel of the recording that is written at x, y.
  [[nodiscard]] std::array<int, 2> recorded_pixel(int x, int y) const {
    if (config_.flip_x) x = image().width - 1 - x;
    if (config_.flip_y) y = image().height - 1 - y;
    if (config_.swap_xy) std::swap(x, y);
    return {x + origin_.x, y + origin_.y};
  }
  [[nodiscard]] ImageSize recorded_image() const { return recorded_image_; }

  /// Removes the events that are not written, counts them in `result`, and changes the others.
  void apply(std::vector<Event>& events, ConversionResult& result) {
    const auto is_removed = [&](const Event& e) {
      if (!is_in_time(e.t_us)) return count(result.outside_time);
      if (config_.region && !config_.region->contains(e)) return count(result.outside_region);
      if (config_.remove_outside && !recorded_image_.contains(e.x, e.y)) return count(result.outside_image);
      if (config_.only_on && e.on != *config_.only_on) return count(result.other_polarity);
      if (config_.remove_hot && hot_.is_hot(e.camera, e.x, e.y)) return count(result.hot);
      if (config_.remove_background && background_.is_background(e)) return count(result.background);
      if (config_.decimate > 1 && seen_.at(e.on ? 1 : 0).at(e.camera, e.x, e.y)++ % config_.decimate != 0)
        return count(result.decimated);
      return false;
    };
    std::erase_if(events, is_removed);
    for (Event& event : events) change(event);
    result.events += static_cast<std::int64_t>(events.size());
  }

 private:
  static bool count(std::int64_t& counter) {
    ++counter;
    return true;
  }
  /// The time `seconds` after the first event.
  [[nodiscard]] std::int64_t at(double seconds) const {
    constexpr double longest_s = 4e12;
    if (seconds > longest_s) return std::numeric_limits<std::int64_t>::max();
    if (seconds < -longest_s) return std::numeric_limits<std::int64_t>::min();
    return saturated_sum(first_us_, std::llround(seconds * 1e6));
  }

  void change(Event& event) {
    if (config_.read.camera) event.camera = 0;
    if (config_.invert) event.on = !event.on;
    if (config_.zero_time) {
      if (!zero_us_) zero_us_ = event.t_us;
      if (__builtin_sub_overflow(event.t_us, *zero_us_, &event.t_us)) {
        throw InputError(recording_, "an event more than 2^63 us from the first one written",
                         "shorter recordings for --zero-time");
      }
    }
    int x = event.x - origin_.x;
    int y = event.y - origin_.y;
    if (config_.swap_xy) std::swap(x, y);
    if (config_.flip_x) x = image().width - 1 - x;
    if (config_.flip_y) y = image().height - 1 - y;
    if (x < 0 || y < 0) {
      throw InputError(recording_, "an event at " + std::to_string(event.x) + ", " + std::to_string(event.y),
                       "pixels inside " + text_of(image_) + "; --region removes others");
    }
    event.x = static_cast<std::uint16_t>(x);
    event.y = static_cast<std::uint16_t>(y);
  }

  const ConversionConfig& config_;
  const HotPixels& hot_;
  BackgroundActivity background_;
  std::array<PixelTable<std::int64_t>, 2> seen_{PixelTable<std::int64_t>(0), PixelTable<std::int64_t>(0)};
  std::string recording_;
  std::int64_t first_us_;
  std::int64_t from_us_;
  std::int64_t until_us_;
  ImageSize recorded_image_;
  ImageSize image_;
  PixelRegion origin_;
  std::optional<std::int64_t> zero_us_;
};

/// Passes on what a recording holds besides events, as ConversionConfig has it.
class ConvertedOthers final : public OtherRecords {
 public:
  ConvertedOthers(const Conversion& conversion, std::string recording, OtherRecords& to)
      : conversion_(conversion), recording_(std::move(recording)), to_(to) {}

  bool wants_frames() const override { return to_.wants_frames(); }
  bool wants_inertial() const override { return to_.wants_inertial(); }
  bool wants_triggers() const override { return to_.wants_triggers(); }

  void add(const RecordedFrame& recorded) override {
    if (!conversion_.is_in_time(recorded.t_us)) return;
    RecordedFrame frame = recorded;
    frame.t_us = conversion_.written_time(frame.t_us);
    if (frame.begin_us) frame.begin_us = conversion_.written_time(*frame.begin_us);
    if (frame.end_us) frame.end_us = conversion_.written_time(*frame.end_us);
    if (conversion_.changes_images()) change(frame);
    to_.add(frame);
  }
  void add(const InertialReading& recorded) override {
    if (!conversion_.is_in_time(recorded.t_us)) return;
    InertialReading reading = recorded;
    reading.t_us = conversion_.written_time(reading.t_us);
    to_.add(reading);
  }
  void add(const RecordedTrigger& recorded) override {
    if (!conversion_.is_in_time(recorded.t_us)) return;
    RecordedTrigger trigger = recorded;
    trigger.t_us = conversion_.written_time(trigger.t_us);
    to_.add(trigger);
  }

 private:
  /// Crops and turns a frame as the events.
  void change(RecordedFrame& frame) {
    const ImageSize recorded = conversion_.recorded_image();
    const std::string size = text_of(ImageSize{frame.width, frame.height});
    if (!frame.encoded.empty())
      throw InputError(recording_, "compressed frames",
                       "--also frames without --crop, --swap-xy, --flip-x and --flip-y");
    if (frame.width != recorded.width || frame.height != recorded.height)
      throw InputError(recording_, "frames of " + size,
                       "frames of the events' " + text_of(recorded) +
                           ", or no --crop, --swap-xy, --flip-x and --flip-y with --also frames");
    const ImageSize written = conversion_.image();
    const auto bytes = static_cast<std::size_t>(frame.channels * frame.bits / 8);
    const auto offset = [&](int x, int y, int width) {
      return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
             bytes;
    };
    pixels_.assign(offset(0, written.height, written.width), std::byte{0});
    for (int y = 0; y < written.height; ++y) {
      for (int x = 0; x < written.width; ++x) {
        const auto [from_x, from_y] = conversion_.recorded_pixel(x, y);
        if (!recorded.contains(from_x, from_y)) continue;  // a region that reaches beyond the image
        const std::span<const std::byte> pixel =
            frame.pixels.subspan(offset(from_x, from_y, frame.width), bytes);
        std::ranges::copy(pixel, pixels_.begin() + static_cast<std::ptrdiff_t>(offset(x, y, written.width)));
      }
    }
    frame.width = written.width;
    frame.height = written.height;
    frame.pixels = pixels_;
  }

  const Conversion& conversion_;
  std::string recording_;
  OtherRecords& to_;
  std::vector<std::byte> pixels_;
};

/// Calls `use(block)` with all events of a recording, with config.whole_part of one that breaks off those before; returns
/// its reader. `others` (may be null) gets the rest.
template <class Use>
std::unique_ptr<EventReader> for_each_block(const FormatRegistry& formats,
                                            const std::filesystem::path& recording,
                                            const ConversionConfig& config, std::optional<TornEnd>& torn,
                                            OtherRecords* others, const Use& use) {
  EventReadOptions options = config.read;
  options.others = others;
  auto reader = open_event_file(formats, recording, options);
  std::vector<Event> block;
  block.reserve(read_block_events);
  while (!torn) {
    block.clear();
    try {
      if (reader->read(block, read_block_events) == 0) break;
    } catch (const InputError& error) {
      if (!config.whole_part) throw;
      torn = torn_end(*reader, recording, error);
    }
    if (!block.empty()) use(block);
  }
  return reader;
}

/// When the first event that is written is in the recording, where times begin there; none where no event is.
std::optional<std::int64_t> first_written(const FormatRegistry& formats,
                                          const std::filesystem::path& recording,
                                          const ConversionConfig& config, const Extent& extent,
                                          const HotPixels& hot) {
  if (!config.zero_time) return std::nullopt;
  ConversionConfig plain = config;
  plain.zero_time = false;
  plain.read.others = nullptr;
  Conversion conversion(plain, recording.string(), extent.first_us.value_or(0), extent.size, hot);
  ConversionResult result;
  const auto reader = open_event_file(formats, recording, plain.read);
  std::vector<Event> block;
  try {
    while (reader->read(block, read_block_events) > 0) {
      conversion.apply(block, result);
      if (!block.empty()) return block.front().t_us;
    }
  } catch (const InputError&) {
    if (!config.whole_part) throw;
  }
  return std::nullopt;
}

void check(const ConversionConfig& config) {
  if (config.crop && !config.region) throw InputError("--crop", "", "--region with it");
  if (config.decimate < 1)
    throw InputError("--decimate", std::to_string(config.decimate), "a whole number from 1");
  if (config.until_s > config.from_s) return;
  const auto text = [](double number) {
    std::string digits;
    append_number(digits, number);
    return digits;
  };
  throw InputError("--until", text(config.until_s), "more than --from, " + text(config.from_s));
}

}  // namespace

ConversionResult convert_recording(const FormatRegistry& formats, const std::filesystem::path& recording,
                                   const std::filesystem::path& out, const ConversionConfig& config,
                                   const ConversionProgress& progress) {
  check(config);
  Extent extent;
  std::int64_t events = 0;
  const auto hot = std::make_unique<HotPixels>();
  std::optional<TornEnd> torn;
  auto reader =
      for_each_block(formats, recording, config, torn, nullptr, [&](const std::vector<Event>& block) {
        if (!extent.first_us) extent.first_us = block.front().t_us;
        for (const Event& event : block) {
          extent.size = {std::max(extent.size.width, event.x + 1), std::max(extent.size.height, event.y + 1)};
          extent.cameras = std::max(extent.cameras, event.camera + 1);
          if (config.remove_hot) hot->add(event);
        }
        events += static_cast<std::int64_t>(block.size());
        if (progress) progress(false, events);
      });
  extent.size = reader->image_size().value_or(extent.size);
  if (config.read.camera) extent.cameras = 1;

  Conversion conversion(config, recording.string(), extent.first_us.value_or(0), extent.size, *hot);
  const auto writer = create_event_file(formats, out, conversion.image(), extent.cameras);
  ConversionResult result;
  result.hot_pixels = hot->number();
  events = 0;
  std::optional<ConvertedOthers> others;
  if (config.read.others != nullptr) {
    others.emplace(conversion, recording.string(), *config.read.others);
    if (const auto first = first_written(formats, recording, config, extent, *hot))
      conversion.begin_at(*first);
  }
  OtherRecords* const rest = others ? &*others : nullptr;
  reader = for_each_block(formats, recording, config, result.torn, rest, [&](std::vector<Event>& block) {
    events += static_cast<std::int64_t>(block.size());
    if (progress) progress(true, events);
    conversion.apply(block, result);
    writer->write(block);
  });
  writer->commit();
  result.skipped = reader->skipped();
  result.guess = reader->guess();
  return result;
}

}  // namespace saccade
