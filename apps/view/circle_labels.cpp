#include "apps/view/circle_labels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"

namespace saccade {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

bool shows_ball(const TruthRow& row) { return row.visible > 0.0 && std::isfinite(row.circle.x_px); }

/// The circle at `t_us` on the line through those of two rows; a radius stays positive.
Circle on_line(const TruthRow& a, const TruthRow& b, std::int64_t t_us) {
  const double share = static_cast<double>(t_us - a.t_us) / static_cast<double>(b.t_us - a.t_us);
  const auto between = [share](double from, double to) { return from + share * (to - from); };
  return {between(a.circle.x_px, b.circle.x_px), between(a.circle.y_px, b.circle.y_px),
          std::max(0.5, between(a.circle.r_px, b.circle.r_px))};
}

double rounded(double px) { return std::round(100.0 * px) / 100.0; }

}  // namespace

CircleLabels CircleLabels::read(const std::filesystem::path& table) {
  CircleLabels labels;
  labels.rows_ = read_table<TruthRow>(table);
  const auto twice = std::ranges::adjacent_find(labels.rows_, {}, &TruthRow::t_us);
  if (twice != labels.rows_.end())
    throw InputError(table.string(), "two rows at " + std::to_string(twice->t_us) + " us",
                     "one row for each instant");
  return labels;
}

void CircleLabels::write(const std::filesystem::path& table) const {
  TableWriter<TruthRow> writer(table);
  for (const TruthRow& row : rows_) writer.write(row);
  writer.commit();
}

const TruthRow* CircleLabels::at(std::int64_t t_us) const {
  const auto row = std::ranges::lower_bound(rows_, t_us, {}, &TruthRow::t_us);
  return row != rows_.end() && row->t_us == t_us ? &*row : nullptr;
}

const TruthRow* CircleLabels::before(std::int64_t t_us) const {
  const auto row = std::ranges::lower_bound(rows_, t_us, {}, &TruthRow::t_us);
  return row == rows_.begin() ? nullptr : &*std::prev(row);
}

const TruthRow* CircleLabels::after(std::int64_t t_us) const {
  const auto row = std::ranges::upper_bound(rows_, t_us, {}, &TruthRow::t_us);
  return row == rows_.end() ? nullptr : &*row;
}

TruthRow& CircleLabels::row_of(std::int64_t t_us) {
  auto row = std::ranges::lower_bound(rows_, t_us, {}, &TruthRow::t_us);
  if (row == rows_.end() || row->t_us != t_us) row = rows_.insert(row, TruthRow{});
  row->t_us = t_us;
  row->position_m.setConstant(none);  // of another circle
  return *row;
}

void CircleLabels::place(std::int64_t t_us, const Circle& circle) {
  TruthRow& row = row_of(t_us);
  row.circle = {rounded(circle.x_px), rounded(circle.y_px), rounded(circle.r_px)};
  row.visible = 1.0;
}

void CircleLabels::hide(std::int64_t t_us) {
  TruthRow& row = row_of(t_us);
  row.circle = {none, none, none};
  row.visible = 0.0;
}

void CircleLabels::remove(std::int64_t t_us) {
  std::erase_if(rows_, [t_us](const TruthRow& row) { return row.t_us == t_us; });
}

std::optional<Circle> CircleLabels::hint(std::int64_t t_us) const {
  if (const TruthRow* row = at(t_us)) return shows_ball(*row) ? std::optional(row->circle) : std::nullopt;
  const TruthRow* const left = before(t_us);
  const TruthRow* const right = after(t_us);
  if ((left != nullptr && !shows_ball(*left)) || (right != nullptr && !shows_ball(*right)))
    return std::nullopt;
  if (left != nullptr && right != nullptr) return on_line(*left, *right, t_us);
  const TruthRow* const nearest = left != nullptr ? left : right;
  if (nearest == nullptr) return std::nullopt;
  const TruthRow* const second = left != nullptr ? before(left->t_us) : after(right->t_us);
  if (second == nullptr || !shows_ball(*second)) return nearest->circle;
  const std::int64_t apart_us = std::abs(nearest->t_us - second->t_us);
  return on_line(*second, *nearest, std::clamp(t_us, nearest->t_us - apart_us, nearest->t_us + apart_us));
}

}  // namespace saccade
