#include "evaluation/report/paper_figures.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "evaluation/report/gnuplot_process.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

constexpr double column_mm = 88.0;
constexpr double page_mm = 181.0;
constexpr double smallest_column_share = 0.75;  ///< height over width of a figure in one column
constexpr double points_per_mm = 72.0 / 25.4;
/// Times and what stands for it where it is not installed.
constexpr const char* pdf_font = "Liberation Serif";
constexpr const char* svg_font = "Times New Roman";
constexpr double column_font_pt = 8.0;
constexpr double page_font_pt = 7.0;  ///< the labels of panels side by side have fixed margins
constexpr double line_share = 0.6;    ///< width of a line over that of the page's drawing
constexpr double point_share = 0.55;  ///< size of a point over that of the page's drawing

/// The script with another size of its titles.
std::string with_title_font(std::string script, double font) {
  const std::string page_font = fmt::format("font ',{}'", GnuplotFigure::small_font);
  const std::string wanted =
      fmt::format("font ',{:.4g}'", font * GnuplotFigure::small_font / GnuplotFigure::font);
  for (std::size_t at = 0; (at = script.find(page_font, at)) != std::string::npos; at += wanted.size())
    script.replace(at, page_font.size(), wanted);
  return script;
}

/// Commands for a key below the panel, whose labels it leaves in peace: gnuplot's own layout draws it over them. The
/// page's drawing has it beside the panel, for which one column has no room.
std::string key_below(const Figure& figure, double width_pt, double height_pt) {
  if (figure.key.empty() || figure.script.find("unset key") != std::string::npos) return {};
  constexpr double letter = 0.5;                      // width of a letter over the size of the font
  constexpr double sample_pt = 34.0;                  // of a line, and the space between entries
  constexpr double row_pt = 1.5 * column_font_pt;     // as the SVG terminal has it
  constexpr double labels_pt = 5.0 * column_font_pt;  // of the axis
  std::size_t longest = 0;
  for (const std::string& title : figure.key) longest = std::max(longest, title.size());
  const double entry_pt = sample_pt + letter * column_font_pt * static_cast<double>(longest);
  const auto columns =
      std::clamp<std::size_t>(static_cast<std::size_t>(0.95 * width_pt / entry_pt), 1, figure.key.size());
  const std::size_t rows = (figure.key.size() + columns - 1) / columns;
  const double key_pt = row_pt * static_cast<double>(rows) + 0.5 * column_font_pt;
  return fmt::format(
      "set bmargin at screen {:.4g}\nset key at screen 0.5, screen {:.4g} center bottom horizontal maxcols "
      "{} samplen 1.5\n",
      (key_pt + labels_pt) / height_pt, 0.25 * column_font_pt / height_pt, columns);
}

}  // namespace

void write_paper_figure(const Figure& figure, const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw RunError(folder.string() + ": cannot make the folder: " + error.message());
  const bool one_column = figure.panels == 1;
  const double font_pt = one_column ? column_font_pt : page_font_pt;
  const double width_mm = one_column ? column_mm : page_mm;
  const double share =
      one_column ? std::max(figure.height_share, smallest_column_share) : figure.height_share;
  const double height_mm = width_mm * share;
  std::string script = figure.script;
  if (const std::size_t plot = script.rfind("\nplot "); one_column && plot != std::string::npos)
    script.insert(plot + 1, key_below(figure, width_mm * points_per_mm, height_mm * points_per_mm));
  const std::string pdf = run_gnuplot(fmt::format(
      "set terminal pdfcairo size {:.4f}cm,{:.4f}cm noenhanced font '{},{}' linewidth {} pointscale {}\n{}",
      0.1 * width_mm, 0.1 * height_mm, pdf_font, font_pt, line_share, point_share,
      with_title_font(script, font_pt)));
  constexpr double scale = 4.0;  // pixels per point: gnuplot's SVG has whole pixels
  const std::string svg = run_gnuplot(fmt::format(
      "set terminal svg size {:.0f},{:.0f} noenhanced font '{},{}' linewidth {} background rgb 'white'\n{}",
      scale * width_mm * points_per_mm, scale * height_mm * points_per_mm, svg_font, scale * font_pt,
      scale * line_share, with_title_font(script, scale * font_pt)));
  const std::string size = fmt::format("<svg \n width=\"{:.2f}mm\" height=\"{:.2f}mm\"", width_mm, height_mm);
  std::string sized = svg;
  const std::size_t at = sized.find("<svg");
  const std::size_t view_box = sized.find("viewBox", at);
  if (at != std::string::npos && view_box != std::string::npos)
    sized.replace(at, view_box - at, size + "\n ");
  write_file(folder / (figure.name + ".pdf"), pdf);
  write_file(folder / (figure.name + ".svg"), sized);
  write_file(folder / (figure.name + ".csv"), figure.csv);
}

}  // namespace saccade
