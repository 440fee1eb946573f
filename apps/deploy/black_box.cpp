#include "apps/deploy/black_box.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <iterator>
#include <system_error>

#include "core/error.h"
#include "head/head_model.h"

namespace saccade {
namespace {

constexpr std::int64_t sync_us = 1'000'000;
std::string tick_head(const HeadModel& head) {
  std::string text = "t_us,due_us,begin_us,end_us,missed,state,phase,joints_t_us";
  for (const HeadJoint& joint : head.joints) text += "," + joint.name;
  for (const HeadJoint& joint : head.joints) {
    if (joint.role != JointRole::torso) text += ",ref_" + joint.name;
  }
  return text + ",ref_rejected,target_x_m,target_y_m,target_z_m,new_target,x_px,y_px,r_px,score,events\n";
}

std::string_view word_of(GazePhase phase) {
  constexpr std::array<std::string_view, 5> words = {"none", "searching", "following", "holding", "resting"};
  return words.at(static_cast<std::size_t>(phase));
}

void append_number(std::string& text, double value) {
  fmt::format_to(std::back_inserter(text), ",{:.6g}", value);
}

template <class Values>
void append_numbers(std::string& text, const Values& values) {
  for (const double value : values) append_number(text, value);
}

}  // namespace

BlackBox::BlackBox(std::filesystem::path folder, std::shared_ptr<const HeadModel> head)
    : folder_(std::move(folder)),
      head_(std::move(head)),
      files_{{{"ticks", "csv", tick_head(*head_)},
              {"events", "csv", "t_us,x,y,p,camera\n"},
              {"messages", "txt", ""}}} {
  std::error_code error;
  std::filesystem::remove_all(folder_, error);
  std::filesystem::create_directories(folder_, error);
  if (error) throw RunError(folder_.string() + ": " + error.message());
}

BlackBox::~BlackBox() {
  flush();
  for (const File& file : files_) {
    if (file.descriptor >= 0) ::close(file.descriptor);
  }
}

void BlackBox::fail() {
  if (failure_.empty()) failure_ = folder_.string() + ": " + std::generic_category().message(errno);
}

/// Starts the other files when the present ones hold enough.
void BlackBox::turn(std::int64_t t_us) {
  newest_us_ = std::max(newest_us_, t_us);
  if (!failure_.empty() || (turned_us_ != INT64_MIN && t_us - turned_us_ < turn_us)) return;
  flush();
  turned_us_ = t_us;
  number_ = 1 - number_;
  for (File& file : files_) {
    if (file.descriptor >= 0) ::close(file.descriptor);
    const std::string path = (folder_ / fmt::format("{}_{}.{}", file.name, number_, file.ending)).string();
    file.descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
    if (file.descriptor < 0) return fail();
    file.text = file.head;
  }
}

void BlackBox::add(const Tick& tick, const TickTiming& timing, std::span<const DetectorTick> detectors,
                   std::span<const Event> events) {
  turn(tick.t_us);
  if (!failure_.empty()) return;
  std::string& text = files_[0].text;
  const int gaze_joints = head_->gaze_joints();
  fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{}", tick.t_us, timing.due_us, timing.begin_us,
                 timing.end_us, timing.missed, name_of(timing.state), word_of(tick.phase));
  if (tick.head) {
    fmt::format_to(std::back_inserter(text), ",{}", tick.head->t_us);
    for (const HeadJoint& joint : head_->joints) append_number(text, tick.head->position_rad[joint.slot]);
  } else {
    text.append(1 + head_->joints.size(), ',');
  }
  if (timing.state == DeployState::active) {
    for (int j = 0; j < gaze_joints; ++j) append_number(text, tick.command.reference_rad[j]);
    fmt::format_to(std::back_inserter(text), ",{}", tick.command_rejected ? 1 : 0);
  } else {
    text.append(static_cast<std::size_t>(gaze_joints) + 1, ',');
  }
  if (tick.target_m) {
    append_numbers(text, *tick.target_m);
  } else {
    text.append(3, ',');
  }
  fmt::format_to(std::back_inserter(text), ",{}", tick.target_status == TargetStatus::ok ? 1 : 0);
  if (!detectors.empty() && detectors.front().observed) {
    const Estimate& estimate = detectors.front().estimate;
    append_numbers(text, std::array{estimate.circle.x_px, estimate.circle.y_px, estimate.circle.r_px,
                                    static_cast<double>(estimate.score)});
  } else {
    text.append(4, ',');
  }
  fmt::format_to(std::back_inserter(text), ",{}\n", tick.events.size());
  for (const Event& event : events) {
    fmt::format_to(std::back_inserter(files_[1].text), "{},{},{},{},{}\n", event.t_us, event.x, event.y,
                   event.on ? 1 : 0, event.camera);
  }
}

void BlackBox::add(std::int64_t t_us, std::string_view message) {
  turn(t_us);
  if (failure_.empty())
    fmt::format_to(std::back_inserter(files_[2].text), "{:10.3f} s  {}\n", 1e-6 * static_cast<double>(t_us),
                   message);
}

void BlackBox::flush() {
  const bool sync = newest_us_ - synced_us_ >= sync_us;
  if (sync) synced_us_ = newest_us_;
  for (File& file : files_) {
    std::string_view left = file.text;
    while (!left.empty() && file.descriptor >= 0 && failure_.empty()) {
      const ssize_t written = ::write(file.descriptor, left.data(), left.size());
      if (written < 0 && errno != EINTR) fail();
      if (written > 0) left.remove_prefix(static_cast<std::size_t>(written));
    }
    file.text.clear();
    if (sync && file.descriptor >= 0) (void)::fdatasync(file.descriptor);
  }
}

}  // namespace saccade
