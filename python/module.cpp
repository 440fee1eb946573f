#include "python/module.h"

#include "python/errors.h"
#include "session/version.h"

PYBIND11_MODULE(_saccade, m) {
  m.doc() = "Compiled part of the module saccade";
  m.attr("version") = saccade::version();
  saccade::python::add_errors();
  saccade::python::add_recordings(m);
  saccade::python::add_detectors(m);
  saccade::python::add_emulator(m);
  saccade::python::add_files(m);
  saccade::python::add_scoring(m);
  saccade::python::add_geometry(m);
  saccade::python::add_replay(m);
  saccade::python::add_simulation(m);
}
