#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "recording/run_files.h"

namespace saccade {

/// True circles of a recording that a person places at single instants: rows of truth.csv, sorted by time, one for each
/// instant. A row with `visible` 0 says that the ball is hidden or outside the image at its instant.
class CircleLabels {
 public:
  CircleLabels() = default;
  /// Throws InputError for a missing or broken table, and for two rows of one instant.
  [[nodiscard]] static CircleLabels read(const std::filesystem::path& table);
  /// Writes the table that read() reads. Throws RunError.
  void write(const std::filesystem::path& table) const;

  [[nodiscard]] std::span<const TruthRow> rows() const { return rows_; }
  /// The row of that instant; null where there is none.
  [[nodiscard]] const TruthRow* at(std::int64_t t_us) const;
  /// The last row before t_us and the first one after it; null where there is none.
  [[nodiscard]] const TruthRow* before(std::int64_t t_us) const;
  [[nodiscard]] const TruthRow* after(std::int64_t t_us) const;

  /// Sets the circle of an instant, rounded to 0.01 px, with the ball visible.
  void place(std::int64_t t_us, const Circle& circle);
  /// Marks the ball as hidden at an instant.
  void hide(std::int64_t t_us);
  /// Removes the row of an instant, if there is one.
  void remove(std::int64_t t_us);
  /// Sets the row of an instant as it is.
  void restore(const TruthRow& row) { row_of(row.t_us) = row; }

  /// Where the circle may be at t_us: on the line between the visible rows before and after it. Beyond the last row (or
  /// before the first one) the motion of the two nearest rows goes on for as long as they are apart, then the circle stays.
  /// None where there is no visible row, and where the nearest row on one side says that the ball is hidden.
  [[nodiscard]] std::optional<Circle> hint(std::int64_t t_us) const;

 private:
  TruthRow& row_of(std::int64_t t_us);

  std::vector<TruthRow> rows_;
};

}  // namespace saccade
