#include "evaluation/sensor_fit/sensor_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "evaluation/report/gnuplot.h"
#include "evaluation/report/html.h"
#include "evaluation/report/palette.h"

namespace saccade {
namespace {

constexpr std::size_t curve_points = 400;
constexpr Colour before_colour{0x88, 0x88, 0x88};

/// The share of values up to each of some of them.
std::vector<GnuplotFigure::Point> distribution_of(const std::vector<double>& sorted) {
  std::vector<GnuplotFigure::Point> points;
  const std::size_t count = std::min(curve_points, sorted.size());
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = count < 2 ? 0 : i * (sorted.size() - 1) / (count - 1);
    points.push_back({sorted[k], static_cast<double>(k + 1) / static_cast<double>(sorted.size()), 0.0});
  }
  return points;
}

Figure distribution_figure(const ComparedDistribution& d, std::size_t number) {
  GnuplotFigure figure(fmt::format("distribution_{}", number), 900, 320);
  figure.set_over_x();
  const auto line = [](Colour colour, const char* dash) {
    return fmt::format("lines lw 1.8 {} lc rgb '{}'", dash, hex(colour));
  };
  figure.add_panel(
      {.x_label = d.quantity,
       .y_label = "share up to it",
       .z_label = "",
       .commands = std::string("set yrange [0:1.03]\nset key bottom right\n") +
                   (d.logarithmic ? "set logscale x\n" : ""),
       .series = {
           {.title = "recorded", .style = line(truth_colour, ""), .points = distribution_of(d.recorded)},
           {.title = fmt::format("prior, KS distance {:.3f}", d.ks_before),
            .style = line(before_colour, "dt 2"),
            .points = distribution_of(d.before)},
           {.title = fmt::format("fitted, KS distance {:.3f}", d.ks_after),
            .style = line(on_colour, ""),
            .points = distribution_of(d.after)}}});
  return figure.draw();
}

std::string parameter_table(const SensorFit& fit) {
  std::string html =
      "<table><thead><tr><th>parameter</th><th>prior</th><th>fitted</th><th>±</th><th>decided "
      "by</th></tr></thead>"
      "<tbody>\n";
  for (const FittedParameter& p : fit.parameters) {
    html += fmt::format(
        "<tr><td>{}</td><td>{:.4g}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", escaped(p.key), p.prior,
        p.identifiable ? fmt::format("{:.4g}", p.value) : "not identifiable",
        p.identifiable ? fmt::format("{:.1f} %", 100.0 * p.deviation) : "–", escaped(p.decided_by));
  }
  return html + "</tbody></table>\n";
}

std::string distance_table(const SensorFit& fit) {
  std::string html =
      "<table><thead><tr><th>recording</th><th>quantity</th><th>KS distance of the prior</th><th>of the "
      "fit</th></tr>"
      "</thead><tbody>\n";
  for (const ComparedDistribution& d : fit.distributions) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{:.3f}</td><td>{:.3f}</td></tr>\n",
                        escaped(d.recording), escaped(d.quantity), d.ks_before, d.ks_after);
  }
  return html + "</tbody></table>\n";
}

struct StillQuantity {
  const char* name;
  const char* key;
  StillValue StillFit::*member;
};
constexpr std::array still_quantities = {
    StillQuantity{"ON threshold / noise", "on", &StillFit::on},
    StillQuantity{"OFF threshold / noise", "off", &StillFit::off},
    StillQuantity{"ON / OFF threshold", "on_over_off", &StillFit::on_over_off},
    StillQuantity{"bandwidth, Hz", "cutoff_hz", &StillFit::cutoff_hz},
    StillQuantity{"refractory period, s", "refractory_s", &StillFit::refractory_s},
    StillQuantity{"leak, Hz", "leak_hz", &StillFit::leak_hz},
    StillQuantity{"spread over pixels", "spread", &StillFit::spread}};

