#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>

#include "core/detector_registry.h"
#include "core/error.h"
#include "core/time_stamp.h"
#include "python/arrays.h"
#include "python/keys.h"
#include "python/module.h"
#include "python/object_parts.h"
#include "session/detect_events.h"

namespace py = pybind11;

namespace saccade::python {
namespace {

using Instants = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

constexpr std::size_t row_size = 12;  ///< time, circle, score, held, covariance

/// A detector of the registry.
class NamedDetector {
 public:
  NamedDetector(std::string name, const std::string& yaml, const Camera& camera)
      : name_(std::move(name)), camera_(camera) {
    const DetectorRegistry registry = all_detectors();
    const DetectorConfig config = config_of(yaml, "detector " + name_, registry.config(name_));
    window_ = config.window();
    detector_ = make_detector(config, camera);
  }

  /// A Python object of this process.
  NamedDetector(const py::object& object, const Camera& camera)
      : name_(py::str(py::type::of(object).attr("__name__"))), camera_(camera) {
    detector_ = object_detector(name_, shared_object(object), errors_, camera.size);
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& window() const { return window_; }
  [[nodiscard]] double threshold() const { return detector_->threshold(); }

  [[nodiscard]] std::string failure() const { return std::string(detector_->failure()); }

  void process(const py::object& events, const std::optional<CameraMotion>& motion) {
    const EventArgument argument(events);
    {
      const py::gil_scoped_release others_run;
      detector_->process(argument.events(), motion ? &*motion : nullptr);
    }
    errors_->rethrow();
  }
  void advance_to(std::int64_t t_us, const std::optional<CameraMotion>& motion) {
    detector_->advance_to(t_us, motion ? &*motion : nullptr);
    errors_->rethrow();
  }
  std::optional<Estimate> estimate() {
    Estimate estimate;
    {
      const py::gil_scoped_release others_run;  // a detector may answer from a process of its own
      estimate = detector_->estimate();
    }
    errors_->rethrow();
    return estimate.valid ? std::optional(estimate) : std::nullopt;
  }
  [[nodiscard]] py::dict rejected() const {
    const RejectedEvents counts = detector_->rejected();
    py::dict dict;
    dict["outside_image"] = counts.outside_image;
    dict["back_in_time"] = counts.back_in_time;
    return dict;
  }
  /// Observations as `saccade detect` makes them: rows of time, circle, score and held. In ticks of 1 ms at whole
  /// milliseconds, or from `start_us` on; or at the instants `at_us`, which rise, as with truth that has these instants.
  py::array_t<double> detect(const py::object& events, std::optional<std::int64_t> start_us,
                             const std::optional<Instants>& at_us) {
    const EventArgument argument(events);
    const std::span<const std::int64_t> instants =
        at_us ? std::span(at_us->data(), static_cast<std::size_t>(at_us->size()))
              : std::span<const std::int64_t>();
    for (std::size_t i = 1; i < instants.size(); ++i) {
      if (instants[i] <= instants[i - 1])
        throw InputError("at_us[" + std::to_string(i) + "]", std::to_string(instants[i]),
                         "a time after the one before it, " + std::to_string(instants[i - 1]));
    }
    std::vector<TimedEstimate> found;
    {
      const py::gil_scoped_release others_run;
      found = at_us ? detect_events_at(*detector_, camera_, argument.events(), instants)
                    : detect_events(*detector_, camera_, argument.events(), start_us);
    }
    errors_->rethrow();
    std::vector<double> rows;
    for (const auto& [t_us, e] : found)
      rows.insert(rows.end(),
                  {static_cast<double>(t_us), e.circle.x_px, e.circle.y_px, e.circle.r_px, e.score,
                   e.held ? 1.0 : 0.0, e.covariance_px2(0, 0), e.covariance_px2(0, 1), e.covariance_px2(0, 2),
                   e.covariance_px2(1, 1), e.covariance_px2(1, 2), e.covariance_px2(2, 2)});
    py::array_t<double> table(
        {static_cast<py::ssize_t>(rows.size() / row_size), static_cast<py::ssize_t>(row_size)});
    std::copy(rows.begin(), rows.end(), table.mutable_data());
    return table;
  }

 private:
  std::string name_;
  Camera camera_;
  std::string window_;
  std::shared_ptr<ObjectErrors> errors_ = std::make_shared<ObjectErrors>();
  std::unique_ptr<Detector> detector_;
};

py::dict detectors() {
  py::dict names;
  const DetectorRegistry registry = all_detectors();
  for (const DetectorRow& row : registry.rows()) names[py::str(row.name)] = row.description;
  return names;
}

std::string shown(const Estimate& e) {
  return py::str("Estimate(x_px={:.2f}, y_px={:.2f}, r_px={:.2f}, score={:.3f}, held={})")
      .format(e.circle.x_px, e.circle.y_px, e.circle.r_px, e.score, e.held);
}

}  // namespace

void add_detectors(py::module_& m) {
  py::class_<Estimate>(m, "Estimate", "The best circle of a detector at one instant.")
      .def_property_readonly(
          "circle",
          [](const Estimate& e) { return py::make_tuple(e.circle.x_px, e.circle.y_px, e.circle.r_px); },
          "(x, y, r), pixels.")
      .def_property_readonly("x_px", [](const Estimate& e) { return e.circle.x_px; })
      .def_property_readonly("y_px", [](const Estimate& e) { return e.circle.y_px; })
      .def_property_readonly("r_px", [](const Estimate& e) { return e.circle.r_px; })
      .def_readonly("score", &Estimate::score, "Confidence, on the detector's own scale.")
      .def_readonly("held", &Estimate::held, "Held or predicted instead of measured from current events.")
      .def_readonly("covariance_px2", &Estimate::covariance_px2,
                    "Of (x, y, r), 3x3; zero where it is unknown.")
      .def("__repr__", &shown);
  py::class_<NamedDetector>(m, "Detector", "A detector of the registry; made by saccade.detector().")
      .def(py::init<std::string, const std::string&, const Camera&>(), py::arg("name"), py::arg("keys"),
           py::arg("camera"))
      .def(py::init<const py::object&, const Camera&>(), py::arg("object"), py::arg("camera"))
      .def_property_readonly("name", &NamedDetector::name)
      .def_property_readonly("threshold", &NamedDetector::threshold,
                             "The score from which on an estimate counts as the ball.")
      .def_property_readonly(
          "window", &NamedDetector::window,
          "The events that the estimate is made of, in words; empty without a fixed window.")
      .def_property_readonly("rejected", &NamedDetector::rejected,
                             "Counts of the events that the detector could not use.")
      .def("process", &NamedDetector::process, py::arg("events"), py::arg("motion") = py::none(),
           "Passes events of one camera, sorted by time; each event once.")
      .def("advance_to", &NamedDetector::advance_to, py::arg("t_us"), py::arg("motion") = py::none(),
           "Passes the current time, us; also without events.")
      .def("estimate", &NamedDetector::estimate, "The best circle after all events so far; None without one.")
      .def_property_readonly("failure", &NamedDetector::failure,
                             "Why a detector outside of this program has ended; empty while it works.")
      .def("_detect", &NamedDetector::detect, py::arg("events"), py::arg("start_us"), py::arg("at_us"));
  m.def("detectors", &detectors);
}

}  // namespace saccade::python
