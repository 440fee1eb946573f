#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/event.h"
#include "recording/event_columns.h"

namespace saccade {

/// The columns of a text file, in its order.
struct TextColumns {
  std::string letters;              ///< t, x, y, p, c for the camera, and _ for one that is not read
  std::optional<TimeUnit> unit;     ///< of the time, where its name says it
  std::vector<std::string> unread;  ///< names of those that are not read
};

/// The names in a line, between commas or semicolons, else tabs, else blanks; a unit in brackets belongs to the name before.
[[nodiscard]] std::vector<std::string_view> names_in(std::string_view line);
/// Whether a line holds words alone, at least four.
[[nodiscard]] bool is_line_of_names(std::string_view line);
/// The columns that a line names, by event_column(), else by the first letter where that is unambiguous; none where it does
/// not name each of t, x, y and p once.
[[nodiscard]] std::optional<TextColumns> named_columns(std::string_view line);

/// The image size of a line of two whole numbers, as E2VID's files begin.
[[nodiscard]] std::optional<ImageSize> size_in_line(std::string_view line);
/// The image size of a comment such as `%geometry:240,180`, as Prophesee's programs write it.
[[nodiscard]] std::optional<ImageSize> geometry_in_comment(std::string_view line);

}  // namespace saccade
