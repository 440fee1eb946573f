#include "evaluation/report/paper_figures.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "evaluation/report/gnuplot_process.h"
#include "recording/output_file.h"

namespace saccade::inline v0_1 {
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
  // The drawing's key stands beside the panel, for which one column has no room.
  const std::string key = one_column ? "set key outside bottom center horizontal samplen 1.5 width -1\n" : "";
  std::string script = figure.script;
  if (const std::size_t plot = script.rfind("\nplot "); one_column && plot != std::string::npos)
    script.insert(plot + 1, key);
  const std::string pdf = run_gnuplot(
      fmt::format("set terminal pdfcairo size {:.4f}cm,{:.4f}cm noenhanced font '{},{}' linewidth {}\n{}",
                  0.1 * width_mm, 0.1 * height_mm, pdf_font, font_pt, line_share, script));
  constexpr double scale = 4.0;  // pixels per point: gnuplot's SVG has whole pixels
  const std::string svg = run_gnuplot(fmt::format(
      "set terminal svg size {:.0f},{:.0f} noenhanced font '{},{}' linewidth {} background rgb 'white'\n{}",
      scale * width_mm * points_per_mm, scale * height_mm * points_per_mm, svg_font, scale * font_pt,
      scale * line_share, script));
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

}  // namespace saccade::inline v0_1
