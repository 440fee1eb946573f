#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <span>

#include "core/error.h"
#include "emulator/event_emulator.h"
#include "images/emulation.h"
#include "python/arrays.h"
#include "python/keys.h"
#include "python/module.h"

namespace py = pybind11;

namespace saccade::python {
namespace {

using Image = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// The emulator of an event camera on images in memory.
class ArrayEmulator {
 public:
  ArrayEmulator(const std::pair<std::int64_t, std::int64_t>& size, std::uint64_t seed, int threads,
                const std::string& yaml)
      : size_(image_size_of(size)),
        config_(config_of(yaml, "emulator", EmulatorConfig{})),
        emulator_(config_, size_, seed, checked(threads)) {}

  py::array process(const Image& image, std::int64_t t_us) {
    if (image.ndim() != 2 || image.shape(0) != size_.height || image.shape(1) != size_.width)
      throw InputError("image", "an array of shape " + std::string(py::str(image.attr("shape"))),
                       "(" + std::to_string(size_.height) + ", " + std::to_string(size_.width) + ")");
    std::vector<Event> events;
    {
      const py::gil_scoped_release others_run;
      const std::span luminance(image.data(), static_cast<std::size_t>(image.size()));
      emulator_.process_image(luminance, t_us, events);
      if (!warned_) largest_ = std::max(largest_, *std::ranges::max_element(luminance));
    }
    warn_of_range();
    return array_of(std::move(events));
  }
  py::array finish() {
    std::vector<Event> events;
    emulator_.finish(events);
    return array_of(std::move(events));
  }
  [[nodiscard]] std::pair<int, int> size() const { return {size_.width, size_.height}; }
  [[nodiscard]] py::dict counts() const {
    const EmulatorCounts& counts = emulator_.counts();
    py::dict dict;
    dict["on"] = counts.on;
    dict["off"] = counts.off;
    dict["dropped"] = counts.dropped;
    dict["waiting"] = counts.waiting;
    return dict;
  }

 private:
  /// Once, after the second image that is not dark: events come from differences of images.
  void warn_of_range() {
    if (warned_ || !(largest_ > 0.0F) || ++images_ < 2) return;
    warned_ = true;
    const std::string warning = luminance_warning(config_, largest_);
    if (!warning.empty() && PyErr_WarnEx(PyExc_UserWarning, warning.c_str(), 1) != 0)
      throw py::error_already_set();
  }

  static int checked(int threads) {
    if (threads < 1 || threads > 256)
      throw InputError("threads", std::to_string(threads), "a number from 1 to 256");
    return threads;
  }

  ImageSize size_;
  EmulatorConfig config_;
  EventEmulator emulator_;
  float largest_ = 0.0F;  ///< luminance so far
  int images_ = 0;        ///< since the first one that is not dark
  bool warned_ = false;
};

}  // namespace

void add_emulator(py::module_& m) {
  py::class_<ArrayEmulator>(m, "Emulator")
      .def(py::init<const std::pair<std::int64_t, std::int64_t>&, std::uint64_t, int, const std::string&>(),
           py::arg("size"), py::arg("seed"), py::arg("threads"), py::arg("keys"))
      .def_property_readonly("size", &ArrayEmulator::size, "(width, height) of the images.")
      .def_property_readonly("counts", &ArrayEmulator::counts, "Counts of all events since the start.")
      .def("process", &ArrayEmulator::process, py::arg("image"), py::arg("t_us"),
           "Processes the image at t_us and returns the events with time stamps in (previous t_us, t_us].\n\n"
           "image: luminance, array of shape (height, width), linear light, >= 0; white is the key `white`.\n"
           "The first image makes no event. Times rise from image to image.")
      .def("finish", &ArrayEmulator::finish,
           "The events of the last image that latency and readout still delay.");
  m.def("emulator_presets", &emulator_presets);
}

}  // namespace saccade::python
