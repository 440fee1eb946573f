#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "core/error.h"
#include "evaluation/report/report.h"
#include "images/emulation.h"
#include "python/arrays.h"
#include "python/keys.h"
#include "python/module.h"

namespace py = pybind11;

namespace saccade::python {
namespace {

/// Lets Ctrl-C end long work.
void check_signals() {
  const py::gil_scoped_acquire here;
  if (PyErr_CheckSignals() != 0) throw py::error_already_set();
}

py::dict emulate(const std::filesystem::path& images, const std::filesystem::path& out,
                 std::optional<double> images_per_s, const std::filesystem::path& timestamps,
                 const std::optional<std::string>& time_unit, std::int64_t seed, int threads,
                 const std::string& yaml) {
  if (threads < 1 || threads > 256)
    throw InputError("threads", std::to_string(threads), "a number from 1 to 256");
  EmulationConfig config;
  config.images = images;
  config.out = out;
  config.images_per_s = images_per_s;
  config.timestamps = timestamps;
  if (time_unit) config.time_unit = time_unit_argument(*time_unit);
  config.seed = seed;
  config.threads = threads;
  config.emulator = config_of(yaml, "emulator", EmulatorConfig{});
  EmulationResult result;
  {
    const py::gil_scoped_release others_run;
    result = emulate_images(config, built_in_formats(), [](std::int64_t, std::int64_t) { check_signals(); });
  }
  py::dict dict;
  dict["images"] = result.images;
  dict["size"] = py::make_tuple(result.info.size.width, result.info.size.height);
  dict["first_us"] = result.first_us;
  dict["last_us"] = result.last_us;
  dict["on"] = result.counts.on;
  dict["off"] = result.counts.off;
  dict["dropped"] = result.counts.dropped;
  return dict;
}

}  // namespace

void add_files(py::module_& m) {
  m.def("emulate", &emulate, py::arg("images"), py::arg("out"), py::arg("images_per_s"),
        py::arg("timestamps"), py::arg("time_unit"), py::arg("seed"), py::arg("threads"), py::arg("keys"));
  m.def(
      "report",
      [](const std::filesystem::path& run, const std::filesystem::path& figures) {
        const py::gil_scoped_release others_run;
        write_report(run, built_in_formats(), figures);
      },
      py::arg("run"), py::arg("figures"));
}

}  // namespace saccade::python
