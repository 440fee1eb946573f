#include "evaluation/report/gnuplot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/gnuplot_process.h"
#include "evaluation/report/svg.h"

namespace saccade {
namespace {

using Point = GnuplotFigure::Point;

bool is_gap(const Point& point) { return !std::isfinite(point.x + point.y); }

/// At most max_figure_points of the points; each gap is one point that is not finite.
std::vector<Point> thinned(const std::vector<Point>& points) {
  const std::size_t stride = (points.size() + max_figure_points - 1) / max_figure_points;
  std::vector<Point> some;
  bool gap = true;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_gap(points[i])) {
      if (!gap) some.push_back(points[i]);
      gap = true;
    } else if (gap || i % stride == 0) {
      some.push_back(points[i]);
      gap = false;
    }
  }
  return some;
}

std::string data_block(const std::vector<Point>& points) {
  std::string text;
  for (const Point& point : thinned(points))
    text += is_gap(point) ? "\n" : fmt::format("{:.6g} {:.6g}\n", point.x, point.y);
  return text;
}

using Json = nlohmann::ordered_json;

/// The number as the drawing has it, so that a page is not larger than it needs to be.
Json drawn_number(double value) {
  return std::isfinite(value) ? Json::parse(fmt::format("{:.6g}", value)) : Json(nullptr);
}

/// [low, high] of a command such as "set xrange [0:1]"; null where it gives no two numbers.
Json range_in(const std::string& commands, const std::string& axis) {
  const std::size_t at = commands.rfind("set " + axis + " [");
  if (at == std::string::npos) return nullptr;
  const std::size_t open = commands.find('[', at);
  const std::string text = commands.substr(open + 1, commands.find(']', open) - open - 1);
  const std::size_t colon = text.find(':');
  Json range = Json::array();
  for (const std::string& bound : {text.substr(0, colon), text.substr(colon + 1)}) {
    char* end = nullptr;
    const double value = std::strtod(bound.c_str(), &end);
    if (bound.empty() || *end != '\0') return nullptr;
    range.push_back(value);
  }
  return range;
}

/// The colour of a style as CSS has it: gnuplot's #aarrggbb has its transparency first.
std::string page_colour(const std::string& style) {
  constexpr std::string_view mark = "lc rgb '";
  const std::size_t at = style.find(mark);
  if (at == std::string::npos) return "#555555";
  const std::size_t begin = at + mark.size();
  const std::string colour = style.substr(begin, style.find('\'', begin) - begin);
  if (colour.size() != 9) return colour;
  const int opacity = 255 - static_cast<int>(std::strtol(colour.substr(1, 2).c_str(), nullptr, 16));
  return fmt::format("#{}{:02x}", colour.substr(3), opacity);
}

/// The number after the first `word` of a style.
double number_after(const std::string& style, std::string_view word, double otherwise) {
  const std::size_t at = style.find(word);
  return at == std::string::npos ? otherwise : std::strtod(style.c_str() + at + word.size(), nullptr);
}

Json series_json(const GnuplotFigure::Series& series) {
  Json x = Json::array();
  Json y = Json::array();
  for (const Point& point : thinned(series.points)) {
    if (!std::isfinite(point.x)) continue;
    x.push_back(drawn_number(point.x));
    y.push_back(drawn_number(point.y));
  }
  return {{"title", series.title},
          {"colour", page_colour(series.style)},
          {"width", number_after(series.style, "lw ", 1.0)},
          {"dashed", series.style.find(" dt ") != std::string::npos},
          {"lines", series.style.starts_with("lines")},
          {"points", series.style.find("points") != std::string::npos},
          {"in_key", series.in_key},
          {"x", std::move(x)},
          {"y", std::move(y)}};
}

bool has_logarithmic_x(const std::string& commands) {
  return ("\n" + commands).find("\nset logscale x") != std::string::npos;
}

