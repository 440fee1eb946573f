#include "evaluation/scoring/scoring.h"

#include <algorithm>
#include <cstdio>

#include "core/error.h"
#include "evaluation/scoring/detector_scorer.h"

namespace saccade {
namespace {

Observation observation_of(const DetectionRow& row) { return {row.circle, row.score, row.covariance_px2}; }

/// Passes truth and the rows of one detector to a scorer in the order of time. `on_truth` gets what the scorer returns
/// for each row of truth.
template <class OnTruth>
void score_rows(DetectorScorer& scorer, std::span<const TruthRow> truth,
                std::span<const DetectionRow> detections, std::string_view detector, OnTruth on_truth) {
  auto row = detections.begin();
  const auto skip_others = [&] {
    while (row != detections.end() && row->detector != detector) ++row;
    return row != detections.end();
  };
  for (const TruthRow& t : truth) {
    for (; skip_others() && row->t_us < t.t_us; ++row) scorer.add(row->t_us, observation_of(*row));
    std::optional<Observation> observation;
    if (skip_others() && row->t_us == t.t_us) {
      observation = observation_of(*row);
      ++row;
    }
    on_truth(scorer.add(t, observation));
  }
  for (; skip_others(); ++row) scorer.add(row->t_us, observation_of(*row));
}

std::string span_text(std::int64_t first_us, std::int64_t last_us) {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "from %.3f to %.3f s", static_cast<double>(first_us) * 1e-6,
                static_cast<double>(last_us) * 1e-6);
  return text.data();
}

/// "1000, 2000, 3000, ..." of the first instants.
template <class Row>
std::string instants_text(const std::vector<const Row*>& rows) {
  constexpr std::size_t most = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(most, rows.size()); ++i)
    text += (i == 0 ? "" : ", ") + std::to_string(rows[i]->t_us);
  return text + (rows.size() > most ? ", ..." : "");
}

std::optional<double> rate_per_s(std::int64_t found, std::int64_t chances) {
  if (chances == 0) return std::nullopt;
  return 1e3 * static_cast<double>(found) / static_cast<double>(chances);
}

}  // namespace

Chances chances_of(std::span<const TruthRow> truth) {
  constexpr std::int64_t simulated_period_us = 1'000;
  bool simulated = truth.size() > 1;
  for (std::size_t i = 1; i < truth.size(); ++i)
    simulated &= truth[i].t_us - truth[i - 1].t_us == simulated_period_us;
  return simulated ? Chances::simulated : Chances::annotated;
}

DetectorScore score_detector(std::span<const TruthRow> truth, std::span<const DetectionRow> detections,
                             std::string_view detector, double threshold, Chances chances) {
  // Everything is in memory already: exact whatever the length.
  DetectorScorer scorer(std::string(detector), threshold, chances, truth.size() + detections.size() + 1);
  score_rows(scorer, truth, detections, detector, [](std::optional<bool>) {});
  return scorer.score();
}

SharedInstants check_instants(std::span<const TruthRow> truth, std::span<const DetectionRow> detections,
                              std::string_view detector, const std::string& place) {
  std::vector<const DetectionRow*> rows;
  for (const DetectionRow& row : detections) {
    if (row.detector == detector) rows.push_back(&row);
  }
  SharedInstants count;
  if (rows.empty() || truth.empty()) return count;
  const std::int64_t first_us = truth.front().t_us, last_us = truth.back().t_us;
  if (rows.back()->t_us < first_us || rows.front()->t_us > last_us) {
    throw InputError(place,
                     "detections " + span_text(rows.front()->t_us, rows.back()->t_us) + ", truth " +
                         span_text(first_us, last_us),
                     "detections in the clock of the truth");
  }
  std::erase_if(rows, [&](const DetectionRow* row) { return row->t_us < first_us || row->t_us > last_us; });
  count.detections = static_cast<std::int64_t>(rows.size());
  const auto is_shared = [&](const DetectionRow* row) {
    return std::ranges::binary_search(truth, row->t_us, {}, &TruthRow::t_us);
  };
  count.shared = std::ranges::count_if(rows, is_shared);
  if (count.detections > 0 && count.shared == 0) {
    std::vector<const TruthRow*> instants;
    for (const TruthRow& row : truth) instants.push_back(&row);
    throw InputError(
        place,
        std::to_string(rows.size()) + " detections of " + std::string(detector) +
            " in the time of the truth, none at an instant of it: the truth has t_us = " +
            instants_text(instants) + ", the detections " + instants_text(rows),
        "detections at the instants of the truth, as `saccade detect RECORDING --truth TRUTH.csv` "
        "makes them, and saccade.detect() of Python with at_us");
  }
  return count;
}

std::vector<std::optional<bool>> found_at_chances(std::span<const TruthRow> truth,
                                                  std::span<const DetectionRow> detections,
                                                  std::string_view detector, double threshold) {
  std::vector<std::optional<bool>> found;
  found.reserve(truth.size());
  DetectorScorer scorer(std::string(detector), threshold, Chances::simulated);
  score_rows(scorer, truth, detections, detector, [&](std::optional<bool> f) { found.push_back(f); });
  return found;
}

std::optional<double> found_rate_hz(std::span<const TruthRow> truth,
                                    std::span<const std::optional<bool>> found, std::int64_t from_us) {
  SACCADE_CHECK(truth.size() == found.size());
  std::int64_t chances = 0;
  std::int64_t right = 0;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    if (truth[i].t_us < from_us || !found[i]) continue;
    ++chances;
    right += *found[i] ? 1 : 0;
  }
  return rate_per_s(right, chances);
}

void FollowingRate::add(std::optional<bool> found, std::optional<std::int64_t> held_since_us) {
  if (held_since_us != held_since_us_) {
    held_since_us_ = held_since_us;
    chances_ = 0;
    found_ = 0;
  }
  if (!held_since_us_ || !found) return;
  ++chances_;
  found_ += *found ? 1 : 0;
}

std::optional<double> FollowingRate::rate_hz() const { return rate_per_s(found_, chances_); }

}  // namespace saccade
