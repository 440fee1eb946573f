#include "evaluation/sensor_fit/sensor_recording.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.h"
#include "core/units.h"

namespace saccade {
namespace {

constexpr std::size_t fullest_kept = 20;

/// The pixels of the stimulus' region: x, y, width and height.
std::array<int, 4> region_of(const Stimulus& stimulus, ImageSize size, const std::string& name) {
  if (stimulus.region_px[2] == 0.0) return {0, 0, size.width, size.height};
  std::array<int, 4> region{};
  for (std::size_t i = 0; i < 4; ++i) region[i] = static_cast<int>(stimulus.region_px[i]);
  const bool inside = region[2] > 0 && region[3] > 0 && region[0] + region[2] <= size.width &&
                      region[1] + region[3] <= size.height;
  if (!inside) {
    throw InputError("stimuli." + name + ".region_px", "pixels outside the image",
                     "pixels inside " + in_words(size));
  }
  return region;
}

}  // namespace

SensorRecording::SensorRecording(std::string name, Stimulus stimulus, ImageSize size, std::int64_t first_us,
                                 std::int64_t last_us)
    : name_(std::move(name)),
      stimulus_(std::move(stimulus)),
      size_(size),
      interval_(interval_of(stimulus_, first_us, last_us)) {
  if (!(interval_.end_us > interval_.begin_us) || interval_.begin_us > last_us ||
      interval_.end_us < first_us) {
    throw InputError("stimuli." + name_,
                     "a stimulus from " + std::to_string(interval_.begin_us) + " to " +
                         std::to_string(interval_.end_us) + " us",
                     "one within the recording, " + std::to_string(first_us) + " to " +
                         std::to_string(last_us) + " us; zero_us sets the time from which a stimulus counts");
  }
  const std::array<int, 4> region = region_of(stimulus_, size_, name_);
  region_ = region;
  const auto pixels = static_cast<std::size_t>(region[2]) * static_cast<std::size_t>(region[3]);
  // A step that has no factor in common with a power of two spreads the sample over rows and columns.
  const std::size_t sampled = std::min(pixels, most_pixels);
  number_.assign(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height), -1);
  for (std::size_t i = 0; i < sampled; ++i) {
    const std::size_t pixel =
        sampled == pixels ? i : i * pixels / sampled + (i * 2654435761u) % (pixels / sampled);
    const auto x = static_cast<std::size_t>(region[0]) + pixel % static_cast<std::size_t>(region[2]);
    const auto y = static_cast<std::size_t>(region[1]) + pixel / static_cast<std::size_t>(region[2]);
    number_[y * static_cast<std::size_t>(size.width) + x] = static_cast<std::int32_t>(places_.size());
    places_.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
  }
  trains_ = PixelTrains(places_.size());
  if (stimulus_.kind == StimulusKind::still) on_counts_.assign(number_.size(), 0);
}

void SensorRecording::add(std::span<const Event> events) {
  for (const Event& event : events) {
    if (!size_.contains(event.x, event.y)) continue;
    if (!first_stamp_us_) first_stamp_us_ = event.t_us;
    tick_us_ = std::gcd(tick_us_, event.t_us - *first_stamp_us_);
    const std::int64_t millisecond = event.t_us / 1000 - (event.t_us % 1000 < 0 ? 1 : 0);
    if (millisecond != millisecond_) {
      end_millisecond();
      millisecond_ = millisecond;
    }
    ++tenths_[static_cast<std::size_t>(event.t_us - 1000 * millisecond) / 100];
    ++in_millisecond_;
    if (event.t_us <= interval_.begin_us || event.t_us > interval_.end_us) continue;
    ++in_interval_;
    const auto pixel = static_cast<std::size_t>(event.y) * static_cast<std::size_t>(size_.width) + event.x;
    if (!on_counts_.empty() && event.on) ++on_counts_[pixel];
    if (number_[pixel] >= 0) trains_.add(static_cast<std::size_t>(number_[pixel]), {event.t_us, event.on});
  }
}

