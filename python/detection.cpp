#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <memory>
#include <optional>

#include "core/detector_registry.h"
#include "python/arrays.h"
#include "python/keys.h"
#include "python/module.h"

namespace py = pybind11;

namespace saccade::inline v0_1::python {
namespace {

/// A detector of the registry.
class NamedDetector {
 public:
  NamedDetector(std::string name, const std::string& yaml, const Camera& camera) : name_(std::move(name)) {
    const DetectorRegistry registry = all_detectors();
    const DetectorConfig config = config_of(yaml, "detector " + name_, registry.config(name_));
    window_ = config.window();
    detector_ = make_detector(config, camera);
  }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const std::string& window() const { return window_; }
  [[nodiscard]] double threshold() const { return detector_->threshold(); }

  [[nodiscard]] std::string failure() const { return std::string(detector_->failure()); }

  void process(const py::object& events, const std::optional<CameraMotion>& motion) {
    const EventArgument argument(events);
    const py::gil_scoped_release others_run;
    detector_->process(argument.events(), motion ? &*motion : nullptr);
  }
  void advance_to(std::int64_t t_us, const std::optional<CameraMotion>& motion) {
    detector_->advance_to(t_us, motion ? &*motion : nullptr);
  }
  std::optional<Estimate> estimate() {
    const py::gil_scoped_release others_run;  // a detector in Python answers from a process of its own
    const Estimate estimate = detector_->estimate();
    return estimate.valid ? std::optional(estimate) : std::nullopt;
  }
  [[nodiscard]] py::dict rejected() const {
    const RejectedEvents counts = detector_->rejected();
    py::dict dict;
    dict["outside_image"] = counts.outside_image;
    dict["back_in_time"] = counts.back_in_time;
    return dict;
  }
  /// Observations of ticks of 1 ms from `start_us` on, or else from the first event on, as `saccade detect` makes them of
  /// a recording without truth: rows of time, circle, score and held.
  py::array_t<double> detect(const py::object& events, std::optional<std::int64_t> start_us) {
    constexpr std::int64_t tick_us = 1000;
    const EventArgument argument(events);
    std::vector<double> rows;
    {
      const py::gil_scoped_release others_run;
      std::span<const Event> left = argument.events();
      std::int64_t t_us = left.empty() ? 0 : start_us.value_or(left.front().t_us);
      while (!left.empty()) {
        t_us += tick_us;
        std::size_t count = 0;
        while (count < left.size() && left[count].t_us <= t_us) ++count;
        detector_->process(left.first(count), nullptr);
        detector_->advance_to(t_us, nullptr);
        left = left.subspan(count);
        const Estimate e = detector_->estimate();
        if (!e.valid || (count == 0 && !e.held)) continue;
        rows.insert(rows.end(), {static_cast<double>(t_us), e.circle.x_px, e.circle.y_px, e.circle.r_px,
                                 e.score, e.held ? 1.0 : 0.0});
      }
    }
    py::array_t<double> table({static_cast<py::ssize_t>(rows.size() / 6), py::ssize_t{6}});
    std::copy(rows.begin(), rows.end(), table.mutable_data());
    return table;
  }

 private:
  std::string name_;
  std::string window_;
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
      .def(py::init<std::string, const std::string&, const Camera&>())
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
      .def("_detect", &NamedDetector::detect, py::arg("events"), py::arg("start_us") = py::none());
  m.def("detectors", &detectors);
}

}  // namespace saccade::inline v0_1::python
