#include "core/baselines/scarf.h"

#include <algorithm>

namespace saccade {
namespace {

int fields_along(int length_px, std::int64_t block_px) {
  const std::int64_t even_px = block_px + block_px % 2;
  return static_cast<int>(std::max<std::int64_t>(1, length_px / even_px - 1));
}

int block_along(int length_px, int fields) {
  const int block_px = length_px / (fields + 1);
  return std::max(2, block_px - block_px % 2);
}

/// x / y, rounded down.
int floor_quotient(int x, int y) { return x >= 0 ? x / y : -((y - 1 - x) / y); }

}  // namespace

void describe(FieldVisitor& v, ScarfConfig& config) {
  describe_radius_px(v, config.radius_px);
  v.integer("block_px", config.block_px, {2, 200}, "side of the centre of a receptive field");
  v.real("alpha", config.alpha, {0.02, 10.0}, "events of a field over half of the pixels of its centre");
  v.real("contrast", config.contrast, {0.01, 1.0}, "of an event in the image");
  v.real("threshold", config.threshold, {0.0, 1.0}, "response taken for the ball");
}

ScarfSurface::ScarfSurface(const ScarfConfig& config, ImageSize size)
    : size_(size),
      columns_(fields_along(size.width, config.block_px)),
      rows_(fields_along(size.height, config.block_px)),
      block_width_px_(block_along(size.width, columns_)),
      block_height_px_(block_along(size.height, rows_)),
      capacity_(
          static_cast<std::size_t>(std::max(1.0, block_width_px_ * block_height_px_ * config.alpha * 0.5))),
      value_(255.0 * config.contrast) {
  const auto fields = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
  events_.resize(fields * capacity_, passive);
  oldest_.resize(fields, 0);
  active_.resize(static_cast<std::size_t>(size.pixels()), 0);
  values_.resize(active_.size(), 0.0);
}

/// Puts an event into a field, if there is such a field; its oldest event leaves.
void ScarfSurface::push(int column, int row, std::int32_t pixel) {
  if (column < 0 || row < 0 || column >= columns_ || row >= rows_) return;
  const auto change = [this](std::int32_t at, int by) {
    if (at == passive) return;
    const auto i = static_cast<std::size_t>(at);
    active_[i] += by;
    values_[i] = value_ * active_[i];
  };
  const auto field = static_cast<std::size_t>(row * columns_ + column);
  std::int32_t& slot = events_[field * capacity_ + oldest_[field]];
  change(slot, -1);
  change(pixel, 1);
  slot = pixel;
  oldest_[field] = (oldest_[field] + 1) % capacity_;
}

void ScarfSurface::add(const Event& event) {
  const int x = event.x - block_width_px_ / 2;
  const int y = event.y - block_height_px_ / 2;
  const int column = floor_quotient(x, block_width_px_);
  const int row = floor_quotient(y, block_height_px_);
  const int beside_column = x - column * block_width_px_ < block_width_px_ / 2 ? column - 1 : column + 1;
  const int beside_row = y - row * block_height_px_ < block_height_px_ / 2 ? row - 1 : row + 1;
  push(column, row, event.y * size_.width + event.x);
  push(column, beside_row, passive);
  push(beside_column, row, passive);
  push(beside_column, beside_row, passive);
}

}  // namespace saccade
