#include "evaluation/report/html.h"

#include <fmt/format.h>

#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <vector>

#include "core/config.h"
#include "core/error.h"
#include "evaluation/report/svg.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view style = R"(
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, "DejaVu Sans", sans-serif; color: #1c1c1c; background: #fff; margin: 0 auto;
       max-width: 74rem; padding: 1.5rem 1rem 4rem; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 0 .2rem; overflow-wrap: anywhere; }
h2 { font-size: 1.25rem; margin: 2.2rem 0 .5rem; overflow-wrap: anywhere; }
h3 { font-size: 1.02rem; margin: 0 0 .5rem; }
.facts { color: #555; margin: .4rem 0 1rem; }
.wide { overflow-x: auto; }
.wide + .wide { margin-top: 1rem; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
th, td { padding: .3rem .65rem; border-bottom: 1px solid #e2e2e2; text-align: right; }
td { white-space: nowrap; }
thead th { font-weight: 600; color: #555; vertical-align: bottom; text-align: center; white-space: nowrap; }
tbody th { text-align: left; font-weight: 500; white-space: nowrap; }
small { color: #666; }
.none { color: #999; }
.best { font-weight: 600; background: #dff2e4; }
.mark { white-space: nowrap; }
.dot { display: inline-block; width: .7em; height: .7em; border-radius: 50%; margin-right: .45em; }
figure { margin: 1.2rem 0; padding: 1rem; border: 1px solid #e2e2e2; border-radius: 8px; }
figure svg { width: 100%; height: auto; display: block; }
figcaption { color: #555; font-size: .9rem; margin-top: .5rem; }
.strip { display: grid; grid-template-columns: repeat(auto-fill, minmax(15rem, 1fr)); gap: .8rem; }
.hough { display: grid; gap: .5rem; margin-bottom: .8rem; }
.frame img { display: block; width: 100%; height: auto; border-radius: 4px; margin-bottom: .3rem; }
.frame p { margin: 0; font-size: .85rem; color: #555; }
.remark { color: #8a4b00; }
)";

std::string base64(const std::vector<unsigned char>& bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

void write_text(const fs::path& path, std::string_view text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace

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
  std::vector<unsigned char> bytes;
  cv::imencode("." + std::string(format), image, bytes,
               format == "png" ? std::vector<int>{cv::IMWRITE_PNG_COMPRESSION, 9}
                               : std::vector<int>{cv::IMWRITE_JPEG_QUALITY, 85});
  return fmt::format("<img alt=\"{}\" width=\"{}\" height=\"{}\" src=\"data:image/{};base64,{}\">",
                     escaped(alt), image.cols, image.rows, format, base64(bytes));
}

std::string figure_html(std::string_view title, std::string_view reading, std::string_view content) {
  return fmt::format("<figure><h3>{}</h3>\n{}\n<figcaption>{}</figcaption></figure>\n", escaped(title),
                     content, reading);
}

std::string figure_html(std::string_view title, std::string_view reading, const Figure& figure,
                        const fs::path& folder) {
  write_numbers(folder, figure.name, figure.csv);
  return figure_html(title, fmt::format("{} <a href=\"figures/{}.csv\">Numbers</a>", reading, figure.name),
                     without_namespaces(figure.svg));
}

void write_numbers(const fs::path& folder, std::string_view name, std::string_view csv) {
  std::error_code error;
  fs::create_directories(folder / "figures", error);
  if (error) throw RunError((folder / "figures").string() + ": cannot make the folder: " + error.message());
  write_text(folder / "figures" / (std::string(name) + ".csv"), csv);
}

void write_page(const fs::path& folder, std::string_view title, std::string_view body) {
  write_text(
      folder / "report.html",
      fmt::format("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta "
                  "name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n"
                  "<style>{1}</style>\n</head>\n<body>\n<h1>{0}</h1>\n{2}</body>\n</html>\n",
                  escaped(title), style, body));
}

}  // namespace saccade
