#include "python/object_parts.h"

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <cmath>

#include "core/detector_parts.h"
#include "core/error.h"
#include "python/arrays.h"

namespace py = pybind11;

namespace saccade::python {
namespace {

/// An instance of a class, or the object itself, ready for a run.
py::object instance_of(const SharedObject& object, const py::object& argument) {
  if (PyType_Check(object->ptr()) != 0) return (*object)(argument);
  if (py::hasattr(*object, "reset")) object->attr("reset")();
  return *object;
}

std::string shown(const py::handle& value) {
  std::string text = py::str(py::repr(value));
  constexpr std::size_t longest = 80;
  if (text.size() > longest) text = text.substr(0, longest) + "...";
  return text;
}

constexpr const char* estimate_form =
    "None, an Estimate, or (x, y, r, score), then held and a covariance of six numbers as needed";

/// xx, xy, xr, yy, yr, rr.
Eigen::Matrix3d covariance_of(const std::vector<double>& values) {
  Eigen::Matrix3d covariance;
  covariance << values[0], values[1], values[2], values[1], values[3], values[4], values[2], values[4],
      values[5];
  return covariance;
}

Estimate estimate_of(const py::object& answer, const std::string& place) {
  if (answer.is_none()) return {};
  if (py::isinstance<Estimate>(answer)) return answer.cast<Estimate>();
  const auto refuse = [&]() -> Estimate { throw InputError(place, shown(answer), estimate_form); };
  if (!py::isinstance<py::sequence>(answer) && !py::isinstance<py::array>(answer)) return refuse();
  const auto parts = py::cast<std::vector<py::object>>(py::list(answer));
  if (parts.size() < 4 || parts.size() > 6) return refuse();
  Estimate estimate;
  estimate.valid = true;
  try {
    estimate.circle = {parts[0].cast<double>(), parts[1].cast<double>(), parts[2].cast<double>()};
    estimate.score = parts[3].cast<double>();
    if (parts.size() > 4) estimate.held = py::bool_(parts[4]);
    if (parts.size() > 5 && !parts[5].is_none()) {
      const auto values = parts[5].cast<std::vector<double>>();
      if (values.size() != 6) return refuse();
      estimate.covariance_px2 = covariance_of(values);
      if (!(estimate.covariance_px2.diagonal().minCoeff() >= 0.0)) return refuse();
    }
  } catch (const py::cast_error&) {
    return refuse();
  }
  const Circle& c = estimate.circle;
  const bool is_finite = std::isfinite(c.x_px) && std::isfinite(c.y_px) && std::isfinite(c.r_px) &&
                         std::isfinite(estimate.score) && estimate.covariance_px2.allFinite();
  return is_finite && c.r_px > 0.0 ? estimate : refuse();
}

void require_member(const py::object& object, const std::string& place, const char* member) {
  if (!py::hasattr(object, member))
    throw InputError(place, shown(object), std::string("an object with ") + member);
}

class ObjectDetector final : public Detector {
 public:
  ObjectDetector(std::string name, const SharedObject& object, std::shared_ptr<ObjectErrors> errors,
                 ImageSize size)
      : name_(std::move(name)), errors_(std::move(errors)), sieve_(size) {
    const py::gil_scoped_acquire python;
    const py::object instance = instance_of(object, py::make_tuple(size.width, size.height));
    for (const char* member : {"threshold", "process", "estimate"})
      require_member(instance, "detector " + name_, member);
    threshold_ = py::float_(instance.attr("threshold"));
    advances_ = py::hasattr(instance, "advance_to");
    object_ = shared_object(instance);
  }

  void process(std::span<const Event> events, const CameraMotion* motion) override {
    std::vector<Event> accepted;
    accepted.reserve(events.size());
    for (const Event& event : events) {
      if (sieve_.accept(event)) accepted.push_back(event);
    }
    if (accepted.empty()) return;
    call([&] { object_->attr("process")(array_of(std::move(accepted)), motion_of(motion)); });
  }
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override {
    if (!advances_) return;
    call([&] { object_->attr("advance_to")(now_us, motion_of(motion)); });
  }
  Estimate estimate() override {
    Estimate estimate;
    call([&] { estimate = estimate_of(object_->attr("estimate")(), "detector " + name_ + ": estimate()"); });
    return estimate;
  }
  [[nodiscard]] double threshold() const override { return threshold_; }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  [[nodiscard]] std::string_view failure() const override { return failure_; }

 private:
  static py::object motion_of(const CameraMotion* motion) {
    return motion != nullptr ? py::cast(*motion) : py::none();
  }
  template <class Work>
  void call(Work work) {
    if (!failure_.empty()) return;
    const py::gil_scoped_acquire python;
    try {
      work();
    } catch (...) {
      failure_ = name_ + ": " + errors_->note();
    }
  }

