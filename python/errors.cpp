#include "python/errors.h"

#include <algorithm>
#include <string>

#include "core/error.h"

namespace saccade::python {
namespace {

/// The problems, one a line. A key that came from Python is named alone, without the program's `--set`.
std::string text_of(const InputError& error) {
  constexpr std::string_view option = "--set ";
  std::string text;
  for (Problem problem : error.problems()) {
    if (problem.place.starts_with(option)) problem.place.erase(0, option.size());
    text += (text.empty() ? "" : "\n") + problem.text();
  }
  return text;
}

}  // namespace

void add_errors() {
  pybind11::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const InputError& error) {
      PyErr_SetString(PyExc_ValueError, text_of(error).c_str());
    } catch (const RunError& error) {
      PyErr_SetString(PyExc_RuntimeError, error.what());
    }
  });
}

}  // namespace saccade::python
