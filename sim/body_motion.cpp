#include "sim/body_motion.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numbers>
#include <sstream>

#include "core/error.h"
#include "core/units.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr std::array<const char*, 4> motion_columns = {"t_us", "pitch_deg", "roll_deg", "yaw_deg"};

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream rest(line);
  for (std::string cell; std::getline(rest, cell, ',');) {
    if (!cell.empty() && cell.back() == '\r') cell.pop_back();
    cells.push_back(cell);
  }
  return cells;
}

double number_in(const std::string& place, const std::string& cell) {
  std::istringstream text(cell);
  text.imbue(std::locale::classic());
  double value = 0.0;
  if (!(text >> value) || !std::isfinite(value) || !(text >> std::ws).eof())
    throw InputError(place, cell, "a number");
  return value;
}

}  // namespace

void describe(FieldVisitor& v, SwayConfig& c) {
  v.real("amplitude_deg", c.amplitude_deg, {0.0, 60.0}, "amplitude of the oscillation");
  v.real("frequency_hz", c.frequency_hz, {0.01, 20.0}, "frequency of the oscillation");
  v.real("phase_deg", c.phase_deg, {-360.0, 360.0}, "phase of the oscillation at start_s");
}

void describe(FieldVisitor& v, BodyMotionConfig& c) {
  v.real("start_s", c.start_s, {0.0, 3600.0}, "start of the motion");
  v.real("ramp_s", c.ramp_s, {0.0, 60.0}, "time in which the motion grows to its full size");
  v.section("pitch", c.pitch, "oscillation of pitch; + leans forward");
  v.section("roll", c.roll, "oscillation of roll");
  v.section("yaw", c.yaw, "oscillation of yaw; + turns right");
  v.path("file", c.file,
         "CSV file with the columns t_us, pitch_deg, roll_deg, yaw_deg: a recorded motion that is added; "
         "empty: none");
}

BodyMotion::BodyMotion(const BodyMotionConfig& config) : config_(config) {
  check_config("body motion", config);
  if (config.file.empty()) return;
  std::ifstream file(config.file);
  std::string line;
  if (!file || !std::getline(file, line)) throw InputError(config.file, "", "a readable CSV file");
  const std::vector<std::string> header = cells_of(std::string(without_mark(line)));
  std::array<std::size_t, motion_columns.size()> at{};
  for (std::size_t i = 0; i < motion_columns.size(); ++i) {
    const auto found = std::ranges::find(header, motion_columns[i]);
    if (found == header.end())
      throw InputError(config.file, line, std::string("a column ") + motion_columns[i]);
    at[i] = static_cast<std::size_t>(found - header.begin());
  }
  for (int number = 2; std::getline(file, line); ++number) {
    const std::string place = config.file + ":" + std::to_string(number);
    const std::vector<std::string> cells = cells_of(line);
    if (cells.size() != header.size()) throw InputError(place, line, "as many cells as the header has");
    const auto cell = [&](std::size_t i) { return number_in(place, cells[at[i]]); };
    const Sample sample{cell(0) * 1e-6, Eigen::Vector3d(cell(1), cell(2), cell(3)) * rad_per_deg};
    if (!samples_.empty() && !(sample.t_s > samples_.back().t_s))
      throw InputError(place, cells[at[0]], "a time after that of the line before");
    samples_.push_back(sample);
  }
}

Eigen::Vector3d BodyMotion::angles_rad(std::int64_t t_us) const {
  const double t_s = static_cast<double>(t_us) * 1e-6 - config_.start_s;
  if (!(t_s > 0.0)) return Eigen::Vector3d::Zero();
  const auto sway = [t_s](const SwayConfig& c) {
    return c.amplitude_deg * rad_per_deg *
           std::sin(2.0 * std::numbers::pi * c.frequency_hz * t_s + c.phase_deg * rad_per_deg);
  };
  Eigen::Vector3d angles(sway(config_.pitch), sway(config_.roll), sway(config_.yaw));
  if (!samples_.empty()) {
    const auto after = std::ranges::upper_bound(samples_, t_s, {}, &Sample::t_s);
    if (after == samples_.begin()) {
      angles += after->angles_rad;
    } else if (after == samples_.end()) {
      angles += samples_.back().angles_rad;
    } else {
      const Sample& before = *(after - 1);
      const double share = (t_s - before.t_s) / (after->t_s - before.t_s);
      angles += (1.0 - share) * before.angles_rad + share * after->angles_rad;
    }
  }
  if (t_s >= config_.ramp_s) return angles;
  const double u = t_s / config_.ramp_s;
  return u * u * u * (10.0 + u * (6.0 * u - 15.0)) * angles;
}

Eigen::Quaterniond base_rotation(const Eigen::Vector3d& angles_rad) {
  return Eigen::AngleAxisd(angles_rad[0], -Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(angles_rad[1], Eigen::Vector3d::UnitX()) *
         Eigen::AngleAxisd(angles_rad[2], -Eigen::Vector3d::UnitZ());
}

}  // namespace saccade
