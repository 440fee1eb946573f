#include "evaluation/report/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>

namespace saccade {
namespace {

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

/// Passes every tag of the text, "<...>", to `change`, which changes it in place.
template <class Change>
std::string with_changed_tags(std::string_view text, Change change) {
  std::string result;
  while (!text.empty()) {
    const std::size_t start = std::min(text.find('<'), text.size());
    result += text.substr(0, start);
    text.remove_prefix(start);
    const std::size_t end = text.find('>');
    std::string tag(text.substr(0, end == std::string_view::npos ? text.size() : end + 1));
    text.remove_prefix(tag.size());
    change(tag);
    result += tag;
  }
  return result;
}

/// Without the first <desc> element, which is gnuplot's own.
std::string without_description(std::string text) {
  const std::size_t start = text.find("<desc>");
  const std::size_t end = text.find("</desc>", start == std::string::npos ? 0 : start);
  if (start != std::string::npos && end != std::string::npos) text.erase(start, end + 7 - start);
  return text;
}

/// A round point as gnuplot writes it, one a line; views into that line.
struct Dot {
  std::string_view place;  ///< x,y
  std::string_view look;   ///< scale and colour, which many share
};

std::optional<Dot> dot_in(std::string_view line) {
  constexpr std::string_view start = "\t<use xlink:href='#gpPt6' transform='translate(";
  const std::size_t middle = line.find(") scale(");
  if (!line.starts_with(start) || middle == std::string_view::npos || !line.ends_with("'/>")) {
    return std::nullopt;
  }
  return Dot{line.substr(start.size(), middle - start.size()), line.substr(middle)};
}

/// The start of a path that draws such points as stretches of no length with round ends.
std::string path_start(std::string_view look) {
  constexpr std::string_view scale = ") scale(";
  constexpr std::string_view colour = "color='";
  const std::size_t at = look.find(colour) + colour.size();
  double radius = 0.0;
  std::from_chars(look.data() + scale.size(), look.data() + look.size(), radius);
  return fmt::format("\t<path stroke='{}' stroke-width='{:.4g}' stroke-linecap='round' d='",
                     look.substr(at, look.find('\'', at) - at), 2.0 * radius);
}

/// Round points one after another that look alike, as one path: a tenth of the text that gnuplot writes.
std::string with_merged_dots(std::string_view svg) {
  std::string merged;
  std::string_view look;  // of the path that is open; empty when none is
  while (!svg.empty()) {
    const std::string_view line = svg.substr(0, svg.find('\n'));
    const auto dot = dot_in(line);
    if (!look.empty() && (!dot || dot->look != look)) merged += "'/>\n";
    if (dot) {
      if (dot->look != look) merged += path_start(dot->look);
      merged.append("M").append(dot->place).append("h0");
    } else {
      merged.append(line).append("\n");
    }
    look = dot ? dot->look : std::string_view();
    svg.remove_prefix(std::min(line.size() + 1, svg.size()));
  }
  return merged;
}

}  // namespace

std::string page_svg(std::string_view gnuplot_output, std::string_view name) {
  std::string text = without_description(with_merged_dots(gnuplot_output));
  text.erase(0, std::min(text.find("<svg"), text.size()));
  while (text.ends_with('\n')) text.pop_back();
  const std::string prefix(name);
  return with_changed_tags(text, [&](std::string& tag) {
    replace_all(tag, "id='", "id='" + prefix + "_");
    replace_all(tag, "id=\"", "id=\"" + prefix + "_");
    replace_all(tag, "'#gp", "'#" + prefix + "_gp");
  });
}

std::string without_namespaces(std::string_view svg) {
  return with_changed_tags(svg, [](std::string& tag) {
    for (std::size_t at = 0; (at = tag.find("xmlns")) != std::string::npos;) {
      const std::size_t open = tag.find('"', at);
      const std::size_t close = open == std::string::npos ? open : tag.find('"', open + 1);
      if (close == std::string::npos) return;
      tag.erase(at, close + 1 - at);
    }
  });
}

}  // namespace saccade
