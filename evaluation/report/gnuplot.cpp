#include "evaluation/report/gnuplot.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <functional>
#include <limits>
#include <memory>

#include "core/error.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/svg.h"

extern char** environ;

namespace saccade {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

File temporary_file() {
  File file(std::tmpfile(), &std::fclose);
  if (!file) throw RunError(std::string("figures: no temporary file: ") + std::strerror(errno));
  return file;
}

std::string contents(std::FILE* file) {
  std::string text;
  std::rewind(file);
  char buffer[65536];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof buffer, file)) > 0;) text.append(buffer, n);
  return text;
}

std::vector<char*> environment_with(std::string& setting) {
  const std::string_view key = std::string_view(setting).substr(0, setting.find('=') + 1);
  std::vector<char*> environment;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!std::string_view(*entry).starts_with(key)) environment.push_back(*entry);
  }
  environment.push_back(setting.data());
  environment.push_back(nullptr);
  return environment;
}

/// Files instead of pipes: neither side can wait for the other.
std::string run_gnuplot(const std::string& script) {
  const File in = temporary_file();
  const File out = temporary_file();
  const File err = temporary_file();
  if (std::fwrite(script.data(), 1, script.size(), in.get()) != script.size() || std::fflush(in.get()) != 0) {
    throw RunError(std::string("figures: cannot write a temporary file: ") + std::strerror(errno));
  }
  std::rewind(in.get());

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(in.get()), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(out.get()), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, fileno(err.get()), STDERR_FILENO);
  std::string program = "gnuplot";
  std::string no_user_settings = "--default-settings";
  char* arguments[] = {program.data(), no_user_settings.data(), nullptr};
  std::string locale = "LC_ALL=C";
  pid_t child = 0;
  const int failure =
      posix_spawnp(&child, "gnuplot", &actions, nullptr, arguments, environment_with(locale).data());
  posix_spawn_file_actions_destroy(&actions);
  if (failure == ENOENT) {
    throw RunError("figures: gnuplot is not installed (Debian package gnuplot-nox)");
  }
  if (failure != 0) throw RunError(std::string("figures: cannot start gnuplot: ") + std::strerror(failure));

  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  std::string svg = contents(out.get());
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0 || !svg.ends_with("</svg>\n\n")) {
    throw RunError("figures: gnuplot failed: " + contents(err.get()));
  }
  return svg;
}

using Point = GnuplotFigure::Point;

bool is_gap(const Point& point) { return !std::isfinite(point.x + point.y); }

std::string data_block(const std::vector<Point>& points) {
  const std::size_t stride = (points.size() + max_figure_points - 1) / max_figure_points;
  std::string text;
  bool gap = true;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_gap(points[i])) {
      text += gap ? "" : "\n";
      gap = true;
    } else if (gap || i % stride == 0) {
      text += fmt::format("{:.6g} {:.6g}\n", points[i].x, points[i].y);
      gap = false;
    }
  }
  return text;
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
    : name_(name),
      terminal_(
          fmt::format("set terminal svg size {},{} dynamic noenhanced font 'sans-serif,13' name {} "
                      "background rgb 'white'\nset border 3 lc rgb '#777777'\nset tics nomirror out scale "
                      "0.5 tc rgb '#333333'\nset grid lc rgb '#e4e4e4' lt 1\nset key top right samplen 2\n",
                      width, height, gnuplot_quoted(name))) {}

Figure GnuplotFigure::draw(std::string_view layout) const { return {name_, svg(layout), csv()}; }

std::string GnuplotFigure::csv() const {
  if (panels_.empty()) return {};
  std::string text = "series," + csv_field(panels_.front().x_label);
  for (const Panel& panel : panels_) {
    text += "," + csv_field(panel.y_label);
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

std::string GnuplotFigure::svg(std::string_view layout) const {
  std::string data;
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
    plots += panel.commands + "plot " + plot + "\n";
  }
  return page_svg(run_gnuplot(terminal_ + data + std::string(layout) + plots), name_);
}

}  // namespace saccade
