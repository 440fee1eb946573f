#include "core/tracker/recurrent_network.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/error.h"
#include "core/time_stamp.h"

namespace saccade {
namespace {

constexpr std::array<float, 4> tau_ms = {4.0F, 16.0F, 64.0F, 256.0F};
constexpr int age_steps = 256;                               // sixteen for each doubling of 0.25 ms + age
constexpr double smallest_cells = 3.6, largest_cells = 9.0;  // radii that a level finds
constexpr int fewest_rows = 16;  // cells, of a level: smaller images hold no such radius
constexpr double least_dt_ms = 1.0, most_dt_ms = 1'000.0;

/// Index into the table of ages: 16 log2(1 + 4 age / ms), by the bits of the floating-point number.
std::size_t age_index(std::int64_t age_us) {
  const float scaled = 1.0F + static_cast<float>(std::max<std::int64_t>(age_us, 0)) * 4e-3F;
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(scaled);
  return std::min<std::size_t>((bits >> 19U) - (127U << 4U), age_steps - 1);
}

using Decays = std::array<std::array<float, 4>, age_steps>;
const Decays& decays() {
  static const Decays table = [] {
    Decays values{};
    for (std::size_t i = 0; i + 1 < age_steps; ++i) {  // the last: never
      const double from = std::ldexp(1.0 + static_cast<double>(i % 16) / 16.0, static_cast<int>(i / 16));
      const double middle_ms = (from + std::ldexp(1.0, static_cast<int>(i / 16)) / 32.0 - 1.0) / 4.0;
      for (std::size_t k = 0; k < tau_ms.size(); ++k)
        values[i][k] = static_cast<float>(std::exp(-middle_ms / static_cast<double>(tau_ms[k])));
    }
    return values;
  }();
  return table;
}

}  // namespace

RecurrentNetwork::RecurrentNetwork(std::shared_ptr<const RecurrentModel> model, ImageSize size,
                                   double r_min_px, double r_max_px)
    : size_(size), now_us_(TimeSurface::never_us), found_at_us_(TimeSurface::never_us) {
  decays();
  for (int cell = 1; cell <= 8; cell *= 2) {
    const bool smaller_suffice =
        cell > 1 && (r_max_px <= smallest_cells * cell || size.height < cell * fewest_rows);
    if (smaller_suffice || (cell < 8 && r_min_px >= largest_cells * cell)) continue;
    const auto cells = [&](int px) {
      const int square_px = RecurrentLevel::square * cell;
      return (px + square_px - 1) / square_px * RecurrentLevel::square;
    };
    levels_.push_back({cell, {model, cells(size.height), cells(size.width)}});
    maps_.reserve(levels_.back().network.rows(), levels_.back().network.columns());
  }
  level_ = input_level_ = levels_.size();
}

std::int64_t RecurrentNetwork::multiplications() const {
  std::int64_t sum = 0;
  for (const Level& level : levels_) sum += level.network.multiplications();
  return sum;
}

void RecurrentNetwork::begin(std::int64_t now_us, const std::optional<Eigen::Vector2d>& image_shift_px) {
  const std::int64_t dt_us = now_us_ == TimeSurface::never_us ? 0 : saturated_difference(now_us, now_us_);
  dt_ms_ = std::clamp(static_cast<double>(dt_us) * 1e-3, least_dt_ms, most_dt_ms);
  now_us_ = now_us;
  image_shift_px_ = image_shift_px;
  level_ = input_level_ = 0;
  input_row_ = 0;
  begin_level();
}

void RecurrentNetwork::begin_level() {
  Level& level = levels_[level_];
  RecurrentLevel::Step step{static_cast<float>(dt_ms_), 0, 0, {0.0F, 0.0F}, image_shift_px_.has_value()};
  if (image_shift_px_) {
    const Eigen::Vector2d squares = *image_shift_px_ / (RecurrentLevel::square * level.cell_px);
    level.shift_rest += squares;
    const Eigen::Vector2d whole(std::nearbyint(level.shift_rest.x()), std::nearbyint(level.shift_rest.y()));
    level.shift_rest -= whole;
    const auto clamped = [](double squares_moved) {
      return static_cast<int>(std::clamp(squares_moved, -1e4, 1e4));
    };
    step.shift_x = clamped(whole.x());
    step.shift_y = clamped(whole.y());
    for (int i = 0; i < 2; ++i)
      step.speed[static_cast<std::size_t>(i)] = static_cast<float>(squares[i] * 100.0 / dt_ms_);
  }
  level.network.begin(step);
}

bool RecurrentNetwork::work(const TimeSurface& surface, std::int64_t multiplications) {
  SACCADE_CHECK(surface.size() == size_);
  if (!busy()) return false;
  while (multiplications > 0) {
    if (input_level_ < levels_.size()) {  // first of all, so that hardly any later event gets into them
      Level& level = levels_[input_level_];
      input_row(level, surface);
      multiplications -=
          std::int64_t{level.network.columns()} * level.cell_px * level.cell_px * RecurrentModel::inputs;
      if (++input_row_ < level.network.rows()) continue;
      input_row_ = 0;
      ++input_level_;
      continue;
    }
    Level& level = levels_[level_];
    multiplications -= level.network.row(maps_);
    if (level.network.busy()) continue;
    if (++level_ < levels_.size()) {
      begin_level();
      continue;
    }
    take_result();
    return true;
  }
  return false;
}

void RecurrentNetwork::input_row(Level& level, const TimeSurface& surface) {
  constexpr std::size_t channels = RecurrentModel::inputs;
  const Decays& table = decays();
  const int cell = level.cell_px;
  const float scale = std::sqrt(static_cast<float>(cell)) / static_cast<float>(cell * cell);
  float* out = level.network.input().data() +
               static_cast<std::size_t>(input_row_ * level.network.columns()) * channels;
  const std::array<const std::int64_t*, 2> newest_us = {surface.newest_us(true).data(),
                                                        surface.newest_us(false).data()};
  const int y_end = std::min(size_.height, (input_row_ + 1) * cell);
  for (int column = 0; column < level.network.columns(); ++column, out += channels) {
    std::array<float, channels> sum{};
    const int x_end = std::min(size_.width, (column + 1) * cell);
    for (int y = input_row_ * cell; y < y_end; ++y) {
      for (int x = column * cell; x < x_end; ++x) {
        for (std::size_t p = 0; p < 2; ++p) {
          const std::int64_t t_us = newest_us[p][static_cast<std::size_t>(y * size_.width + x)];
          if (t_us == TimeSurface::never_us) continue;
          const std::array<float, 4>& decay = table[age_index(saturated_difference(now_us_, t_us))];
          for (std::size_t k = 0; k < 4; ++k) sum[4 * p + k] += decay[k];
        }
      }
    }
    for (std::size_t k = 0; k < channels; ++k) out[k] = sum[k] * scale;
  }
}

/// The strongest local maxima of each level.
void RecurrentNetwork::take_result() {
  found_at_us_ = now_us_;
  found_count_ = 0;
  for (const Level& level : levels_) {
    const int rows = level.network.rows() / RecurrentLevel::square,
              columns = level.network.columns() / RecurrentLevel::square;
    const auto at = [&](int x, int y) -> const RecurrentLevel::Square& {
      return level.network.output()[static_cast<std::size_t>(y * columns + x)];
    };
    std::array<Found, found_per_level> best;
    std::size_t count = 0;
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) {
        const RecurrentLevel::Square& own = at(x, y);
        const double log_odds = static_cast<double>(own.log_odds);
        if (count == best.size() && best.back().centre_log_odds >= log_odds) continue;
        bool largest = true;
        for (int ny = std::max(0, y - 1); ny <= std::min(rows - 1, y + 1) && largest; ++ny) {
          for (int nx = std::max(0, x - 1); nx <= std::min(columns - 1, x + 1); ++nx)
            largest = largest && at(nx, ny).log_odds <= own.log_odds;
        }
        if (!largest) continue;
        const double cell = level.cell_px, square_px = RecurrentLevel::square * cell;
        const double r_px = RecurrentLevel::mean_cells * cell *
                            std::exp2(std::clamp(static_cast<double>(own.log2_radius), -1.0, 1.0));
        const auto sd = [](float log_sd) {
          return std::exp(std::clamp(static_cast<double>(log_sd), -5.0, 2.0));
        };
        const Found found{
            {(x + 0.5 + static_cast<double>(own.x)) * square_px - 0.5,
             (y + 0.5 + static_cast<double>(own.y)) * square_px - 0.5, r_px},
            Eigen::Vector2d(static_cast<double>(own.vx), static_cast<double>(own.vy)) * (10.0 * square_px),
            square_px * sd(own.log_sd_centre),
            r_px * 0.6931 * sd(own.log_sd_log2_radius),
            log_odds,
            static_cast<double>(own.inlier_log_odds)};
        std::size_t i = count < best.size() ? count++ : best.size() - 1;
        for (; i > 0 && best[i - 1].centre_log_odds < log_odds; --i) best[i] = best[i - 1];
        best[i] = found;
      }
    }
    for (std::size_t n = 0; n < count; ++n) {
      std::size_t i = found_count_++;
      for (; i > 0 && found_[i - 1].inlier_log_odds < best[n].inlier_log_odds; --i) found_[i] = found_[i - 1];
      found_[i] = best[n];
    }
  }
}

}  // namespace saccade