Json words_json(const std::vector<GnuplotFigure::XWord>& words) {
  Json json = Json::array();
  for (const auto& [x, word] : words) json.push_back({x, word});
  return json;
}

/// A series and the columns of its values in the table: the same series over the same x in several panels makes
/// one row per x.
struct Rows {
  const std::string* title;
  std::vector<const std::vector<Point>*> panels;  // null where the series is not in that panel
};

const std::vector<Point>* first_of(const Rows& rows) {
  return *std::find_if(rows.panels.begin(), rows.panels.end(), [](const auto* p) { return p != nullptr; });
}

bool same_x(const std::vector<Point>& a, const std::vector<Point>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Point& p, const Point& q) {
    return p.x == q.x || (std::isnan(p.x) && std::isnan(q.x));
  });
}

std::vector<Rows> table_of(const std::vector<GnuplotFigure::Panel>& panels) {
  std::vector<Rows> table;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    for (const GnuplotFigure::Series& s : panels[i].series) {
      if (s.points.empty()) continue;
      auto rows = std::find_if(table.begin(), table.end(), [&](const Rows& r) {
        return *r.title == s.title && r.panels[i] == nullptr && same_x(*first_of(r), s.points);
      });
      if (rows == table.end()) {
        rows = table.insert(rows, {&s.title, std::vector<const std::vector<Point>*>(panels.size())});
      }
      rows->panels[i] = &s.points;
    }
  }
  return table;
}

std::string csv_number(double value) { return std::isfinite(value) ? fmt::format("{:.9g}", value) : ""; }

/// Stands where gnuplot would have drawn. With JavaScript the page draws the lines over it (plots.js).
std::string undrawn_svg(int width, int height) {
  return fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100%\" viewBox=\"0 0 {0} {1}\" role=\"img\">"
      "<rect width=\"{0}\" height=\"{1}\" fill=\"#f4f4f4\"/><text x=\"50%\" y=\"50%\" text-anchor=\"middle\" "
      "font-family=\"sans-serif\" font-size=\"16\">Not drawn: gnuplot is not installed. The numbers are in "
      "the CSV "
      "file.</text></svg>\n",
      width, height);
}

}  // namespace

std::string csv_field(std::string_view text) {
  if (text.find_first_of(",\"\n\r") == std::string_view::npos) return std::string(text);
  std::string field = "\"";
  for (const char c : text) field += c == '"' ? "\"\"" : std::string(1, c);
  return field + "\"";
}

std::string file_part(std::string_view name) {
  std::string part(name);
  const auto stays = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  std::replace_if(part.begin(), part.end(), std::not_fn(stays), '_');
  return part;
}

std::string gnuplot_quoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) >= ' ') quoted += c == '\'' ? "''" : std::string(1, c);
  }
  return quoted + "'";
}

GnuplotFigure::GnuplotFigure(std::string_view name, int width, int height)
    : name_(name), width_(width), height_(height) {}

Figure GnuplotFigure::draw(std::string_view layout) const {
  const std::string terminal = fmt::format(
      "set terminal svg size {},{} dynamic noenhanced font 'sans-serif,{}' name {} "
      "background rgb 'white'\n",
      width_, height_, font, gnuplot_quoted(name_));
  const bool can_draw = gnuplot_installed();
  const std::string drawing =
      can_draw ? run_gnuplot(terminal + script(layout)) : undrawn_svg(width_, height_);
  std::vector<std::string> key;
  if (!panels_.empty()) {
    for (const Series& s : panels_.front().series) {
      if (s.in_key && !s.points.empty()) key.push_back(s.title);
    }
  }
  if (can_draw && !drawing.ends_with("</svg>\n\n"))
    throw RunError("figures: gnuplot left a part of " + name_);
  return {.name = name_,
          .svg = can_draw ? page_svg(drawing, name_) : drawing,
          .csv = csv(),
          .data = data(),
          .script = script(layout),
          .key = std::move(key),
          .panels = panels_.size(),
          .height_share = static_cast<double>(height_) / width_};
}

