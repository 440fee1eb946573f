#include "evaluation/gnuplot.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>

#include "core/error.h"
#include "evaluation/figures.h"

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

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

bool is_gap(const GnuplotFigure::Point& point) { return !std::isfinite(point.x + point.y + point.z); }

std::string data_block(const std::vector<GnuplotFigure::Point>& points) {
  const std::size_t stride = (points.size() + max_figure_points - 1) / max_figure_points;
  std::string text;
  bool gap = true;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (is_gap(points[i])) {
      text += gap ? "" : "\n";
      gap = true;
    } else if (gap || i % stride == 0) {
      text += fmt::format("{:.6g} {:.6g} {:.6g}\n", points[i].x, points[i].y, points[i].z);
      gap = false;
    }
  }
  return text;
}

}  // namespace

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

void GnuplotFigure::add_panel(std::string_view commands, const std::vector<Series>& series, bool three_d) {
  std::string plot;
  for (const Series& s : series) {
    const std::string block = data_block(s.points);
    if (block.empty()) continue;
    const std::string id = "$d" + std::to_string(blocks_++);
    data_ += id + " << EOD\n" + block + "EOD\n";
    plot += fmt::format("{}{} using {} {} with {}", plot.empty() ? "" : ", ", id, three_d ? "1:2:3" : "1:2",
                        s.title.empty() ? "notitle" : "title " + gnuplot_quoted(s.title), s.style);
  }
  // A panel without data still shows its axes: a line that lies outside them.
  if (plot.empty()) plot = three_d ? "[0:1][0:1][0:1] -1 notitle" : "[0:1][0:1] -1 notitle";
  plots_ += std::string(commands) + (three_d ? "splot " : "plot ") + plot + "\n";
}

std::string GnuplotFigure::svg(std::string_view layout) const {
  std::string text = run_gnuplot(terminal_ + data_ + std::string(layout) + plots_);
  text.erase(0, text.find("<svg"));
  while (text.ends_with('\n')) text.pop_back();
  const std::size_t description = text.find("<desc>");
  text.erase(description,
             text.find("</desc>") + 7 - description);  // names gnuplot's version
  replace_all(text, "id='", "id='" + name_ + "_");
  replace_all(text, "id=\"", "id=\"" + name_ + "_");
  replace_all(text, "'#gp", "'#" + name_ + "_gp");
  return text;
}

}  // namespace saccade
