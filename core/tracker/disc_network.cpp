#include "core/tracker/disc_network.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/error.h"
#include "core/time_stamp.h"
#include "core/tracker/network_kernels.h"
#include "core/vector_clones.h"

namespace saccade {
namespace {

using namespace network_kernels;
using Weights = DiscNetworkWeights;

constexpr std::array<float, 4> tau_ms = {4.0F, 16.0F, 64.0F, 256.0F};
constexpr int age_steps = 256;  // sixteen for each doubling of 0.25 ms + age
constexpr std::array<int, 4> dilation = {1, 2, 2, 3};
constexpr double least_cells = 4.0, middle_cells = 5.66, most_cells = 8.0;  // radius
constexpr int fewest_rows = 16;  // cells, of a level: smaller images hold no such radius
constexpr double about_radii = 0.4;
constexpr float least_log_odds = -6.0F;  // of what is found
constexpr std::size_t stages = 4 + dilation.size();

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

template <std::size_t C, std::size_t places>
[[gnu::always_inline]] inline void block_places(const Map& in, int y, int x, int step, const float* depth,
                                                const float* point, const float* bias, float* out) {
  float deep[places][C];
  Channels<C> sum[places];
  for (std::size_t p = 0; p < places; ++p) {
    depthwise<C>(in, y, x + static_cast<int>(p), step, depth, deep[p]);
    load(bias, sum[p]);
  }
  pointwise(deep, point, sum);
  for (std::size_t p = 0; p < places; ++p) {
    const auto at = static_cast<std::size_t>(y * in.columns + x) + p;
    Channels<C> own;
    load(in.values + at * C, own);
    for (std::size_t i = 0; i < C / lanes; ++i) sum[p].part[i] = own.part[i] + sum[p].part[i];
    store_positive(sum[p], out + at * C);
  }
}

/// A row of a residual block.
SACCADE_VECTOR_CLONES
void residual_row(const Map& in, int y, int step, const float* depth, const float* point, const float* bias,
                  float* out) {
  constexpr std::size_t c = Weights::channels;
  int x = 0;
  for (; x + 1 < in.columns; x += 2) block_places<c, 2>(in, y, x, step, depth, point, bias, out);
  for (; x < in.columns; ++x) block_places<c, 1>(in, y, x, step, depth, point, bias, out);
}

/// A row of every second place of every second row, depthwise and pointwise.
SACCADE_VECTOR_CLONES
void halved_row(const Map& in, int y, const Weights& weights, float* out) {
  constexpr std::size_t from = Weights::first_channels, to = Weights::channels;
  for (int x = 0; 2 * x < in.columns; ++x, out += to) {
    float deep[1][from];
    depthwise<from>(in, 2 * y, 2 * x, 1, weights.second_depth.data(), deep[0]);
    Channels<to> sum[1];
    load(weights.second_bias.data(), sum[0]);
    pointwise(deep, weights.second_point.data(), sum);
    store_positive(sum[0], out);
  }
}

SACCADE_VECTOR_CLONES
void first_row_of(const Map& in, int y, const Weights& weights, float* out) {
  input_halved_row(in, y, weights, out);
}

}  // namespace

DiscNetwork::DiscNetwork(std::shared_ptr<const BestModel> model, ImageSize size, double r_min_px,
                         double r_max_px)
    : model_(std::move(model)), size_(size) {
  decays();
  std::size_t most_cells_of_level = 0;
  for (int cell = 1; cell <= 8; cell *= 2) {
    const bool smaller_suffice =
        cell > 1 && (r_max_px <= least_cells * cell || size.height < cell * fewest_rows);
    if (smaller_suffice || (cell < 8 && r_min_px >= most_cells * cell)) continue;
    const auto cells = [&](int px) { return (px + 4 * cell - 1) / (4 * cell) * 4; };
    Level level{cell, cells(size.height), cells(size.width), {}, {}};
    const auto count = static_cast<std::size_t>(level.rows * level.columns);
    most_cells_of_level = std::max(most_cells_of_level, count);
    std::array<float, outputs> none{};
    none[0] = nothing;
    level.result.assign(count / 16, none);
    level.next = level.result;
    levels_.push_back(std::move(level));
  }
  level_ = levels_.size();
  input_.resize(most_cells_of_level * input_channels);
  first_.resize(most_cells_of_level / 4 * first_channels);
  a_.resize(most_cells_of_level / 16 * channels);
  b_.resize(most_cells_of_level / 16 * channels);
}

void DiscNetwork::begin(std::int64_t now_us) {
  now_us_ = now_us;
  level_ = stage_ = 0;
  row_ = 0;
}

bool DiscNetwork::work(const TimeSurface& surface, std::int64_t multiplications) {
  SACCADE_CHECK(surface.size() == size_);
  if (!busy()) return false;
  while (multiplications > 0) {
    multiplications -= row(levels_[level_], surface);
    if (!busy()) {
      take_result();
      return true;
    }
  }
  return false;
}

/// One row of the stage under way; the multiplications that it took at most.
std::int64_t DiscNetwork::row(Level& level, const TimeSurface& surface) {
  const std::int64_t columns = level.columns;
  std::int64_t cost = 0;
  int rows = level.rows;
  if (stage_ == 0) {
    input_row(level, surface);
    cost = columns * level.cell_px * level.cell_px * static_cast<std::int64_t>(input_channels);
  } else if (stage_ == 1) {
    first_row(level);
    rows /= 2;
    cost = columns / 2 * static_cast<std::int64_t>(9 * input_channels * first_channels);
  } else {
    rows /= 4;
    const std::int64_t places = columns / 4;
    if (stage_ == 2) {
      second_row(level);
      cost = places * static_cast<std::int64_t>(first_channels * (9 + channels));
    } else if (stage_ + 1 < stages) {
      block_row(level, stage_ - 3);
      cost = places * static_cast<std::int64_t>(channels * (9 + channels));
    } else {
      output_row(level);
      cost = places * static_cast<std::int64_t>(channels * outputs);
    }
  }
  if (++row_ < rows) return cost;
  row_ = 0;
  if (stage_ >= 3 && stage_ + 1 < stages) std::swap(a_, b_);
  if (++stage_ < stages) return cost;
  stage_ = 0;
  ++level_;
  return cost;
}

void DiscNetwork::input_row(const Level& level, const TimeSurface& surface) {
  const Decays& table = decays();
  const int cell = level.cell_px;
  const float scale = std::sqrt(static_cast<float>(cell)) / static_cast<float>(cell * cell);
  float* out = input_.data() + static_cast<std::size_t>(row_ * level.columns) * input_channels;
  const int y_end = std::min(size_.height, (row_ + 1) * cell);
  const std::array<const std::int64_t*, 2> newest_us = {surface.newest_us(true).data(),
                                                        surface.newest_us(false).data()};
  for (int column = 0; column < level.columns; ++column, out += input_channels) {
    std::array<float, input_channels> sum{};
    const int x_end = std::min(size_.width, (column + 1) * cell);
    for (int y = row_ * cell; y < y_end; ++y) {
      for (int x = column * cell; x < x_end; ++x) {
        for (std::size_t p = 0; p < 2; ++p) {
          const std::int64_t t_us = newest_us[p][static_cast<std::size_t>(y * size_.width + x)];
          if (t_us == TimeSurface::never_us) continue;
          const std::array<float, 4>& decay = table[age_index(saturated_difference(now_us_, t_us))];
          for (std::size_t k = 0; k < 4; ++k) sum[4 * p + k] += decay[k];
        }
      }
    }
    for (std::size_t k = 0; k < input_channels; ++k) out[k] = sum[k] * scale;
  }
}

void DiscNetwork::first_row(const Level& level) {
  const auto begin = static_cast<std::size_t>(row_ * (level.columns / 2)) * first_channels;
  first_row_of({input_.data(), level.rows, level.columns}, row_, model_->disc, first_.data() + begin);
}

void DiscNetwork::second_row(const Level& level) {
  const auto begin = static_cast<std::size_t>(row_ * (level.columns / 4)) * channels;
  halved_row({first_.data(), level.rows / 2, level.columns / 2}, row_, model_->disc, a_.data() + begin);
}

/// From a_ to b_.
void DiscNetwork::block_row(const Level& level, std::size_t block) {
  const Weights& weights = model_->disc;
  residual_row({a_.data(), level.rows / 4, level.columns / 4}, row_, dilation[block],
               weights.block_depth[block].data(), weights.block_point[block].data(),
               weights.block_bias[block].data(), b_.data());
}

void DiscNetwork::output_row(Level& level) {
  const Weights& weights = model_->disc;
  const auto columns = static_cast<std::size_t>(level.columns / 4);
  const std::size_t begin = static_cast<std::size_t>(row_) * columns;
  for (std::size_t x = 0; x < columns; ++x) {
    const float* in = a_.data() + (begin + x) * channels;
    std::array<float, outputs> sum = weights.output_bias;
    for (std::size_t c = 0; c < channels; ++c) {
      for (std::size_t k = 0; k < outputs; ++k) sum[k] += in[c] * weights.output[c * outputs + k];
    }
    level.next[begin + x] = sum;
  }
}

DiscNetwork::Found DiscNetwork::circle_of(const Level& level, int x, int y) const {
  const auto& o = level.result[static_cast<std::size_t>(y * (level.columns / 4) + x)];
  // The middle of 4 x 4 cells, moved by the offset, in whole squares of 4 cells.
  const double cell = level.cell_px;
  return {{((x + static_cast<double>(o[1])) * 4.0 + 2.0) * cell - 0.5,
           ((y + static_cast<double>(o[2])) * 4.0 + 2.0) * cell - 0.5,
           middle_cells * std::exp2(std::clamp(static_cast<double>(o[3]), -1.0, 1.0)) * cell},
          o[0]};
}

/// Makes what was computed the result, and finds its local maxima.
void DiscNetwork::take_result() {
  found_at_us_ = now_us_;
  found_count_ = 0;
  for (Level& level : levels_) {
    std::swap(level.result, level.next);
    const int rows = level.rows / 4;
    const int columns = level.columns / 4;
    const auto at = [&](int x, int y) { return level.result[static_cast<std::size_t>(y * columns + x)][0]; };
    for (int y = 0; y < rows; ++y) {
      for (int x = 0; x < columns; ++x) {
        const float own = at(x, y);
        if (own < least_log_odds) continue;
        bool largest = true;
        for (int dy = -1; dy <= 1 && largest; ++dy) {
          for (int dx = -1; dx <= 1; ++dx) {
            if (x + dx < 0 || y + dy < 0 || x + dx >= columns || y + dy >= rows) continue;
            largest = largest && at(x + dx, y + dy) <= own;
          }
        }
        if (!largest) continue;
        const bool full = found_count_ == found_.size();
        if (full && found_.back().log_odds >= own) continue;
        std::size_t i = full ? found_count_ - 1 : found_count_++;
        for (; i > 0 && found_[i - 1].log_odds < own; --i) found_[i] = found_[i - 1];
        found_[i] = circle_of(level, x, y);
      }
    }
  }
}

DiscNetwork::Found DiscNetwork::about(const Circle& circle) const {
  Found best{circle, nothing};
  const double near_px = about_radii * circle.r_px;
  for (const Level& level : levels_) {
    const double square_px = 4.0 * level.cell_px;
    if (circle.r_px < 0.5 * square_px || circle.r_px > 3.0 * square_px) continue;
    const double reach = near_px / square_px + 1.0;
    const double x = (circle.x_px + 0.5) / square_px - 0.5;
    const double y = (circle.y_px + 0.5) / square_px - 0.5;
    const auto within = [](double cell, int cells) {  // -1 and `cells`: beyond the ends
      return static_cast<int>(std::clamp(cell, -1.0, static_cast<double>(cells)));
    };
    const int columns = level.columns / 4;
    const int rows = level.rows / 4;
    const int x_end = std::min(columns - 1, within(std::floor(x + reach), columns));
    const int y_end = std::min(rows - 1, within(std::floor(y + reach), rows));
    for (int row = std::max(0, within(std::ceil(y - reach), rows)); row <= y_end; ++row) {
      for (int column = std::max(0, within(std::ceil(x - reach), columns)); column <= x_end; ++column) {
        const Found here = circle_of(level, column, row);
        if (here.log_odds <= best.log_odds || std::abs(here.circle.r_px - circle.r_px) > near_px ||
            std::hypot(here.circle.x_px - circle.x_px, here.circle.y_px - circle.y_px) > near_px)
          continue;
        best = here;
      }
    }
  }
  return best;
}

}  // namespace saccade