std::string still_table(const SensorFit& fit) {
  std::string html =
      "<h2>Scenes at rest</h2>\n<p>With intervals of 95 %. Events of noise depend on threshold / noise "
      "alone: a "
      "still scene does not tell threshold and noise apart.</p>\n<table><thead><tr><th>recording</th><th>ON "
      "events</th><th>OFF events</th><th>rms residual</th>";
  for (const StillQuantity& q : still_quantities) html += fmt::format("<th>{}</th>", q.name);
  html += "</tr></thead><tbody>\n";
  for (const StillFit& s : fit.still) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.2g}</td>", escaped(s.recording),
                        s.on_events, s.off_events, s.misfit);
    for (const StillQuantity& q : still_quantities) {
      const StillValue& v = s.*q.member;
      html += v.identifiable ? fmt::format("<td>{:.3g} ({:.3g} to {:.3g})</td>", v.value, v.low, v.high)
                             : std::string("<td>not identifiable</td>");
    }
    html += "</tr>\n";
    if (!s.limit.empty())
      html +=
          fmt::format("<tr><td colspan=\"11\">{}: {}</td></tr>\n", escaped(s.recording), escaped(s.limit));
  }
  return html + "</tbody></table>\n";
}

}  // namespace

void write_sensor_page(const SensorFit& fit, const std::filesystem::path& folder) {
  std::string html = fmt::format(
      "<p class=\"facts\">{} features of every other pixel; rms residual {:.3g} deviations with the prior, "
      "{:.3g} after "
      "the fit.</p>\n<h2>Parameters</h2>\n",
      fit.features, fit.misfit_before, fit.misfit_after);
  html += parameter_table(fit);
  html +=
      "<p class=\"remark\">± is the relative standard deviation. A parameter that is not identifiable keeps "
      "the value of "
      "the prior.</p>\n";
  if (!fit.still.empty()) html += still_table(fit);
  html += "<h2>Recorded and emulated events</h2>\n<p>Of the pixels that the fit did not use.</p>\n";
  html += distance_table(fit);
  for (std::size_t i = 0; i < fit.distributions.size(); ++i) {
    const ComparedDistribution& d = fit.distributions[i];
    html += figure_html(
        d.recording + ": " + d.quantity,
        "The closer a line lies to the recorded one, the better; the KS distance is the largest vertical "
        "difference.",
        distribution_figure(d, i + 1), FigureFolder{folder});
  }
  write_page(folder, "Event camera fitted to recordings", html);
}

std::string sensor_fit_remark(const SensorFit& fit) {
  std::string text = fmt::format(
      "# Fitted by saccade fit-sensor: rms residual of {} features {:.3g} deviations, {:.3g} with the prior "
      "{}.\n",
      fit.features, fit.misfit_after, fit.misfit_before, fit.prior.preset);
  if (!fit.distributions.empty()) {
    const auto [least, most] =
        std::minmax_element(fit.distributions.begin(), fit.distributions.end(),
                            [](const auto& a, const auto& b) { return a.ks_after < b.ks_after; });
    text += fmt::format("# KS distances to pixels that the fit did not use: {:.2f} to {:.2f}.\n",
                        least->ks_after, most->ks_after);
  }
  std::string open;
  for (const FittedParameter& p : fit.parameters) {
    if (!p.identifiable) open += (open.empty() ? "" : ", ") + p.key;
  }
  if (!open.empty()) text += "# Not identifiable: " + open + ".\n";
  return text;
}

std::string sensor_fit_json(const SensorFit& fit) {
  nlohmann::ordered_json json;
  json["features"] = fit.features;
  json["misfit"] = {{"prior", fit.misfit_before}, {"fit", fit.misfit_after}};
  for (const FittedParameter& p : fit.parameters) {
    json["parameters"][p.key] = {{"value", p.value},
                                 {"prior", p.prior},
                                 {"relative_deviation", p.deviation},
                                 {"identifiable", p.identifiable},
                                 {"decided_by", p.decided_by}};
  }
  for (const StillFit& s : fit.still) {
    nlohmann::ordered_json& row = json["still"][s.recording];
    row = {
        {"on_events", s.on_events}, {"off_events", s.off_events}, {"misfit", s.misfit}, {"limit", s.limit}};
    for (const StillQuantity& q : still_quantities) {
      const StillValue& v = s.*q.member;
      row[q.key] = v.identifiable
                       ? nlohmann::ordered_json{{"value", v.value}, {"low", v.low}, {"high", v.high}}
                       : nlohmann::ordered_json(nullptr);
    }
  }
  for (const ComparedDistribution& d : fit.distributions) {
    json["ks_distances"].push_back(
        {{"recording", d.recording}, {"quantity", d.quantity}, {"prior", d.ks_before}, {"fit", d.ks_after}});
  }
  return json.dump(2) + "\n";
}

}  // namespace saccade
