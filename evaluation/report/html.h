#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "evaluation/report/gnuplot.h"
#include "evaluation/report/palette.h"
#include "evaluation/scoring/statistics.h"

namespace saccade {

/// The parts of report pages. A page is one file that needs no network; it contains the script of its plots.

/// Where figures are written.
struct FigureFolder {
  std::filesystem::path page;   ///< of report.html: the numbers go to page/figures/NAME.csv
  std::filesystem::path paper;  ///< gets NAME.svg, NAME.pdf and NAME.csv at the size of a paper; empty: none

  FigureFolder(std::filesystem::path page_folder, std::filesystem::path paper_folder = {})
      : page(std::move(page_folder)), paper(std::move(paper_folder)) {}
};

[[nodiscard]] std::string escaped(std::string_view text);

[[nodiscard]] std::string base64(const std::vector<unsigned char>& bytes);

/// JSON that a script element can hold: no character ends the element.
[[nodiscard]] std::string in_script(std::string_view json);

/// A number for people: three significant figures, none after the point from 100 on.
[[nodiscard]] std::string short_number(double value);

/// A table's cell: short for people, times `factor`, and in full (data-value, without the factor) for
/// machines; a dash where there is no value.
[[nodiscard]] std::string cell(const std::optional<double>& value, double factor = 1.0);
[[nodiscard]] std::string count_cell(std::int64_t value);
/// Mean and standard deviation (data-value, data-sd) over `runs` runs; with the number of those that have a
/// value where not all have one.
[[nodiscard]] std::string cell(const MeanSd& value, std::size_t runs, double factor = 1.0);

/// A name with a dot of its colour before it.
[[nodiscard]] std::string colour_mark(Colour colour, std::string_view name);

/// `format` is png or jpeg.
[[nodiscard]] std::string image_html(const cv::Mat& image, std::string_view format, std::string_view alt);

/// `title` is plain text, `reading` (how to read it) and `content` are HTML.
[[nodiscard]] std::string figure_html(std::string_view title, std::string_view reading,
                                      std::string_view content);

/// A drawing as a figure of a page: a plot to zoom, or the drawing itself where it is no function of x, with buttons for
/// SVG and CSV. Writes the files that FigureFolder names. Throws RunError.
[[nodiscard]] std::string figure_html(std::string_view title, std::string_view reading, const Figure& figure,
                                      const FigureFolder& folder);

/// Writes `folder`/figures/NAME.csv. Throws RunError.
void write_numbers(const std::filesystem::path& folder, std::string_view name, std::string_view csv);

/// Writes `folder`/report.html. Throws RunError.
void write_page(const std::filesystem::path& folder, std::string_view title, std::string_view body);
/// The same under another name.
void write_page_file(const std::filesystem::path& file, std::string_view title, std::string_view body);

}  // namespace saccade
