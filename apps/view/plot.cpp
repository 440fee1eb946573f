#include "apps/view/plot.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

namespace saccade {
namespace {

const cv::Scalar paper(22, 22, 24);
const cv::Scalar grid(54, 54, 58);
constexpr ImU32 dim = IM_COL32(150, 150, 156, 255);

/// 1, 2 or 5 times a power of ten: the smallest that is not below `least`.
double round_step(double least) {
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= least * (1.0 - 1e-9)) return factor * power;
  }
  return 10.0 * power;
}

/// The values of a curve at the pixel columns of a plot; NaN where there is none.
std::vector<float> columns_of(const PlotCurve& curve, const Snapshot& snapshot, std::size_t count) {
  std::vector<float> values(count, PlotSample::none);
  std::vector<float> sums(count, 0.0F);
  std::vector<int> numbers(count, 0);
  const double per_us = static_cast<double>(count) / static_cast<double>(Snapshot::plot_us);
  const std::int64_t begin_us = snapshot.now_us - Snapshot::plot_us;
  for (const PlotSample& sample : snapshot.samples) {
    const auto column = std::min(
        static_cast<std::size_t>(std::max(0.0, static_cast<double>(sample.t_us - begin_us) * per_us)),
        count - 1);
    const float value = curve.value(sample);
    if (!std::isfinite(value)) continue;
    values[column] = value;
    sums[column] += value;
    ++numbers[column];
  }
  if (curve.style != PlotCurve::Style::mean) return values;
  for (std::size_t i = 0; i < count; ++i) {
    if (numbers[i] > 0) values[i] = sums[i] / static_cast<float>(numbers[i]);
  }
  return values;
}

cv::Scalar scalar(ImU32 colour) {
  return {static_cast<double>(colour & 0xffU), static_cast<double>((colour >> 8U) & 0xffU),
          static_cast<double>((colour >> 16U) & 0xffU)};
}

/// Names of the curves in their colours: beside the title, or in rows inside the plot where there is no room.
void draw_legend(const Plot& plot, const Area& area, const Area& box) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  constexpr float between = 7.0F;
  const float row_height = ImGui::GetFontSize() + 1.0F;
  const auto width_of = [](const std::string& text) { return ImGui::CalcTextSize(text.c_str()).x; };
  float all = 0.0F;
  for (const PlotCurve& curve : plot.curves) all += width_of(curve.name) + between;
  if (width_of(plot.title) + between + all < area.width) {
    float x = box.x + box.width - all + between;
    for (const PlotCurve& curve : plot.curves) {
      draw.AddText({x, area.y}, curve.colour, curve.name.c_str());
      x += width_of(curve.name) + between;
    }
    return;
  }
  std::vector<std::pair<float, float>> places;  // from the left of the box, and below its top
  float x = 4.0F;
  float y = 1.0F;
  for (const PlotCurve& curve : plot.curves) {
    const float width = width_of(curve.name);
    if (x > 4.0F && x + width > box.width) {
      x = 4.0F;
      y += row_height;
    }
    places.emplace_back(x, y);
    x += width + between;
  }
  draw.AddRectFilled({box.x, box.y}, {box.x + box.width, box.y + y + row_height}, IM_COL32(22, 22, 24, 200));
  for (std::size_t i = 0; i < places.size(); ++i)
    draw.AddText({box.x + places[i].first, box.y + places[i].second}, plot.curves[i].colour,
                 plot.curves[i].name.c_str());
}

}  // namespace

