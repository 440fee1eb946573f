#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <memory>
#include <optional>

#include "config/scenario.h"
#include "core/error.h"
#include "core/units.h"
#include "loop/loop.h"
#include "python/arrays.h"
#include "python/keys.h"
#include "python/module.h"
#include "python/object_parts.h"
#include "robot/replay/replay_robot.h"
#include "session/replay_source.h"

namespace py = pybind11;

namespace saccade::python {
namespace {

/// Name, row of the registry, its keys, and instead of these a Python object.
using ReplayDetectors = std::vector<std::tuple<std::string, std::string, std::string, py::object>>;

/// A recording tick by tick, as `saccade detect` passes it to its detectors.
class Replay final : private LoopObserver {
 public:
  static constexpr std::int64_t tick_us = 1000;

  Replay(const std::filesystem::path& recording, const EventReadOptions& read,
         const ReplayDetectors& detectors, const std::filesystem::path& truth,
         const std::filesystem::path& joints, const std::filesystem::path& calibration)
      : errors_(std::make_shared<ObjectErrors>()) {
    ReplaySource source = open_replay_source({recording, read, built_in_formats()}, truth);
    if (!joints.empty()) add_joints(source, joints);
    if (!calibration.empty()) source.camera = read_calibration(calibration);
    truth_ = std::move(source.truth);
    robot_.emplace(open_event_file(built_in_formats(), source.events, source.read), std::move(source.head));
    MountedCamera camera = source.camera;
    if (!calibration.empty() && camera.camera.size != robot_->image_size())
      throw InputError(calibration.string(), in_words(camera.camera.size),
                       "a calibration for the recording's images, " + in_words(robot_->image_size()));
    camera.camera.size = robot_->image_size();
    eye_ = source.eye;
    eye_from_camera_ = camera.mount.eye_from_camera();
    loop_.emplace(*robot_, camera, made(detectors, camera.camera), std::nullopt, source.eye);
    const std::int64_t start_us = robot_->now_us();
    next_us_ = start_us - (start_us % tick_us + tick_us) % tick_us + tick_us;
  }

  /// The next tick; none after the last one.
  py::object next() {
    if (ended_) return py::none();
    PortStatus status = PortStatus::ok;
    seen_ = false;
    {
      const py::gil_scoped_release others_run;
      status = loop_->tick(next_us_, *this);
    }
    errors_->rethrow();
    if (status == PortStatus::lost)
      throw RunError("lost the connection to the " + std::string(loop_->lost()));
    ended_ = status != PortStatus::ok;
    next_us_ += tick_us;
    if (!seen_) return py::none();
    return tick();
  }

 private:
  void on_tick(const Tick& tick) override {
    seen_ = true;
    t_us_ = tick.t_us;
    events_.assign(tick.events.begin(), tick.events.end());
    head_ = tick.head;
    estimates_.clear();
    for (const DetectorTick& result : tick.detectors)
      estimates_.push_back(result.observed ? std::optional(result.estimate) : std::nullopt);
  }

  std::vector<LoopDetector> made(const ReplayDetectors& detectors, const Camera& camera) {
    const DetectorRegistry registry = all_detectors();
    std::vector<LoopDetector> result;
    for (const auto& [name, row, keys, object] : detectors) {
      if (!object.is_none()) {
        result.push_back({name, object_detector(name, shared_object(object), errors_, camera.size)});
      } else {
        const DetectorConfig config = config_of(keys, "detectors." + name, registry.config(row));
        result.push_back({name, make_detector(config, camera)});
      }
    }
    return result;
  }

  py::dict tick() {
    py::dict dict;
    dict["t_us"] = t_us_;
    dict["events"] = array_of(std::move(events_));
    events_ = {};
    dict["joints"] = py::none();
    dict["motion"] = py::none();
    if (head_ && is_finite(*head_)) {
      const HeadModel& head = *loop_->head();
      py::dict joints;
      const Eigen::VectorXd position_rad = head.in_order(head_->position_rad);
      for (std::size_t i = 0; i < head.joints.size(); ++i)
        joints[py::str(head.joints[i].name)] = position_rad[static_cast<Eigen::Index>(i)];
      dict["joints"] = joints;
      dict["motion"] = py::cast(camera_motion(head.chain, *head_, eye_, eye_from_camera_));
    }
    py::dict estimates;
    for (std::size_t i = 0; i < estimates_.size(); ++i) {
      const py::object estimate = estimates_[i] ? py::cast(*estimates_[i]) : py::none();
      estimates[py::str(loop_->detectors()[i].name)] = estimate;
    }
    dict["estimates"] = estimates;
    dict["truth"] = py::none();
    while (next_truth_ < truth_.size() && truth_[next_truth_].t_us < t_us_) ++next_truth_;
    if (next_truth_ < truth_.size() && truth_[next_truth_].t_us == t_us_) {
      const TruthRow& row = truth_[next_truth_];
      py::dict truth;
      truth["x_px"] = row.circle.x_px;
      truth["y_px"] = row.circle.y_px;
      truth["r_px"] = row.circle.r_px;
      truth["visible"] = row.visible;
      dict["truth"] = truth;
    }
    return dict;
  }

  std::shared_ptr<ObjectErrors> errors_;
  std::vector<TruthRow> truth_;
  std::size_t next_truth_ = 0;
  std::optional<ReplayRobot> robot_;
  std::optional<Loop> loop_;
  Eye eye_ = Eye::left;
  Eigen::Isometry3d eye_from_camera_ = Eigen::Isometry3d::Identity();
  std::int64_t next_us_ = 0;
  bool ended_ = false;
  bool seen_ = false;
  std::int64_t t_us_ = 0;
  std::vector<Event> events_;
  std::optional<HeadState> head_;
  std::vector<std::optional<Estimate>> estimates_;
};

}  // namespace

void add_replay(py::module_& m) {
  py::class_<Replay>(m, "Replay")
      .def(
          py::init([](const std::filesystem::path& path,
                      const std::optional<std::pair<std::int64_t, std::int64_t>>& size,
                      std::optional<std::uint8_t> camera, const std::string& columns,
                      const std::optional<std::string>& time_unit, const std::string& yarp_codec,
                      const std::string& aedat2_layout, const std::string& evt_encoding,
                      const std::string& event_stream_y, const std::string& format,
                      const ReplayDetectors& detectors, const std::filesystem::path& truth,
                      const std::filesystem::path& joints, const std::filesystem::path& calibration) {
            return std::make_unique<Replay>(path,
                                            read_options(size, camera, columns, time_unit, yarp_codec,
                                                         aedat2_layout, evt_encoding, event_stream_y, format),
                                            detectors, truth, joints, calibration);
          }),
          py::arg("path"), py::arg("size"), py::arg("camera"), py::arg("columns"), py::arg("time_unit"),
          py::arg("yarp_codec"), py::arg("aedat2_layout"), py::arg("evt_encoding"), py::arg("event_stream_y"),
          py::arg("format"), py::arg("detectors"), py::arg("truth"), py::arg("joints"),
          py::arg("calibration"))
      .def("next", &Replay::next);
}

}  // namespace saccade::python
