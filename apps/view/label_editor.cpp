#include "apps/view/label_editor.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "apps/view/circle_snap.h"
#include "core/error.h"

namespace saccade {
namespace {

constexpr double smallest_r_px = 0.5;
constexpr std::size_t most_changes = 1000;
}  // namespace

LabelEditor::LabelEditor(std::vector<Event> events, ImageSize image, CircleLabels labels)
    : events_(std::move(events)), image_(image), labels_(std::move(labels)) {
  SACCADE_CHECK(!events_.empty());
  if (!std::ranges::is_sorted(events_, {}, &Event::t_us)) std::ranges::stable_sort(events_, {}, &Event::t_us);
  first_us_ = events_.front().t_us;
  last_us_ = events_.back().t_us;
  last_r_px_ = 0.1 * std::min(image.width, image.height);
  now_us_ = first_us_;
}

void LabelEditor::seek(std::int64_t t_us) {
  now_us_ = std::clamp(t_us, first_us_, last_us_);
  press_.reset();
  playing_ = false;
}

void LabelEditor::toggle_playing() {
  const bool plays = !playing_;
  seek(plays && now_us_ == last_us_ ? first_us_ : now_us_);
  playing_ = plays;
}

void LabelEditor::change_speed(int by) {
  const int speed = static_cast<int>(speed_) + by;
  speed_ = static_cast<std::size_t>(std::clamp(speed, 0, static_cast<int>(speeds.size()) - 1));
}

void LabelEditor::advance(double wall_s) {
  if (!playing_) return;
  seek(now_us_ + std::llround(1e6 * wall_s * speed()));
  playing_ = now_us_ < last_us_;
}

void LabelEditor::seek_previous_label() {
  if (const TruthRow* row = labels_.before(now_us_)) seek(row->t_us);
}

void LabelEditor::seek_next_label() {
  if (const TruthRow* row = labels_.after(now_us_)) seek(row->t_us);
}

void LabelEditor::scale_reach(double factor) {
  reach_us_ = std::clamp<std::int64_t>(std::llround(factor * static_cast<double>(reach_us_)), 100, 1'000'000);
}

std::span<const Event> LabelEditor::shown_events() const {
  const auto begin = std::ranges::lower_bound(events_, now_us_ - reach_us_, {}, &Event::t_us);
  const auto end = std::ranges::upper_bound(events_, now_us_ + reach_us_, {}, &Event::t_us);
  return {begin, end};
}

std::vector<float> LabelEditor::event_counts(std::size_t parts) const {
  std::vector<float> counts(parts, 0.0F);
  const double span_us = std::max(1.0, static_cast<double>(last_us_ - first_us_));
  for (const Event& event : events_) {
    const double share = static_cast<double>(event.t_us - first_us_) / span_us;
    counts[std::min(static_cast<std::size_t>(share * static_cast<double>(parts)), parts - 1)] += 1.0F;
  }
  return counts;
}

bool LabelEditor::hidden() const {
  const TruthRow* row = labels_.at(now_us_);
  return row != nullptr && !(row->visible > 0.0);
}

void LabelEditor::press(double x_px, double y_px) {
  playing_ = false;
  const std::optional<Circle> shown = circle();
  const double distance =
      shown ? std::hypot(x_px - shown->x_px, y_px - shown->y_px) : std::numeric_limits<double>::infinity();
  const double r_px = shown ? shown->r_px : last_r_px_;
  const bool on_outline = std::abs(distance - r_px) <= std::max(1.0, 0.2 * r_px);
  press_ = Press{x_px, y_px, on_outline ? Hold::radius : Hold::centre, shown.value_or(Circle{}), false};
  if (on_outline || distance < r_px) return;
  press_->circle = {x_px, y_px, r_px};
  change_by_press(press_->circle);
}

void LabelEditor::drag(double x_px, double y_px) {
  if (!press_) return;
  const Circle& from = press_->circle;
  if (press_->hold == Hold::centre)
    change_by_press({from.x_px + x_px - press_->x_px, from.y_px + y_px - press_->y_px, from.r_px});
  if (press_->hold == Hold::radius)
    change_by_press({from.x_px, from.y_px, std::hypot(x_px - from.x_px, y_px - from.y_px)});
}

void LabelEditor::release() {
  if (press_ && !press_->has_placed) change_by_press({press_->x_px, press_->y_px, press_->circle.r_px});
  press_.reset();
}

/// All that one press changes is one change.
void LabelEditor::change_by_press(const Circle& circle) {
  if (!std::exchange(press_->has_placed, true)) begin_change();
  place(circle);
}

void LabelEditor::grow(double px) {
  const std::optional<Circle> shown = circle();
  if (!shown) return;
  begin_change();
  place({shown->x_px, shown->y_px, shown->r_px + px});
}

void LabelEditor::move(double x_px, double y_px) {
  const std::optional<Circle> shown = circle();
  if (!shown) return;
  begin_change();
  place({shown->x_px + x_px, shown->y_px + y_px, shown->r_px});
}

void LabelEditor::accept_hint() {
  const std::optional<Circle> shown = circle();
  if (!shown || labelled()) return;
  begin_change();
  place(*shown);
}

bool LabelEditor::snap() {
  const std::optional<Circle> shown = circle();
  if (!shown) return false;
  const std::optional<Circle> snapped = snapped_circle(events_, image_, *shown, now_us_, reach_us_);
  if (!snapped) return false;
  begin_change();
  place(*snapped);
  return true;
}

void LabelEditor::toggle_hidden() {
  const bool was_hidden = hidden();
  press_.reset();
  begin_change();
  if (was_hidden) {
    labels_.remove(now_us_);
  } else {
    labels_.hide(now_us_);
  }
}

void LabelEditor::remove() {
  if (!labelled()) return;
  press_.reset();
  begin_change();
  labels_.remove(now_us_);
}

void LabelEditor::undo() {
  if (changes_.empty()) return;
  const Change change = changes_.back();
  changes_.pop_back();
  labels_.remove(change.t_us);
  if (change.before) labels_.restore(*change.before);
  unsaved_ = true;
  seek(change.t_us);
}

void LabelEditor::begin_change() {
  playing_ = false;
  const TruthRow* row = labels_.at(now_us_);
  if (changes_.size() == most_changes) changes_.erase(changes_.begin());
  changes_.push_back({now_us_, row == nullptr ? std::nullopt : std::optional(*row)});
  unsaved_ = true;
}

void LabelEditor::place(Circle circle) {
  const double largest_r_px = std::max(image_.width, image_.height);
  circle.r_px = std::clamp(circle.r_px, smallest_r_px, largest_r_px);
  last_r_px_ = circle.r_px;
  labels_.place(now_us_, circle);
}

void paint_instant(const LabelEditor& editor, RgbImage& rgb) {
  const ImageSize size = editor.image_size();
  const auto pixels = static_cast<std::size_t>(size.pixels());
  rgb.resize(3 * pixels);
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = ground_rgb[i % 3];
  std::vector<std::int64_t> nearest_us(pixels, std::numeric_limits<std::int64_t>::max());
  for (const Event& event : editor.shown_events()) {
    if (!size.contains(event.x, event.y)) continue;
    const auto pixel = static_cast<std::size_t>(event.y) * static_cast<std::size_t>(size.width) + event.x;
    const std::int64_t away_us = std::abs(event.t_us - editor.now_us());
    if (away_us >= nearest_us[pixel]) continue;
    nearest_us[pixel] = away_us;
    const double share = 1.0 - 0.8 * static_cast<double>(away_us) / static_cast<double>(editor.reach_us());
    const Rgb& colour = event.on ? on_rgb : off_rgb;
    for (std::size_t c = 0; c < 3; ++c)
      rgb[3 * pixel + c] =
          static_cast<std::uint8_t>(std::lround(ground_rgb[c] + share * (colour[c] - ground_rgb[c])));
  }
}

}  // namespace saccade