std::string GnuplotFigure::data() const {
  Json panels = Json::array();
  for (const Panel& panel : panels_) {
    Json series = Json::array();
    for (const Series& s : panel.series) series.push_back(series_json(s));
    panels.push_back({{"title", panel.title},
                      {"y_label", panel.y_label},
                      {"x_range", range_in(panel.commands, "xrange")},
                      {"y_range", range_in(panel.commands, "yrange")},
                      {"log_x", has_logarithmic_x(panel.commands)},
                      {"x_words", words_json(panel.x_words)},
                      {"bands", panel.bands},
                      {"series", std::move(series)}});
  }
  const Json json = {{"name", name_},
                     {"x_label", panels_.empty() ? "" : panels_.front().x_label},
                     {"over_x", over_x_},
                     {"panels", std::move(panels)}};
  return json.dump();
}

std::string GnuplotFigure::csv() const {
  if (panels_.empty()) return {};
  std::string text = "series," + csv_field(panels_.front().x_label);
  for (const Panel& panel : panels_) {
    text += "," + csv_field(panel.title.empty() ? panel.y_label : panel.title + ", " + panel.y_label);
    if (!panel.z_label.empty()) text += "," + csv_field(panel.z_label);
  }
  text += "\n";
  for (const Rows& rows : table_of(panels_)) {
    const std::vector<Point>& any = *first_of(rows);
    for (std::size_t i = 0; i < any.size(); ++i) {
      std::string values;
      bool empty = true;
      for (std::size_t p = 0; p < panels_.size(); ++p) {
        const Point point = rows.panels[p] != nullptr ? (*rows.panels[p])[i]
                                                      : Point{std::nan(""), std::nan(""), std::nan("")};
        values += "," + csv_number(point.y);
        if (!panels_[p].z_label.empty()) values += "," + csv_number(point.z);
        empty &= is_gap(point);
      }
      if (!empty) text += csv_field(*rows.title) + "," + csv_number(any[i].x) + values + "\n";
    }
  }
  return text;
}

std::string GnuplotFigure::script(std::string_view layout) const {
  std::string data =
      "set border 3 lc rgb '#777777'\nset tics nomirror out scale 0.5 tc rgb '#333333'\n"
      "set grid lc rgb '#e4e4e4' lt 1\nset key top right samplen 2\n";
  std::string plots;
  int blocks = 0;
  for (const Panel& panel : panels_) {
    std::string plot;
    for (const Series& s : panel.series) {
      const std::string block = data_block(s.points);
      if (block.empty()) continue;
      const std::string id = "$d" + std::to_string(blocks++);
      data += id + " << EOD\n" + block + "EOD\n";
      plot += fmt::format("{}{} using 1:2 {} with {}", plot.empty() ? "" : ", ", id,
                          s.in_key ? "title " + gnuplot_quoted(s.title) : "notitle", s.style);
    }
    // A panel without data still shows its axes: a line that lies outside them.
    if (plot.empty()) plot = "[0:1][0:1] -1 notitle";
    plots += fmt::format("set xlabel {}\nset ylabel {}\n", gnuplot_quoted(panel.x_label),
                         gnuplot_quoted(panel.y_label));
    if (!panel.title.empty())
      plots +=
          fmt::format("set title {} font ',{}'\n", gnuplot_quoted(panel.title), GnuplotFigure::small_font);
    if (!panel.x_words.empty()) {
      std::string tics;
      for (const auto& [x, word] : panel.x_words)
        tics += fmt::format("{}{} {}", tics.empty() ? "" : ", ", gnuplot_quoted(word), x);
      plots += "set xtics (" + tics + ")\n";
    }
    plots += panel.commands + "plot " + plot + "\n";
  }
  return data + std::string(layout) + plots;
}

}  // namespace saccade