void SensorRecording::end_millisecond() {
  const double mean = static_cast<double>(in_millisecond_) / static_cast<double>(tenths_.size());
  double squares = 0.0;
  for (const std::int64_t count : tenths_)
    squares += (static_cast<double>(count) - mean) * (static_cast<double>(count) - mean);
  const double variance = squares / static_cast<double>(tenths_.size() - 1);
  fullest_.push_back({in_millisecond_, mean > 0.0 ? variance / mean : 0.0});
  if (fullest_.size() > 16 * fullest_kept) {
    std::nth_element(fullest_.begin(), fullest_.begin() + fullest_kept, fullest_.end(), std::greater<>());
    fullest_.resize(fullest_kept);
  }
  in_millisecond_ = 0;
  tenths_ = {};
}

void SensorRecording::finish() {
  end_millisecond();
  std::sort(fullest_.begin(), fullest_.end(), std::greater<>());
  fullest_.resize(std::min(fullest_.size(), fullest_kept));
  trains_.finish();
}

void SensorRecording::drop(std::span<const PixelPlace> hot) {
  std::vector<std::uint8_t> dropped(places_.size(), 0);
  for (const PixelPlace& place : hot) {
    const auto pixel = static_cast<std::size_t>(place.y) * static_cast<std::size_t>(size_.width) + place.x;
    if (pixel < number_.size() && number_[pixel] >= 0) dropped[static_cast<std::size_t>(number_[pixel])] = 1;
  }
  trains_ = trains_.without(dropped);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < places_.size(); ++i) {
    if (dropped[i] == 0) places_[kept++] = places_[i];
  }
  places_.resize(kept);
}

double SensorRecording::sampled_share() const {
  return in_interval_ > 0 ? static_cast<double>(trains_.events()) / static_cast<double>(in_interval_) : 1.0;
}

SensorRecording::HotPixels SensorRecording::hot_pixels() const {
  HotPixels hot;
  if (on_counts_.empty()) return hot;
  constexpr double many_times = 8.0;
  const auto width = static_cast<std::size_t>(size_.width);
  std::vector<PixelPlace> places;
  for (int y = region_[1]; y < region_[1] + region_[3]; ++y) {
    for (int x = region_[0]; x < region_[0] + region_[2]; ++x)
      places.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y)});
  }
  const auto count = [&](const PixelPlace& place) { return on_counts_[place.y * width + place.x]; };
  std::vector<std::uint32_t> sorted;
  for (const PixelPlace& place : places) sorted.push_back(count(place));
  const auto at = [&](double share) {
    const auto place =
        sorted.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sorted.size() - 1));
    std::nth_element(sorted.begin(), place, sorted.end());
    return static_cast<double>(*place);
  };
  const double median = at(0.5);
  const double limit = many_times * std::max(1.0, at(0.9));
  const double duration_s = static_cast<double>(interval_.end_us - interval_.begin_us) * 1e-6;
  double sum = 0.0;
  for (const PixelPlace& place : places) {
    if (static_cast<double>(count(place)) <= limit) continue;
    hot.places.push_back(place);
    sum += static_cast<double>(count(place)) - median;
  }
  if (!hot.places.empty()) hot.rate_hz = sum / static_cast<double>(hot.places.size()) / duration_s;
  return hot;
}

SensorRecording::Readout SensorRecording::readout() const {
  constexpr std::int64_t fewest_events =
      300;  // a millisecond of fewer varies by more than 1 % by chance alone
  constexpr double same = 0.01;
  constexpr double steady = 0.3;  // of the variation by chance
  Readout readout;
  if (fullest_.empty()) return readout;
  readout.rate_hz = 1e3 * static_cast<double>(fullest_.front().events);
  if (fullest_.size() < fullest_kept || fullest_.front().events < fewest_events) return readout;
  const double most = static_cast<double>(fullest_.front().events);
  std::vector<double> variations;
  for (const Millisecond& m : fullest_) variations.push_back(m.variation);
  std::nth_element(variations.begin(), variations.begin() + fullest_kept / 2, variations.end());
  readout.is_busy = most - static_cast<double>(fullest_.back().events) <= same * most &&
                    variations[fullest_kept / 2] <= steady;
  return readout;
}

}  // namespace saccade
