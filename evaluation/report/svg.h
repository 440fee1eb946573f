#pragma once

#include <string>
#include <string_view>

namespace saccade {

/// Changes to the text of an SVG drawing. They change tags alone: a title or label that looks like an attribute stays as
/// it is.

/// gnuplot's output as a drawing for a page: without the XML declaration before it and without gnuplot's <desc> (its
/// version), where there is one; with `name`_ before every id, so that several drawings fit into one page; round points
/// of one colour as one path, which makes the text shorter.
[[nodiscard]] std::string page_svg(std::string_view gnuplot_output, std::string_view name);

/// Without namespace declarations, which a drawing inside an HTML page does not need.
[[nodiscard]] std::string without_namespaces(std::string_view svg);

}  // namespace saccade
