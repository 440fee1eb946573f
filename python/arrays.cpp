#include "python/arrays.h"

#include <pybind11/stl.h>

#include <cstddef>
#include <memory>
#include <string>

#include "core/error.h"

namespace py = pybind11;

namespace saccade::python {

py::dtype event_dtype() {
  static_assert(sizeof(bool) == 1);
  py::list names, formats, offsets;
  const auto add = [&](const char* name, const char* format, std::size_t offset) {
    names.append(name);
    formats.append(format);
    offsets.append(offset);
  };
  add("x", "u2", offsetof(Event, x));
  add("y", "u2", offsetof(Event, y));
  add("p", "?", offsetof(Event, on));
  add("t", "i8", offsetof(Event, t_us));
  add("camera", "u1", offsetof(Event, camera));
  return {std::move(names), std::move(formats), std::move(offsets), sizeof(Event)};
}

py::array array_of(std::vector<Event>&& events) {
  auto owned = std::make_unique<std::vector<Event>>(std::move(events));
  const auto count = static_cast<py::ssize_t>(owned->size());
  const Event* const first = owned->data();
  py::capsule owner(owned.get(), [](void* vector) { delete static_cast<std::vector<Event>*>(vector); });
  owned.release();
  static const auto* const dtype = new py::dtype(event_dtype());  // never freed: Python may be gone by then
  return py::array(*dtype, {count}, {}, first, owner);
}

EventArgument::EventArgument(const py::object& argument) {
  py::object array = py::module_::import("saccade.arrays").attr("as_events")(argument);
  array_ = py::reinterpret_steal<py::array>(array.release());
  // An array may lie anywhere in a buffer; Event has the alignment of its time.
  if (reinterpret_cast<std::uintptr_t>(array_.data()) % alignof(Event) != 0)
    array_ = py::reinterpret_steal<py::array>(py::object(array_.attr("copy")()).release());
  events_ = {static_cast<const Event*>(array_.data()), static_cast<std::size_t>(array_.size())};
}

TimeUnit time_unit_argument(const std::string& word) {
  const auto unit = time_unit_of(word);
  if (!unit) throw InputError("time_unit", word, "s, ms, us or ns");
  return *unit;
}

ImageSize image_size_of(const std::pair<std::int64_t, std::int64_t>& size) {
  const auto& [width, height] = size;
  constexpr std::int64_t most = 65535;
  if (width < 1 || height < 1 || width > most || height > most)
    throw InputError("size", "(" + std::to_string(width) + ", " + std::to_string(height) + ")",
                     "(width, height), each from 1 to 65535");
  return {static_cast<int>(width), static_cast<int>(height)};
}

}  // namespace saccade::python
