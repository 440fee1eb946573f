#include "sim/keyframe.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>

namespace saccade::detail {
namespace {

/// An interval of samples around the middle of a sample: it begins in sample `first` and ends in sample `last`, counted
/// from that sample, and leaves out the share first_part of the first and takes the share last_part of the last.
struct Interval {
  int first;
  int last;
  float first_part;
  float last_part;
  float length;
};

Interval interval_between(float begin, float end) {
  const float first = std::floor(begin);
  const float last = std::floor(end);
  return {static_cast<int>(first), static_cast<int>(last), begin - first, end - last, end - begin};
}

Interval interval_of(float width) { return interval_between(0.5F - 0.5F * width, 0.5F + 0.5F * width); }

/// The same around `sample` of the samples [first, end), cut at their border.
Interval cut_interval(float width, int sample, int first, int end) {
  const auto at = static_cast<float>(sample);
  Interval interval = interval_between(std::max(at + 0.5F - 0.5F * width, static_cast<float>(first)),
                                       std::min(at + 0.5F + 0.5F * width, static_cast<float>(end) - 0.001F));
  interval.first -= sample;
  interval.last -= sample;
  return interval;
}

/// Gives every 0 of the row the nearest value that is not; nothing if all are 0.
void fill_row(float* row, std::size_t columns) {
  std::size_t begin = 0;  // of the zeros before i
  for (std::size_t i = 0; i < columns; ++i) {
    if (!(row[i] > 0.0F)) continue;
    const std::size_t middle = begin == 0 ? 0 : begin + (i - begin) / 2;
    if (begin > 0) std::fill(row + begin, row + middle, row[begin - 1]);
    std::fill(row + middle, row + i, row[i]);
    begin = i + 1;
  }
  if (begin > 0) std::fill(row + begin, row + columns, row[begin - 1]);
}

/// Makes room for at least `count` values, which are not kept.
template <class Vector>
void make_room(Vector& values, std::size_t count) {
  if (values.size() < count) values.resize(count);
}

/// Adds a row of the room's depths to the sums of its blocks.
void add_to_blocks(Keyframe& k, int row, const float* depths) {
  float* sum = k.inverse_depth_1_m.data() +
               static_cast<std::size_t>(row / k.block) * static_cast<std::size_t>(k.block_columns);
  if (row % k.block == 0) std::fill_n(sum, k.block_columns, 0.0F);
  for (int begin = 0; begin < k.rect.columns(); begin += k.block, ++sum) {
    for (int i = begin; i < std::min(begin + k.block, k.rect.columns()); ++i) *sum += depths[i];
  }
}

}  // namespace

/// How the samples of a row are summed: samples that share a PixelSize share the interval.
void KeyframeFilter::set_row_runs(const Keyframe& k, int row, Band& band) const {
  const SampleRect& rect = k.rect;
  const int before = rect.left - k.drawn.left;  // samples that are drawn and not kept
  const int columns = rect.columns();
  const auto run_of = [&](int begin, int end, const Interval& over) {
    const std::uint32_t* const first = band.row_sums.data() + over.first;
    const std::uint32_t* const last = band.row_sums.data() + over.last;
    return MeanRun{
        begin, end, first, first + 1, last, last + 1, over.first_part, over.last_part, 1.0F / over.length};
  };
  band.runs.clear();
  float width = 0.0F;  // of the pixels of the newest run
  for (int begin = 0; begin < columns;) {
    const int end = std::min(columns, KeyframeCamera::next_cell(rect.left + begin) - rect.left);
    const float cell_width = camera_->pixel_at(rect.left + begin, rect.top + row).width;
    const Interval over = interval_of(cell_width);
    if (begin + over.first >= 0 && end + over.last <= columns) {
      if (cell_width == width)
        band.runs.back().end = end;
      else
        band.runs.push_back(run_of(begin, end, over));
      width = cell_width;
    } else {
      for (int i = begin; i < end; ++i)
        band.runs.push_back(run_of(i, i + 1, cut_interval(cell_width, before + i, before, before + columns)));
      width = 0.0F;
    }
    begin = end;
  }
}

/// How rows are summed to the values of `row`, from the sums along columns, of which `ring` rows are kept.
void KeyframeFilter::set_column_runs(const Keyframe& k, int row, int ring, float scale, Band& band) const {
  const SampleRect& rect = k.rect;
  const int before = rect.top - k.drawn.top;
  const int columns = rect.columns();
  const auto sums_before = [&](int at) {
    return band.sums.data() + static_cast<std::ptrdiff_t>(at % ring) * columns;
  };
  band.column_runs.clear();
  float height = 0.0F;
  for (int begin = 0; begin < columns;) {
    const int end = std::min(columns, KeyframeCamera::next_cell(rect.left + begin) - rect.left);
    const float cell_height = camera_->pixel_at(rect.left + begin, rect.top + row).height;
    if (cell_height == height) {
      band.column_runs.back().end = end;
    } else {
      const Interval over = cut_interval(cell_height, before + row, before, before + rect.rows());
      const int first = row + over.first;
      const int last = row + over.last;
      band.column_runs.push_back({begin, end, sums_before(first), sums_before(first + 1), sums_before(last),
                                  sums_before(last + 1), over.first_part, over.last_part,
                                  scale / over.length});
    }
    height = cell_height;
    begin = end;
  }
}

/// Means of samples over the area of a pixel around each, times `scale`, rounded, as pairs of a sample and the one below it:
/// the pairs of the rows [begin, end), each per_sample after the one before. `row_of(row, out)` gives samples. Sums are whole
/// numbers modulo 2^32, so that differences are exact, whatever row the sums begin with.
template <class RowOf>
void KeyframeFilter::mean_over_pixels(const Keyframe& k, int begin, int end, const RowOf& row_of, float scale,
                                      std::uint16_t* pairs, std::size_t per_sample, Band& band) const {
  const SampleRect& rect = k.rect;
  const int columns = rect.columns();
  const int rows = rect.rows();
  const auto width = static_cast<std::size_t>(columns);
  const int reach = camera_->reach();
  const int ring = 2 * reach + 2;
  make_room(band.samples, width);
  make_room(band.row_sums, width + 1);
  make_room(band.sums, static_cast<std::size_t>(ring) * width);
  make_room(band.values, 2 * width);
  const auto sums_before = [&](int row) {
    return band.sums.data() + static_cast<std::size_t>(row % ring) * width;
  };
  const auto values_of = [&](int row) {
    return band.values.data() + static_cast<std::size_t>(row % 2) * width;
  };
  const auto write_pairs = [&](int row, int below) {
    interleave_rows(values_of(row), values_of(below),
                    pairs + per_sample * static_cast<std::size_t>(row) * width, per_sample, width);
  };
  int next = std::max(0, begin - reach);  // the next row to add to the sums
  std::fill_n(sums_before(next), width, 0U);
  int cell_row = -1;
  for (int row = begin; row < std::min(end + 1, rows); ++row) {
    for (; next < std::min(row + reach + 1, rows); ++next) {
      if (const int cell = KeyframeCamera::next_cell(rect.top + next); cell != cell_row) {
        cell_row = cell;
        set_row_runs(k, next, band);
      }
      row_of(next, band.samples.data());
      std::uint32_t sum = 0;
      for (std::size_t i = 0; i < width; ++i) {
        band.row_sums[i] = sum;
        sum += band.samples[i];
      }
      band.row_sums[width] = sum;
      add_means(band.runs, sums_before(next), sums_before(next + 1));
    }
    set_column_runs(k, row, ring, scale, band);
    write_means(band.column_runs, values_of(row));
    if (row > begin) write_pairs(row - 1, row);
  }
  if (end == rows) write_pairs(rows - 1, rows - 1);
}

void KeyframeFilter::average_colours(Keyframe& k, const Drawn& drawn, int begin, int end, Band& band) const {
  const auto columns = static_cast<std::size_t>(k.rect.columns());
  const auto at = [&](int row) { return static_cast<std::size_t>(k.rect.rows() - 1 - row) * columns; };
  const std::size_t per_sample = drawn.is_room ? 2 : 4;
  mean_over_pixels(
      k, begin, end,
      [&](int row, std::uint32_t* out) {
        luminance_row(drawn.rgba.data() + at(row), drawn.depth.data() + at(row), out, columns);
      },
      1.0F / (static_cast<float>(luminance_unit) * Keyframe::luminance_step), k.samples.data(), per_sample,
      band);
  if (drawn.is_room) return;
  constexpr std::uint32_t full = 1U << 20U;
  mean_over_pixels(
      k, begin, end,
      [&](int row, std::uint32_t* out) { cover_row(drawn.depth.data() + at(row), full, out, columns); },
      1.0F / (static_cast<float>(full) * Keyframe::cover_step), k.samples.data() + 2, per_sample, band);
}

/// Inverse depths of the rows [begin, end): of the room as means over blocks, of a body as they are and continued to the left
/// and right of it.
void KeyframeFilter::copy_depths(Keyframe& k, const Drawn& drawn, int begin, int end, Band& band) {
  const auto columns = static_cast<std::size_t>(k.rect.columns());
  const int rows = k.rect.rows();
  const auto at_near = static_cast<float>(1.0 / drawn.near_m);
  const auto per_depth = static_cast<float>((drawn.far_m - drawn.near_m) / (drawn.near_m * drawn.far_m));
  const float nothing = drawn.is_room ? static_cast<float>(1.0 / drawn.far_m) : 0.0F;
  make_room(band.depths, 2 * columns);
  const auto room_for = [&](int row) {
    return !drawn.is_room && row >= begin ? drawn_1_m_.data() + static_cast<std::size_t>(row) * columns
                                          : band.depths.data() + static_cast<std::size_t>(row % 2) * columns;
  };
  const auto read_row = [&](int row) {
    const float* const from = drawn.depth.data() + static_cast<std::size_t>(rows - 1 - row) * columns;
    inverse_depth_row(from, at_near, per_depth, nothing, room_for(row), columns);
  };
  band.range = {};
  band.step = 0;
  band.count = 0;
  if (begin > 0 && begin < end) read_row(begin - 1);
  for (int row = begin; row < end; ++row) {
    read_row(row);
    const float* const q = room_for(row);
    include_row(q, columns, band.range);
    band.step = largest_step(q + 1, q, columns - 1, band.step);
    if (row > 0) band.step = largest_step(q, room_for(row - 1), columns, band.step);
    if (drawn.is_room) {
      add_to_blocks(k, row, q);
      continue;
    }
    float* const continued = continued_1_m_.data() + static_cast<std::size_t>(row) * columns;
    std::copy_n(q, columns, continued);
    fill_row(continued, columns);
    row_sums_1_m_[static_cast<std::size_t>(row)] = sum_of_row(q, columns);
    band.count += std::count_if(q, q + columns, [](float value) { return value > 0.0F; });
  }
}

/// Sets what is known of all rows: range and mean of the depths.
void KeyframeFilter::sum_up(Keyframe& k, bool is_room) {
  FloatRange range;
  std::int32_t step = 0;
  std::ptrdiff_t count = 0;
  for (const Band& band : bands_) {
    range = {std::min(range.least, band.range.least), std::max(range.most, band.range.most)};
    step = std::max(step, band.step);
    count += band.count;
  }
  k.nearest_1_m = static_cast<double>(std::bit_cast<float>(range.most));
  k.farthest_1_m = static_cast<double>(std::bit_cast<float>(range.least));
  k.largest_step_1_m = static_cast<double>(std::bit_cast<float>(step));
  double sum = 0.0;
  if (!is_room) {
    for (const double of_row : row_sums_1_m_) sum += of_row;
    k.mean_1_m = sum / static_cast<double>(count);
    return;
  }
  for (int row = 0; row < k.block_rows; ++row) {
    const int height = std::min(k.block, k.rect.rows() - row * k.block);
    for (int column = 0; column < k.block_columns; ++column) {
      const int width = std::min(k.block, k.rect.columns() - column * k.block);
      float& mean = k.inverse_depth_1_m[static_cast<std::size_t>(row * k.block_columns + column)];
      sum += static_cast<double>(mean);
      mean /= static_cast<float>(width * height);
    }
  }
  k.mean_1_m = sum / static_cast<double>(k.rect.area());
}

/// Continues the depths of a layer's outline above and below it, as copy_depths does to the left and right: a pixel that the
/// outline cuts moves as the outline does.
void KeyframeFilter::continue_outwards(std::size_t columns) {
  const auto row_at = [&](std::size_t row) { return continued_1_m_.data() + row * columns; };
  std::size_t begin = 0;  // of the empty rows before `row`
  for (std::size_t row = 0; row < row_sums_1_m_.size(); ++row) {
    if (!(row_sums_1_m_[row] > 0.0)) continue;
    const std::size_t middle = begin == 0 ? 0 : begin + (row - begin) / 2;
    for (std::size_t i = begin; i < row; ++i)
      std::copy_n(row_at(i < middle ? begin - 1 : row), columns, row_at(i));
    begin = row + 1;
  }
  for (std::size_t i = begin; i < row_sums_1_m_.size(); ++i)
    std::copy_n(row_at(begin - 1), columns, row_at(i));
}

/// Pixels that the outline cuts are nearly as far away as the outline, and it moves as they do: samples less than a pixel's
/// half diagonal inside the outline get its depth. Of the rows [begin, end).
void KeyframeFilter::take_outline_depths(Keyframe& k, int begin, int end, Band& band) const {
  const auto columns = static_cast<std::size_t>(k.rect.columns());
  const int rows = k.rect.rows();
  const auto reach = static_cast<int>(std::lround(0.7 * camera_->samples()));
  const int across = 2 * reach + 1;
  // Least values along the rows in reach, of the drawn and of the continued depths; values beyond the border do not count.
  make_room(band.least, static_cast<std::size_t>(2 * across + 2) * columns);
  band.padded.assign(columns + static_cast<std::size_t>(2 * reach), std::numeric_limits<float>::max());
  const auto least_of = [&](int part) {
    return band.least.data() + static_cast<std::size_t>(part) * columns;
  };
  const auto add_row = [&](const LargeVector<float>& depths, int row, float* out) {
    std::copy_n(depths.data() + static_cast<std::size_t>(row) * columns, columns, band.padded.data() + reach);
    least_along_row(band.padded.data(), static_cast<std::size_t>(across), out, columns);
  };
  float* const least_drawn = least_of(2 * across);
  float* const least_continued = least_of(2 * across + 1);
  int next = std::max(0, begin - reach);  // the next row to add
  for (int row = begin; row < end; ++row) {
    const int until = std::min(row + reach + 1, rows);
    for (; next < until; ++next) {
      add_row(drawn_1_m_, next, least_of(next % across));
      add_row(continued_1_m_, next, least_of(across + next % across));
    }
    std::copy_n(least_of(row % across), columns, least_drawn);
    std::copy_n(least_of(across + row % across), columns, least_continued);
    for (int other = std::max(0, row - reach); other < until; ++other) {
      take_smaller(least_of(other % across), least_drawn, columns);
      take_smaller(least_of(across + other % across), least_continued, columns);
    }
    const std::size_t first = static_cast<std::size_t>(row) * columns;
    choose_row(least_drawn, continued_1_m_.data() + first, least_continued,
               k.inverse_depth_1_m.data() + first, columns);
  }
}

SampleRect KeyframeFilter::covered_part(const SampleRect& drawn, std::span<const float> depth) const {
  const auto columns = static_cast<std::ptrdiff_t>(drawn.columns());
  SampleRect part{drawn.right, drawn.bottom, drawn.left, drawn.top};
  const auto is_here = [](float value) { return value < 1.0F; };
  for (int row = drawn.top; row < drawn.bottom; ++row) {
    const float* const begin = depth.data() + static_cast<std::ptrdiff_t>(drawn.bottom - 1 - row) * columns;
    const float* const end = begin + columns;
    const float* const first = std::find_if(begin, end, is_here);
    if (first == end) continue;
    const auto last = std::find_if(std::reverse_iterator(end), std::reverse_iterator(first), is_here);
    part = {std::min(part.left, drawn.left + static_cast<int>(first - begin)), std::min(part.top, row),
            std::max(part.right, drawn.left + static_cast<int>(last.base() - begin)), row + 1};
  }
  if (part.is_empty()) return {};
  const int above = std::max(2 * camera_->samples(), camera_->reach() + 1);  // more than a pixel
  // The cells that set_row_runs() cuts at the border are empty, and sum_of_row() adds whole groups.
  const int beside = std::max(above, KeyframeCamera::cell + 2 * camera_->reach() + 1);
  constexpr auto group = static_cast<int>(columns_summed_at_once);
  const int left = std::max(0, part.left - beside - drawn.left) / group * group;
  const int right = (part.right + beside - drawn.left + group - 1) / group * group;
  return SampleRect{drawn.left + left, part.top - above, drawn.left + right, part.bottom + above}.cut(drawn);
}

void KeyframeFilter::fill(Keyframe& k, const Drawn& drawn, WorkerThreads& threads) {
  const auto columns = static_cast<std::size_t>(k.rect.columns());
  const int rows = k.rect.rows();
  k.block = drawn.is_room ? camera_->samples() : 1;
  k.block_columns = (k.rect.columns() + k.block - 1) / k.block;
  k.block_rows = (rows + k.block - 1) / k.block;
  // A point reads a sample and the next, also where a row has one.
  make_room(k.samples, (drawn.is_room ? 2 : 4) * (k.rect.area() + 1));
  make_room(k.inverse_depth_1_m,
            static_cast<std::size_t>(k.block_columns) * static_cast<std::size_t>(k.block_rows));
  if (!drawn.is_room) {
    make_room(drawn_1_m_, k.rect.area());
    make_room(continued_1_m_, k.rect.area());
    row_sums_1_m_.resize(static_cast<std::size_t>(rows));
  }
  const auto count = static_cast<std::int64_t>(threads.threads());
  bands_.resize(threads.threads());
  const auto first_row = [&](std::size_t band) {
    return std::min(rows, k.block * static_cast<int>(k.block_rows * static_cast<std::int64_t>(band) / count));
  };
  threads.run([&](std::size_t i) {
    average_colours(k, drawn, first_row(i), first_row(i + 1), bands_[i]);
    copy_depths(k, drawn, first_row(i), first_row(i + 1), bands_[i]);
  });
  sum_up(k, drawn.is_room);
  if (drawn.is_room) return;
  continue_outwards(columns);
  threads.run([&](std::size_t i) { take_outline_depths(k, first_row(i), first_row(i + 1), bands_[i]); });
}

}  // namespace saccade::detail
