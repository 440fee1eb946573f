#pragma once

#include <pybind11/pybind11.h>

#include "core/detectors/built_in_detectors.h"
#include "external/external_rows.h"

namespace saccade::python {

/// The detectors that saccade ships and those outside of it (external).
[[nodiscard]] inline DetectorRegistry all_detectors() {
  DetectorRegistry registry = built_in_detectors();
  add_external_detectors(registry);
  return registry;
}

/// The gaze controllers likewise.
[[nodiscard]] inline ControllerRegistry all_controllers() {
  ControllerRegistry registry = built_in_controllers();
  add_external_controllers(registry);
  return registry;
}

/// Parts of the compiled module `_saccade`, each in a file of its own. What users call is python/saccade/__init__.py.
void add_recordings(pybind11::module_& m);
void add_detectors(pybind11::module_& m);
void add_emulator(pybind11::module_& m);
void add_files(pybind11::module_& m);
void add_scoring(pybind11::module_& m);
void add_geometry(pybind11::module_& m);
void add_replay(pybind11::module_& m);
void add_simulation(pybind11::module_& m);

}  // namespace saccade::python
