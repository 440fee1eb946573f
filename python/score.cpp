#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <limits>
#include <map>
#include <string>

#include "core/error.h"
#include "evaluation/scoring/metrics.h"
#include "python/module.h"

namespace py = pybind11;

namespace saccade::python {
namespace {

using Column = py::array_t<double, py::array::c_style | py::array::forcecast>;
using Times = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

/// Columns of detections, one element a row; arrays.py makes them equally long.
std::vector<DetectionRow> detection_rows(const Times& t_us, const std::vector<std::string>& detector,
                                         const Column& circles, const Column& score, const Column& held) {
  std::vector<DetectionRow> rows(static_cast<std::size_t>(t_us.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double* const circle = circles.data() + 3 * i;
    rows[i].t_us = t_us.data()[i];
    rows[i].detector = detector[i];
    rows[i].circle = {circle[0], circle[1], circle[2]};
    rows[i].score = score.data()[i];
    rows[i].held = held.data()[i] != 0.0;
  }
  return rows;
}

std::vector<TruthRow> truth_rows(const Times& t_us, const Column& circles, const Column& visible) {
  std::vector<TruthRow> rows(static_cast<std::size_t>(t_us.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const double* const circle = circles.data() + 3 * i;
    rows[i].t_us = t_us.data()[i];
    rows[i].circle = {circle[0], circle[1], circle[2]};
    rows[i].visible = visible.data()[i];
  }
  return rows;
}

/// The block `detectors` of metrics.json as text, by detector in the order in which they first appear.
std::string score(const std::vector<DetectionRow>& detections, const std::vector<TruthRow>& truth,
                  const std::map<std::string, double>& thresholds, const std::vector<std::string>& names) {
  const py::gil_scoped_release others_run;
  std::vector<std::pair<std::string, DetectorScore>> scores;
  const Chances chances = chances_of(truth);
  for (const std::string& name : names) {
    check_instants(truth, detections, name, "detections");
    const auto given = thresholds.find(name);
    const double threshold =
        given != thresholds.end() ? given->second : std::numeric_limits<double>::quiet_NaN();
    scores.emplace_back(name, score_detector(truth, detections, name, threshold, chances));
  }
  return detectors_to_json(scores);
}

class Detections {
 public:
  std::vector<DetectionRow> rows;
};
class Truth {
 public:
  std::vector<TruthRow> rows;
};

}  // namespace

void add_scoring(py::module_& m) {
  py::class_<Detections>(m, "Detections")
      .def(py::init(
          [](const std::filesystem::path& path) { return Detections{read_table<DetectionRow>(path)}; }))
      .def(py::init([](const Times& t_us, const std::vector<std::string>& detector, const Column& circles,
                       const Column& score, const Column& held) {
        return Detections{detection_rows(t_us, detector, circles, score, held)};
      }))
      .def_property_readonly("names", [](const Detections& detections) {
        std::vector<std::string> names;
        for (const DetectionRow& row : detections.rows) {
          if (std::find(names.begin(), names.end(), row.detector) == names.end())
            names.push_back(row.detector);
        }
        return names;
      });
  py::class_<Truth>(m, "Truth")
      .def(py::init([](const std::filesystem::path& path) { return Truth{read_table<TruthRow>(path)}; }))
      .def(py::init([](const Times& t_us, const Column& circles, const Column& visible) {
        return Truth{truth_rows(t_us, circles, visible)};
      }));
  m.def("score", [](const Detections& detections, const Truth& truth,
                    const std::map<std::string, double>& thresholds, const std::vector<std::string>& names) {
    return score(detections.rows, truth.rows, thresholds, names);
  });
}

}  // namespace saccade::python
