#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <span>

#include "apps/cli/commands.h"
#include "apps/cli/read_options.h"
#include "config/scenario.h"
#include "control/head_kinematics.h"
#include "core/error.h"
#include "evaluation/calibration/calibration.h"
#include "evaluation/scoring/metrics.h"
#include "recording/output_file.h"
#include "robot/replay/replay_robot.h"
#include "session/interrupt.h"
#include "session/replay_source.h"

namespace saccade {
namespace {

constexpr std::int64_t step_us = 50'000;  ///< from one image to the next

struct CalibrateOptions : ReadOptions {
  std::filesystem::path out;
  std::string grid = "4x7";
  std::string lens;
  std::optional<double> spacing_mm, dot_mm;
  double window_ms = 1500.0;
  std::optional<std::int64_t> refractory_us;
  CalibrationLimits limits;
  bool no_joints = false;
  bool force = false;
};

double in_range(const char* option, double value, Range range) {
  if (!range.contains(value)) throw InputError(option, text_of(value), expectation_of(range, "a number"));
  return value;
}

/// "4x7"
void parse_grid(const std::string& text, DotGrid& grid) {
  const char* const end = text.data() + text.size();
  const auto columns = std::from_chars(text.data(), end, grid.columns);
  if (columns.ec == std::errc() && columns.ptr != end && *columns.ptr == 'x') {
    const auto rows = std::from_chars(columns.ptr + 1, end, grid.rows);
    const bool in_range = grid.columns >= 2 && grid.rows >= 3 && grid.columns <= 20 && grid.rows <= 21;
    if (rows.ec == std::errc() && rows.ptr == end && in_range && grid.rows % 2 == 1) return;
  }
  throw InputError("--grid", text,
                   "COLUMNSxROWS, 2 to 20 dots in a row and an odd number of rows up to 21, such as 4x7");
}

/// The data of a calibration: a bare recording, or a run folder with its joints and its board.
struct Source {
  std::filesystem::path events;
  std::optional<RecordedHead> head;
  DotGrid grid;
  std::int64_t refractory_us = 500;
  LensModel lens = LensModel::radial_tangential;
};

Source open_source(const CalibrateOptions& options, Eye eye, const Registry& registry) {
  Source source{options.recording, {}, {}};
  parse_grid(options.grid, source.grid);
  if (std::filesystem::is_directory(options.recording)) {
    const std::filesystem::path& folder = options.recording;
    source.events = folder / read_metrics(folder / "metrics.json").events_file;
    if (!options.no_joints) source.head = recorded_head(folder);
    const std::filesystem::path scenario = folder / "scenario.yaml";
    if (std::filesystem::exists(scenario)) {
      const SimConfig sim = read_scenario(scenario, {}, std::nullopt, registry).sim;
      source.refractory_us = sim.emulator.refractory_us;
      source.lens = eye == Eye::right ? sim.right.camera.lens : sim.camera.lens;
      if (const auto& board = sim.world.board) {
        source.grid = {static_cast<int>(board->columns), static_cast<int>(board->rows),
                       board->spacing_mm * 1e-3, board->dot_diameter_mm * 1e-3};
      }
    }
  }
  for (const auto& [lens, word] : words_of(LensModel{})) {
    if (options.lens == word) source.lens = lens;
  }
  if (options.refractory_us) source.refractory_us = *options.refractory_us;
  if (options.spacing_mm)
    source.grid.spacing_m = in_range("--spacing-mm", *options.spacing_mm, {1.0, 1000.0}) * 1e-3;
  if (options.dot_mm)
    source.grid.dot_diameter_m = in_range("--dot-mm", *options.dot_mm, {0.5, 1000.0}) * 1e-3;
  return source;
}

/// Sets the speeds from one view to the next; a view without a neighbour in time counts as fast.
void note_speeds(std::vector<CalibrationView>& views) {
  const auto speed = [](const CalibrationView& a, const CalibrationView& b) {
    const std::int64_t apart_us = b.grid.t_us - a.grid.t_us;
    if (apart_us > step_us) return 1e9;
    double farthest_px = 0.0;
    for (std::size_t i = 0; i < a.grid.dots_px.size(); ++i) {
      farthest_px = std::max(farthest_px, cv::norm(b.grid.dots_px[i] - a.grid.dots_px[i]));
    }
    return farthest_px * 1e6 / static_cast<double>(apart_us);
  };
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double before = i > 0 ? speed(views[i - 1], views[i]) : 1e9;
    const double after = i + 1 < views.size() ? speed(views[i], views[i + 1]) : 1e9;
    views[i].grid.speed_px_s =
        before < 1e9 && after < 1e9 ? std::max(before, after) : std::min(before, after);
  }
}

std::vector<CalibrationView> find_views(ReplayRobot& robot, const Source& source, Eye eye,
                                        const CalibrateOptions& options) {
  const auto window_us =
      static_cast<std::int64_t>(1e3 * in_range("--window-ms", options.window_ms, {10.0, 60'000.0}));
  ReconstructedImage image(robot.image_size(), window_us, source.refractory_us);
  std::vector<CalibrationView> views;
  std::vector<Event> events;
  const std::int64_t start_us = robot.now_us();
  std::int64_t used = 0;
  for (std::int64_t t_us = start_us + step_us; !interrupted(); t_us += step_us) {
    if (robot.wait_until(t_us) == PortStatus::ended) break;
    events.clear();
    const bool ended = robot.read_until(t_us, events) == PortStatus::ended;
    used += static_cast<std::int64_t>(events.size());
    image.add(events);
    if (t_us - start_us >= window_us && !events.empty()) {
      if (auto dots = find_grid(image.image(t_us), source.grid)) {
        CalibrationView& view = views.emplace_back();
        view.grid = {t_us, std::move(*dots), 0.0};
        HeadState head;
        if (robot.head() != nullptr && robot.head()->read(head) != PortStatus::lost) {
          view.root_from_eye =
              HeadKinematics(robot.head()->limits().head->chain, head.position_rad).root_from_eye(eye);
        }
      }
    }
    if (ended) break;
  }
  if (used == 0) {
    throw InputError(options.recording.string(), "no events of the camera",
                     "a recording with some; see saccade info");
  }
  note_speeds(views);
  return views;
}

void print(const Calibration& calibration, std::size_t found) {
  const CalibrationQuality& q = calibration.quality;
  const CalibrationDeviations& d = calibration.deviations;
  const Camera& c = calibration.camera.camera;
  fmt::print(
      "views        {} of {} images with the grid; {:.0f} % of the image; tilts differ by {:.0f} deg\n",
      q.views, found, 100.0 * q.covered, q.tilt_spread_deg);
  fmt::print("fit          {:.3f} px rms\n", q.rms_px);
  fmt::print("fx, fy       {:.3f} +- {:.3f}, {:.3f} +- {:.3f} px\n", c.fx_px, d.fx_px, c.fy_px, d.fy_px);
  fmt::print("cx, cy       {:.3f} +- {:.3f}, {:.3f} +- {:.3f} px\n", c.cx_px, d.cx_px, c.cy_px, d.cy_px);
  fmt::print("k1, k2       {:.4f} +- {:.4f}, {:.4f} +- {:.4f}\n", c.k1, d.k1, c.k2, d.k2);
  if (c.lens == LensModel::fisheye) {
    fmt::print("k3, k4       {:.4f} +- {:.4f}, {:.4f} +- {:.4f}\n", c.k3, d.k3, c.k4, d.k4);
  } else {
    fmt::print("p1, p2       {:.5f} +- {:.5f}, {:.5f} +- {:.5f}\n", c.p1, d.p1, c.p2, d.p2);
  }
  fmt::print("lens         {}, from dots up to {:.0f} deg off the optical axis{}\n", word_of(c.lens),
             q.max_angle_deg,
             q.held == 0 ? std::string()
             : q.held == 1
                 ? "; these do not tell k4 from 0, and it is held there"
                 : fmt::format("; these do not tell k{} to k4 from 0, and they are held there", 5 - q.held));
  if (q.rests == 0) {
    fmt::print("eye          not calibrated: no joints were used\n");
    return;
  }
  const auto three = [](std::span<const double> values, std::span<const double> deviations) {
    std::string text;
    for (std::size_t i = 0; i < 3; ++i) {
      text += fmt::format("{}{:.3f} +- {:.3f}", i > 0 ? ", " : "", values[i], deviations[i]);
    }
    return text;
  };
  fmt::print("eye          {} rests of the board, {:.3f} px rms\n", q.rests, q.rms_at_rest_px);
  fmt::print("translation  {} mm\n", three(calibration.camera.mount.translation_mm, d.translation_mm));
  fmt::print("rotation     {} deg\n", three(calibration.camera.mount.rotation_deg, d.rotation_deg));
}

int calibrate_command(const CalibrateOptions& options, const Registry& registry) {
  if (std::filesystem::exists(options.out) && !options.force)
    throw InputError(options.out.string(), "a file that exists", "a new name, or --force");
  EventReadOptions read = options.read;
  read.camera = read.camera.value_or(0);
  const Eye eye = static_cast<Eye>(*read.camera);
  Source source = open_source(options, eye, registry);
  ReplayRobot robot(open_event_file(options.formats, source.events, read), std::move(source.head));
  catch_interrupts();
  const std::vector<CalibrationView> views = find_views(robot, source, eye, options);
  if (interrupted()) throw RunError("interrupted");
  const Calibration calibration =
      calibrate(views, source.grid, robot.image_size(), source.lens, robot.head() != nullptr, options.limits);
  write_file(options.out, calibration_yaml(calibration));
  print(calibration, views.size());
  fmt::print("{}\n", options.out.string());
  return 0;
}

}  // namespace

void add_calibrate_command(CommandLine& line, const Registry& registry) {
  auto options = std::make_shared<CalibrateOptions>();
  Command command = line.add_command(
      "calibrate", "A camera's lens, and its place in the eye, from events of an asymmetric grid of dots");
  add_read_options(command, "recording", "Event file, or a run folder with its joints", *options,
                   registry.formats);
  command.option("--out", options->out, "The calibration (YAML), for a scenario's calibration.file")
      .required();
  command.option("--grid", options->grid, "Dots in a row x rows, rows odd; a run with a board has its own")
      .show_default();
  command
      .option("--lens", options->lens,
              "Model of the lens; the run's camera has its own, else radial_tangential")
      .one_of({"radial_tangential", "fisheye"});
  command.option("--spacing-mm", options->spacing_mm,
                 "From row to row, and half the way between dots of a row; the run's board, or 25");
  command.option("--dot-mm", options->dot_mm, "Diameter of a dot; the run's board, or 21");
  command
      .option("--window-ms", options->window_ms,
              "Events for one image; in this time white passes every pixel of the board")
      .show_default();
  command
      .option("--refractory-us", options->refractory_us,
              "Time after an event in which a pixel is blind; the run's camera, or 500")
      .in_range(0, 100'000);
  command.option("--max-speed-px-s", options->limits.max_speed_px_s, "Images with a faster dot are not used")
      .in_range(0.1, 1e4)
      .show_default();
  command.flag("--no-joints", options->no_joints, "The lens alone, even if the run has joints");
  command.flag("--force", options->force, "Replace the file at --out");
  command.action([options, &registry] { return calibrate_command(*options, registry); });
}

}  // namespace saccade
