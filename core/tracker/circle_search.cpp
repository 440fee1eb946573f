#include "core/tracker/circle_search.h"

#include <algorithm>
#include <cmath>

#include "core/detector_parts.h"

namespace saccade {
namespace {

constexpr double level_radius_cells = 16.0;  // larger radii belong to the next level
constexpr double outline_cells = 1.5;        // half the width of the ring that a circle explains
constexpr int fewest_votes = 4;              // three points lie on a circle by chance
constexpr std::size_t most_found = 32;

}  // namespace

CircleSearch::CircleSearch(ImageSize size, double r_min_px, double r_max_px, double arc_rad,
                           std::size_t max_edges)
    : max_edges_(max_edges) {
  for (int cell = 1;; cell *= 2) {
    const double end_px = level_radius_cells * cell;
    if (r_min_px < end_px) {
      const double begin_px = cell == 1 ? r_min_px : std::max(r_min_px, end_px / 2);
      const ImageSize cells{(size.width + cell - 1) / cell, (size.height + cell - 1) / cell};
      levels_.push_back(
          {cell,
           HoughTransform(cells, static_cast<int>(std::floor(begin_px / cell)),
                          static_cast<int>(std::ceil(std::min(r_max_px, end_px) / cell)), arc_rad),
           std::vector<std::uint8_t>(static_cast<std::size_t>(cells.pixels())),
           {}});
      levels_.back().votes.reserve(max_edges);
    }
    if (r_max_px <= end_px) break;
  }
  found_.reserve(most_found);
}

bool CircleSearch::clear(std::size_t count) {
  bool cleared = true;
  for (Level& level : levels_) {
    for (std::size_t i = 0; i < count && !level.votes.empty(); ++i) {
      const Vote vote = level.votes.back();
      level.votes.pop_back();
      if (!vote.explained) level.transform.vote_arcs<-1>(vote.x, vote.y, vote.direction);
      level.taken[static_cast<std::size_t>(vote.y * level.transform.size().width + vote.x)] = 0;
    }
    cleared = cleared && level.votes.empty();
  }
  return cleared;
}

void CircleSearch::add(const Eigen::Vector2d& at_px, int direction) {
  for (Level& level : levels_) {
    if (level.votes.size() >= max_edges_) continue;
    const ImageSize size = level.transform.size();
    const Eigen::Vector2d cell = (at_px.array() + 0.5) / level.cell_px;
    if (!(cell.x() >= 0.0 && cell.y() >= 0.0 && cell.x() < size.width && cell.y() < size.height)) continue;
    const int x = static_cast<int>(cell.x());
    const int y = static_cast<int>(cell.y());
    const auto quarter = static_cast<std::uint8_t>(1 << (direction * 4 / HoughTransform::direction_count));
    std::uint8_t& taken = level.taken[static_cast<std::size_t>(y * size.width + x)];
    if ((taken & quarter) != 0) continue;
    taken = static_cast<std::uint8_t>(taken | quarter);
    level.votes.push_back({static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y),
                           static_cast<std::int16_t>(direction), false});
    level.transform.vote_arcs<1>(x, y, direction);
  }
}

std::span<const CircleSearch::Found> CircleSearch::find(std::size_t count) {
  found_.clear();
  for (Level& level : levels_) {
    const double cell = level.cell_px;
    for (std::size_t i = 0; i < count && found_.size() < most_found; ++i) {
      const HoughTransform::Peak peak = level.transform.peak();
      if (peak.votes < fewest_votes) break;
      found_.push_back(
          {{(peak.x + 0.5) * cell - 0.5, (peak.y + 0.5) * cell - 0.5, peak.r * cell}, peak.response});
      for (Vote& vote : level.votes) {
        const int dx = vote.x - peak.x;
        const int dy = vote.y - peak.y;
        const double distance = std::sqrt(static_cast<double>(dx * dx + dy * dy));
        if (vote.explained || std::abs(distance - peak.r) > outline_cells) continue;
        vote.explained = true;
        level.transform.vote_arcs<-1>(vote.x, vote.y, vote.direction);
      }
    }
  }
  std::sort(found_.begin(), found_.end(),
            [](const Found& a, const Found& b) { return a.response > b.response; });
  return found_;
}

void CircleSearch::largest_response(ImageSize size, std::span<float> response) const {
  std::fill(response.begin(), response.end(), 0.0F);
  for (const Level& level : levels_) {
    const ImageSize cells = level.transform.size();
    std::vector<float> of_cells(static_cast<std::size_t>(cells.pixels()));
    saccade::largest_response(level.transform, of_cells);
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) {
        float& largest = response[static_cast<std::size_t>(y * size.width + x)];
        const int cell = y / level.cell_px * cells.width + x / level.cell_px;
        largest = std::max(largest, of_cells[static_cast<std::size_t>(cell)]);
      }
    }
  }
}

}  // namespace saccade
