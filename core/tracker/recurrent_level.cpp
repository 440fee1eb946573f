#include "core/tracker/recurrent_level.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/tracker/network_kernels.h"
#include "core/vector_clones.h"

namespace saccade {
namespace {

using namespace network_kernels;
using Model = RecurrentModel;
constexpr std::array<int, Model::blocks> dilation = {1, 2, 2, 3};
constexpr std::array<int, Model::blocks> memory_of = {-1, 0, -1, 1};
constexpr float gate_step_ms = 5.0F;
constexpr std::size_t C = Model::channels;
static_assert(sizeof(RecurrentLevel::Square) == Model::outputs * sizeof(float));

/// x = exp(x) of eight numbers in [-87, 87], relative error 2e-7, by range reduction and the series to the sixth power.
[[gnu::always_inline]] inline void to_exp(Lanes& x) {
  using Integers [[gnu::vector_size(32)]] = std::int32_t;
  constexpr float round = 12582912.0F;  // 1.5 x 2^23
  const Lanes n = (x * 1.44269504F + round) - round;
  const Lanes r = (x - n * 0.693359375F) + n * 2.12194440e-4F;  // ln 2 in two parts
  const Lanes series =
      (((((r * (1.0F / 720) + 1.0F / 120) * r + 1.0F / 24) * r + 1.0F / 6) * r + 0.5F) * r + 1.0F) * r + 1.0F;
  const Integers exponent = (__builtin_convertvector(n, Integers) + 127) << 23;
  x = series * reinterpret_cast<const Lanes&>(exponent);
}

/// gate = exp(-softplus(gate) share): what the memory keeps.
[[gnu::always_inline]] inline void to_kept(Lanes& gate, float share) {
  const Lanes zero{};
  const Lanes limit = zero + 80.0F;
  const Lanes positive = gate > zero ? gate : zero;
  Lanes e = gate > zero ? -gate : gate;
  e = e > -limit ? e : -limit;
  to_exp(e);
  const Lanes s = e / (e + 2.0F);  // ln(1 + e) = 2 artanh(s)
  const Lanes z = s * s;
  const Lanes series =
      (((((z * (1.0F / 13) + 1.0F / 11) * z + 1.0F / 9) * z + 1.0F / 7) * z + 0.2F) * z + 1.0F / 3) * z +
      1.0F;
  gate = (positive + 2.0F * s * series) * -share;
  gate = gate > -limit ? gate : -limit;
  to_exp(gate);
}

struct Block {
  const float *depth, *point, *bias;
  const Model::Memory* memory;  // or null
  float share;                  // dt / gate_step_ms
  int dilation;
};

/// A memory's step at one place: `remembered` moves towards `deep`.
[[gnu::always_inline]] inline void remember(const float* in, const float* deep, const Model::Memory& weights,
                                            float share, float* remembered) {
  float low[1][Model::rank];
  Channels<Model::rank> low_sum[1]{};
  float own[1][C];
  std::copy_n(in, C, own[0]);
  pointwise(own, weights.down.data(), low_sum);
  for (std::size_t i = 0; i < Model::rank / lanes; ++i)
    reinterpret_cast<Lanes*>(low[0])[i] = low_sum[0].part[i];
  Channels<C> gate[1];
  load(weights.up_bias.data(), gate[0]);
  pointwise(low, weights.up.data(), gate);
  for (std::size_t i = 0; i < C / lanes; ++i) {
    Lanes& kept = gate[0].part[i];
    to_kept(kept, share);
    Lanes& h = reinterpret_cast<Lanes*>(remembered)[i];
    h = h * kept + (1.0F - kept) * reinterpret_cast<const Lanes*>(deep)[i];
  }
}

template <std::size_t places, bool recurrent>
[[gnu::always_inline]] inline void block_places(const Map& in, int y, int x, const Block& block,
                                                float* memory, float* out) {
  float deep[places][C];
  Channels<C> sum[places];
  for (std::size_t p = 0; p < places; ++p) {
    depthwise<C>(in, y, x + static_cast<int>(p), block.dilation, block.depth, deep[p]);
    load(block.bias, sum[p]);
  }
  pointwise(deep, block.point, sum);
  const std::size_t first = static_cast<std::size_t>(y * in.columns + x);
  if constexpr (recurrent) {
    for (std::size_t p = 0; p < places; ++p) {
      float* own = memory + (first + p) * C;
      remember(in.values + (first + p) * C, deep[p], *block.memory, block.share, own);
      std::copy_n(own, C, deep[p]);
    }
    pointwise(deep, block.memory->out.data(), sum);
  }
  for (std::size_t p = 0; p < places; ++p) {
    Channels<C> own;
    load(in.values + (first + p) * C, own);
    for (std::size_t i = 0; i < C / lanes; ++i) sum[p].part[i] = own.part[i] + sum[p].part[i];
    store_positive(sum[p], out + (first + p) * C);
  }
}

SACCADE_VECTOR_CLONES
void block_row(const Map& in, int y, const Block& block, float* out) {
  int x = 0;
  for (; x + 1 < in.columns; x += 2) block_places<2, false>(in, y, x, block, nullptr, out);
  for (; x < in.columns; ++x) block_places<1, false>(in, y, x, block, nullptr, out);
}

SACCADE_VECTOR_CLONES
void recurrent_block_row(const Map& in, int y, const Block& block, float* memory, float* out) {
  int x = 0;
  for (; x + 1 < in.columns; x += 2) block_places<2, true>(in, y, x, block, memory, out);
  for (; x < in.columns; ++x) block_places<1, true>(in, y, x, block, memory, out);
}

/// A row of every second place of every second row, depthwise and pointwise.
SACCADE_VECTOR_CLONES
void second_row(const Map& in, int y, const Model& model, const float* bias, float* out) {
  constexpr std::size_t from = Model::first_channels;
  for (int x = 0; 2 * x < in.columns; ++x, out += C) {
    float deep[1][from];
    depthwise<from>(in, 2 * y, 2 * x, 1, model.second_depth.data(), deep[0]);
    Channels<C> sum[1];
    load(bias, sum[0]);
    pointwise(deep, model.second_point.data(), sum);
    store_positive(sum[0], out);
  }
}

SACCADE_VECTOR_CLONES
void first_row_of(const Map& in, int y, const Model& weights, float* out) {
  input_halved_row(in, y, weights, out);
}

/// Moves a map of squares by (x, y); what comes in is 0.
void move_squares(std::vector<float>& map, int rows, int columns, int x, int y) {
  if (x == 0 && y == 0) return;
  const auto place = [&](int row, int column) {
    return map.begin() + static_cast<std::ptrdiff_t>(row * columns + column) * static_cast<std::ptrdiff_t>(C);
  };
  if (std::abs(x) >= columns || std::abs(y) >= rows) {
    std::fill(map.begin(), map.end(), 0.0F);
    return;
  }
  for (int n = 0; n < rows; ++n) {
    const int to = y > 0 ? rows - 1 - n : n;  // no row is overwritten before it has moved
    const int from = to - y;
    if (from < 0 || from >= rows) {
      std::fill(place(to, 0), place(to, columns), 0.0F);
    } else if (x >= 0) {
      std::move_backward(place(from, 0), place(from, columns - x), place(to, columns));
      std::fill(place(to, 0), place(to, x), 0.0F);
    } else {
      std::move(place(from, -x), place(from, columns), place(to, 0));
      std::fill(place(to, columns + x), place(to, columns), 0.0F);
    }
  }
}

}  // namespace

void RecurrentLevel::Maps::reserve(int rows, int columns) {
  const auto cells = static_cast<std::size_t>(rows * columns);
  const auto grow = [](std::vector<float>& map, std::size_t size) { map.resize(std::max(map.size(), size)); };
  grow(first, cells / 4 * Model::first_channels);
  grow(a, cells / 16 * C);
  grow(b, cells / 16 * C);
}

RecurrentLevel::RecurrentLevel(std::shared_ptr<const RecurrentModel> model, int rows, int columns)
    : model_(std::move(model)), rows_(rows), columns_(columns), bias_{} {
  const auto squares = static_cast<std::size_t>(rows * columns / (square * square));
  for (std::vector<float>& memory : memory_) memory.assign(squares * C, 0.0F);
  input_.assign(static_cast<std::size_t>(rows * columns) * Model::inputs, 0.0F);
  Square none{};
  none.log_odds = none.inlier_log_odds = -20.0F;
  output_.assign(squares, none);
}

void RecurrentLevel::begin(const Step& step) {
  for (std::vector<float>& memory : memory_)
    move_squares(memory, rows_ / square, columns_ / square, step.shift_x, step.shift_y);
  dt_ms_ = step.dt_ms;
  std::array<float, Model::motion_inputs> motion{};
  if (step.rotation_known) {
    for (std::size_t i = 0; i < 2; ++i)
      motion[i] = std::copysign(std::log1p(std::abs(step.speed[i])), step.speed[i]);
    motion[2] = 1.0F;
  }
  std::array<float, Model::motion_hidden> hidden = model_->motion_bias;
  for (std::size_t i = 0; i < motion.size(); ++i) {
    for (std::size_t k = 0; k < hidden.size(); ++k)
      hidden[k] += motion[i] * model_->motion_in[i * hidden.size() + k];
  }
  for (std::size_t n = 0; n < bias_.size(); ++n)
    bias_[n] = n == 0 ? model_->second_bias : model_->bias[n - 1];
  for (std::size_t k = 0; k < hidden.size(); ++k) {
    if (hidden[k] <= 0.0F) continue;
    for (std::size_t n = 0; n < bias_.size(); ++n) {
      for (std::size_t c = 0; c < C; ++c)
        bias_[n][c] += hidden[k] * model_->motion_out[(k * bias_.size() + n) * C + c];
    }
  }
  stage_ = 0;
  row_ = 0;
}

std::int64_t RecurrentLevel::multiplications() const {
  constexpr std::size_t per_square = 4 * 9 * Model::inputs * Model::first_channels +
                                     Model::first_channels * (9 + C) + Model::blocks * C * (9 + C) +
                                     Model::memories * C * (C + 2 * Model::rank) + C * Model::outputs;
  return static_cast<std::int64_t>(per_square) * (rows_ / square) * (columns_ / square);
}

std::int64_t RecurrentLevel::row(Maps& maps) {
  if (!busy()) return 0;
  const auto places = static_cast<std::int64_t>(columns_ / square);
  const auto at = static_cast<std::size_t>(row_);
  int rows = rows_ / square;
  std::int64_t cost = 0;
  if (stage_ == 0) {
    rows = rows_ / 2;
    float* out = maps.first.data() + at * static_cast<std::size_t>(columns_ / 2) * Model::first_channels;
    first_row_of({input_.data(), rows_, columns_}, row_, *model_, out);
    cost = 2 * places * static_cast<std::int64_t>(9 * Model::inputs * Model::first_channels);
  } else if (stage_ == 1) {
    float* out = maps.a.data() + at * static_cast<std::size_t>(places) * C;
    second_row({maps.first.data(), rows_ / 2, columns_ / 2}, row_, *model_, bias_[0].data(), out);
    cost = places * static_cast<std::int64_t>(Model::first_channels * (9 + C));
  } else if (stage_ + 1 < stages) {
    const std::size_t n = stage_ - 2;
    const int k = memory_of[n];
    const Model::Memory* memory = k < 0 ? nullptr : &model_->memory[static_cast<std::size_t>(k)];
    const Block block{model_->depth[n].data(), model_->point[n].data(),
                      bias_[1 + n].data(),     memory,
                      dt_ms_ / gate_step_ms,   dilation[n]};
    const Map in{maps.a.data(), rows, columns_ / square};
    cost = places * static_cast<std::int64_t>(C * (9 + C));
    if (memory == nullptr) {
      block_row(in, row_, block, maps.b.data());
    } else {
      recurrent_block_row(in, row_, block, memory_[static_cast<std::size_t>(k)].data(), maps.b.data());
      cost += places * static_cast<std::int64_t>(C * (C + 2 * Model::rank + 40));
    }
  } else {
    for (std::size_t x = 0; x < static_cast<std::size_t>(places); ++x) {
      const std::size_t p = at * static_cast<std::size_t>(places) + x;
      const float* in = maps.a.data() + p * C;
      std::array<float, Model::outputs> sum = model_->output_bias;
      for (std::size_t c = 0; c < C; ++c) {
        for (std::size_t o = 0; o < sum.size(); ++o) sum[o] += in[c] * model_->output[c * sum.size() + o];
      }
      output_[p] = {sum[0], sum[1], sum[2], sum[3], sum[4], sum[5], sum[6], sum[7], sum[8]};
    }
    cost = places * static_cast<std::int64_t>(C * Model::outputs);
  }
  if (++row_ < rows) return cost;
  row_ = 0;
  if (stage_ >= 2 && stage_ + 1 < stages) std::swap(maps.a, maps.b);
  ++stage_;
  return cost;
}

}  // namespace saccade