void draw_plot(const Plot& plot, const Area& area, const Snapshot& snapshot, cv::Mat& canvas,
               const Area& origin) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const float font = ImGui::GetFontSize();
  const ImVec2 corner(area.x, area.y);
  draw.AddText(corner, ImGui::GetColorU32(ImGuiCol_Text), plot.title.c_str());
  const Area box = {area.x + 34.0F, area.y + font + 5.0F, area.width - 40.0F, area.height - 2 * font - 8.0F};
  const auto count = static_cast<std::size_t>(std::max(8.0F, box.width));

  double low = plot.low;
  double high = plot.high;
  std::vector<std::vector<float>> curves;
  for (const PlotCurve& curve : plot.curves) {
    curves.push_back(columns_of(curve, snapshot, count));
    if (plot.fixed) continue;
    for (const float value : curves.back()) {
      if (std::isfinite(value)) {
        low = std::min(low, static_cast<double>(value));
        high = std::max(high, static_cast<double>(value));
      }
    }
  }
  const double step = round_step(std::max(high - low, 1e-6) / 4.0);
  if (!plot.fixed) {
    low = std::floor(low / step + 1e-9) * step;
    high = std::ceil(high / step - 1e-9) * step;
  }

  const auto on_canvas = [&](float x, float y) {
    return cv::Point(static_cast<int>(std::lround(x - origin.x)),
                     static_cast<int>(std::lround(y - origin.y)));
  };
  const cv::Rect inside =
      cv::Rect(on_canvas(box.x, box.y), on_canvas(box.x + box.width, box.y + box.height)) &
      cv::Rect(0, 0, canvas.cols, canvas.rows);
  if (inside.empty()) return;
  cv::Mat sheet = canvas(inside);
  sheet = paper;
  const auto rule = [&](float x0, float y0, float x1, float y1) {
    cv::line(canvas, on_canvas(x0, y0), on_canvas(x1, y1), grid);
  };
  const auto y_of = [&](double value) {
    const double share = (value - low) / (high - low);
    return box.y + box.height * static_cast<float>(plot.downward ? share : 1.0 - share);
  };
  for (double tick = std::ceil(low / step - 1e-9) * step; tick <= high + 1e-9 * step; tick += step) {
    const float y = std::round(y_of(tick));
    rule(box.x, y, box.x + box.width - 1.0F, y);
    const std::string text = fmt::format("{:g}", std::abs(tick) < 1e-9 * step ? 0.0 : tick);
    const ImVec2 size = ImGui::CalcTextSize(text.c_str());
    const float text_y = std::clamp(y - 0.5F * size.y, box.y - 3.0F, box.y + box.height - size.y + 3.0F);
    draw.AddText({box.x - size.x - 4.0F, text_y}, dim, text.c_str());
  }
  const double now_s = static_cast<double>(snapshot.now_us - snapshot.start_us) * 1e-6;
  const double span_s = static_cast<double>(Snapshot::plot_us) * 1e-6;
  const auto x_of = [&](double t_s) {
    return box.x + box.width * static_cast<float>(1.0 - (now_s - t_s) / span_s);
  };
  for (double tick = std::max(0.0, std::ceil(now_s - span_s)); tick <= now_s; tick += 1.0) {
    const float x = std::round(x_of(tick));
    rule(x, box.y, x, box.y + box.height - 1.0F);
    const std::string text = fmt::format("{:.0f} s", tick + 0.0);
    const float width = ImGui::CalcTextSize(text.c_str()).x;
    if (x - 0.5F * width < box.x - 8.0F || x + 0.5F * width > box.x + box.width + 6.0F) continue;
    draw.AddText({x - 0.5F * width, box.y + box.height + 1.0F}, dim, text.c_str());
  }

  constexpr int fraction_bits = 4;
  for (std::size_t i = plot.curves.size(); i-- > 0;) {
    const PlotCurve& curve = plot.curves[i];
    const cv::Scalar colour = scalar(curve.colour);
    std::vector<cv::Point> points;
    const auto flush = [&] {
      if (points.size() == 1)
        cv::circle(sheet, points.front(), 20, colour, cv::FILLED, cv::LINE_AA, fraction_bits);
      if (points.size() > 1) cv::polylines(sheet, points, false, colour, 1, cv::LINE_AA, fraction_bits);
      points.clear();
    };
    for (std::size_t column = 0; column < count; ++column) {
      const float value = curves[i][column];
      if (!std::isfinite(value)) {
        flush();
        continue;
      }
      const float y = std::clamp(y_of(value) - box.y, -1e4F, 1e4F);
      if (curve.style == PlotCurve::Style::dots) {
        cv::rectangle(sheet, cv::Rect(static_cast<int>(column), static_cast<int>(y) - 1, 2, 2), colour,
                      cv::FILLED);
      } else {
        points.emplace_back(static_cast<int>(column << fraction_bits),
                            static_cast<int>(std::lround(y * (1 << fraction_bits))));
      }
    }
    flush();
  }

  draw_legend(plot, area, box);
}

}  // namespace saccade
