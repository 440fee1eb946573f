#pragma once

#include <pybind11/pybind11.h>

namespace saccade::python {

/// InputError becomes ValueError, RunError becomes RuntimeError, with the message of the program.
void add_errors();

}  // namespace saccade::python
