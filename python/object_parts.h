#pragma once

#include <pybind11/pybind11.h>

#include <exception>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "control/controller_registry.h"
#include "core/detector_registry.h"

namespace saccade::python {

/// A Python object that C++ holds without the interpreter's lock (GIL): the lock is taken where the last copy ends.
using SharedObject = std::shared_ptr<pybind11::object>;
[[nodiscard]] SharedObject shared_object(pybind11::object object);

/// The first exception that a detector or controller of this process has raised; written and read with the GIL.
class ObjectErrors {
 public:
  /// To be called in a catch block. Returns the exception in one line.
  std::string note();
  /// Throws it, once.
  void rethrow();

 private:
  std::exception_ptr first_;
};

/// Detectors and a gaze controller that are Python objects of this process, with the members of docs/external_detectors.md and
/// docs/external_controllers.md. A class is instantiated for each simulation; an object is used as it is, and its method
/// `reset()` is called before, where there is one.
struct ObjectParts {
  std::vector<std::pair<std::string, SharedObject>>
      detectors;            ///< by their names, which become rows of the registry
  SharedObject controller;  ///< becomes the row `object`; may be null
  std::shared_ptr<ObjectErrors> errors = std::make_shared<ObjectErrors>();

  void add_to(DetectorRegistry& registry) const;
  void add_to(ControllerRegistry& registry) const;
};

/// A detector that is a Python object. Throws Python's exceptions for one without the members. After an exception it has
/// no estimate any more.
[[nodiscard]] std::unique_ptr<Detector> object_detector(std::string name, const SharedObject& object,
                                                        std::shared_ptr<ObjectErrors> errors, ImageSize size);

}  // namespace saccade::python