  std::string name_;
  std::shared_ptr<ObjectErrors> errors_;
  EventSieve sieve_;
  SharedObject object_;
  double threshold_ = 0.0;
  bool advances_ = false;
  std::string failure_;
};

class ObjectController final : public GazeController {
 public:
  ObjectController(const SharedObject& object, std::shared_ptr<ObjectErrors> errors,
                   const MotionLimits& limits)
      : errors_(std::move(errors)),
        limits_(limits),
        reference_rad_(HeadJointVector::Zero().cwiseMax(limits.min_rad).cwiseMin(limits.max_rad)) {
    const py::gil_scoped_acquire python;
    py::object named = py::module_::import("types").attr("SimpleNamespace")();
    const auto add = [&](const char* name, const HeadJointVector& values) {
      named.attr(name) = py::cast(Eigen::VectorXd(values.head(limits.joints)));
    };
    add("min_rad", limits.min_rad);
    add("max_rad", limits.max_rad);
    add("speed_rad_s", limits.speed_rad_s);
    const py::object instance = instance_of(object, named);
    require_member(instance, "controller", "step");
    object_ = shared_object(instance);
  }

  HeadJointVector step(const HeadState& state, const std::optional<Eigen::Vector3d>& target_m,
                       double dt_s) override {
    status_ = TargetStatus::none;
    if (!is_finite(state)) return reference_rad_;
    if (target_m)
      status_ = check_gaze_target(*target_m, HeadKinematics(limits_.head->chain, state.position_rad));
    if (!failure_.empty()) return reference_rad_;
    const py::gil_scoped_acquire python;
    try {
      if (rest_ && py::hasattr(*object_, "rest")) object_->attr("rest")();
      rest_ = false;
      py::object target = py::none();
      if (status_ == TargetStatus::ok) target = py::cast(*target_m);
      set_reference(object_->attr("step")(limits_.head->in_order(state.position_rad), target, dt_s));
    } catch (...) {
      failure_ = "controller: " + errors_->note();
    }
    return reference_rad_;
  }
  void rest() override { rest_ = true; }
  [[nodiscard]] TargetStatus target_status() const override { return status_; }
  [[nodiscard]] std::string_view failure() const override { return failure_; }

 private:
  void set_reference(const py::object& answer) {
    std::vector<double> values;
    try {
      for (const py::handle value : answer) values.push_back(value.cast<double>());
    } catch (const py::cast_error&) {
      values.clear();
    }
    bool is_whole = values.size() == static_cast<std::size_t>(limits_.joints);
    for (const double value : values) is_whole = is_whole && std::isfinite(value);
    if (!is_whole)
      throw InputError("controller: step()", shown(answer), std::to_string(limits_.joints) + " angles, rad");
    for (int j = 0; j < limits_.joints; ++j) reference_rad_[j] = values[static_cast<std::size_t>(j)];
    reference_rad_ = reference_rad_.cwiseMax(limits_.min_rad).cwiseMin(limits_.max_rad).eval();
  }

  std::shared_ptr<ObjectErrors> errors_;
  MotionLimits limits_;
  HeadJointVector reference_rad_;
  SharedObject object_;
  TargetStatus status_ = TargetStatus::none;
  bool rest_ = false;
  std::string failure_;
};

}  // namespace

SharedObject shared_object(py::object object) {
  return {new py::object(std::move(object)), [](py::object* held) {
            const py::gil_scoped_acquire python;
            delete held;
          }};
}

std::string ObjectErrors::note() {
  if (!first_) first_ = std::current_exception();
  try {
    throw;
  } catch (const std::exception& error) {
    const std::string text = error.what();
    return text.substr(0, text.find('\n'));
  } catch (...) {
    return "an exception that is none of Python's";
  }
}

void ObjectErrors::rethrow() {
  if (first_) std::rethrow_exception(std::exchange(first_, nullptr));
}

void ObjectParts::add_to(DetectorRegistry& registry) const {
  for (const auto& [name, object] : detectors) {
    registry.add(
        detector_row(name, "a Python object of this process", NoKeys{},
                     [name = name, object = object, errors = errors](const NoKeys&, const Camera& camera) {
                       return object_detector(name, object, errors, camera.size);
                     }));
  }
}

void ObjectParts::add_to(ControllerRegistry& registry) const {
  if (!controller) return;
  registry.add(
      controller_row("object", "a Python object of this process", NoKeys{},
                     [object = controller, errors = errors](const NoKeys&, const MotionLimits& limits) {
                       return std::make_unique<ObjectController>(object, errors, limits);
                     }));
}

std::unique_ptr<Detector> object_detector(std::string name, const SharedObject& object,
                                          std::shared_ptr<ObjectErrors> errors, ImageSize size) {
  return std::make_unique<ObjectDetector>(std::move(name), object, std::move(errors), size);
}

}  // namespace saccade::python
