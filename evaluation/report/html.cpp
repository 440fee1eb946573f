#include "evaluation/report/html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/config.h"
#include "core/error.h"
#include "evaluation/image_codecs/image_codecs.h"
#include "evaluation/report/paper_figures.h"
#include "evaluation/report/svg.h"
#include "evaluation/report/templates.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

void write_text(const fs::path& path, std::string_view text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

std::string in_script(std::string_view json) {
  std::string text;
  text.reserve(json.size());
  for (const char c : json) {
    if (c == '<')
      text += "\\u003c";
    else
      text += c;
  }
  return text;
}

std::string escaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      case '"':
        html += "&quot;";
        break;
      default:
        html += c;
    }
  }
  return html;
}

std::string short_number(double value) {
  return std::abs(value) >= 100.0 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

std::string cell(const std::optional<double>& value, double factor) {
  if (!value) return "<td class=\"none\">–</td>";
  return fmt::format("<td data-value=\"{}\">{}</td>", text_of(*value), short_number(*value * factor));
}

std::string count_cell(std::int64_t value) { return fmt::format("<td data-value=\"{0}\">{0}</td>", value); }

std::string cell(const MeanSd& value, std::size_t runs, double factor) {
  if (!value.mean) return cell(value.mean);
  std::string html = fmt::format("<td data-value=\"{}\"", text_of(*value.mean));
  if (value.sd) html += fmt::format(" data-sd=\"{}\"", text_of(*value.sd));
  html += ">" + short_number(*value.mean * factor);
  if (value.sd) {
    const double sd = *value.sd * factor;
    html += fmt::format(" <small>± {}</small>", sd >= 10.0 ? short_number(sd) : fmt::format("{:.2g}", sd));
  }
  if (value.count < runs) html += fmt::format(" <small>({} of {})</small>", value.count, runs);
  return html + "</td>";
}

std::string colour_mark(Colour colour, std::string_view name) {
  return fmt::format("<span class=\"mark\"><span class=\"dot\" style=\"background:{}\"></span>{}</span>",
                     hex(colour), escaped(name));
}

std::string image_html(const cv::Mat& image, std::string_view format, std::string_view alt) {
  return fmt::format("<img alt=\"{}\" width=\"{}\" height=\"{}\" src=\"data:image/{};base64,{}\">",
                     escaped(alt), image.cols, image.rows, format,
                     base64(encoded_image(format, image, PngSize::small)));
}

std::string figure_html(std::string_view title, std::string_view reading, std::string_view content) {
  return fmt::format("<figure><h3>{}</h3>\n{}\n<figcaption>{}</figcaption></figure>\n", escaped(title),
                     content, reading);
}

std::string figure_html(std::string_view title, std::string_view reading, const Figure& figure,
                        const FigureFolder& folder) {
  write_numbers(folder.page, figure.name, figure.csv);
  if (!folder.paper.empty()) write_paper_figure(figure, folder.paper);
  return rendered("figure.mustache", {{"name", figure.name},
                                      {"title", std::string(title)},
                                      {"reading", std::string(reading)},
                                      {"svg", without_namespaces(figure.svg)},
                                      {"data", in_script(figure.data)}});
}

void write_numbers(const fs::path& folder, std::string_view name, std::string_view csv) {
  std::error_code error;
  fs::create_directories(folder / "figures", error);
  if (error) throw RunError((folder / "figures").string() + ": cannot make the folder: " + error.message());
  write_text(folder / "figures" / (std::string(name) + ".csv"), csv);
}

void write_page(const fs::path& folder, std::string_view title, std::string_view body) {
  write_page_file(folder / "report.html", title, body);
}

void write_page_file(const fs::path& file, std::string_view title, std::string_view body) {
  std::string dygraphs(report_asset("dygraph.min.js"));
  dygraphs.erase(std::min(dygraphs.find("//# sourceMappingURL"), dygraphs.size()));
  write_text(file, rendered("page.mustache", {{"title", std::string(title)},
                                              {"style", std::string(report_asset("dygraph.min.css")) +
                                                            std::string(report_asset("report.css"))},
                                              {"body", std::string(body)},
                                              {"dygraphs", dygraphs},
                                              {"plots", std::string(report_asset("plots.js"))},
                                              {"tables", std::string(report_asset("tables.js"))}}));
}

}  // namespace saccade
