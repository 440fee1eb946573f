#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>

#include "core/error.h"
#include "core/time_stamp.h"
#include "python/arrays.h"
#include "python/module.h"
#include "recording/format_registry.h"

namespace py = pybind11;

namespace saccade::python {
namespace {

constexpr std::size_t block_events = 1 << 16;

/// A recording that is being read. Not for use by several Python threads at once.
class Recording {
 public:
  explicit Recording(std::unique_ptr<EventReader> reader) : reader_(std::move(reader)) {}

  [[nodiscard]] std::optional<std::pair<int, int>> size() const {
    const auto size = reader_->image_size();
    if (!size) return std::nullopt;
    return std::pair(size->width, size->height);
  }
  [[nodiscard]] std::string format() const { return reader_->format(); }
  [[nodiscard]] std::string skipped() const { return reader_->skipped(); }

  /// Up to `count` events; fewer at the end only.
  py::array read(std::size_t count) {
    std::vector<Event> events = take_rest();
    {
      const py::gil_scoped_release others_run;
      while (events.size() < count &&
             reader_->read(events, std::min(block_events, count - events.size())) > 0) {
      }
      if (events.size() > count) {
        rest_.assign(events.begin() + static_cast<std::ptrdiff_t>(count), events.end());
        events.resize(count);
      }
    }
    return array_of(std::move(events));
  }

  /// The events of the next window of duration_us, in file order; none at the end.
  std::optional<py::array> read_window(std::int64_t duration_us) {
    std::vector<Event> events = take_rest();
    {
      const py::gil_scoped_release others_run;
      if (events.empty() && reader_->read(events, block_events) == 0) return std::nullopt;
      if (!window_end_us_) window_end_us_ = events.front().t_us;
      window_end_us_ = saturated_sum(*window_end_us_, duration_us);
      const auto is_later = [&](const Event& event) { return event.t_us >= *window_end_us_; };
      std::size_t seen = 0;
      while (true) {
        const auto later =
            std::find_if(events.begin() + static_cast<std::ptrdiff_t>(seen), events.end(), is_later);
        if (later != events.end()) {
          rest_.assign(later, events.end());
          events.erase(later, events.end());
          break;
        }
        seen = events.size();
        if (reader_->read(events, block_events) == 0) break;
      }
    }
    return array_of(std::move(events));
  }

 private:
  std::vector<Event> take_rest() { return std::exchange(rest_, {}); }

  std::unique_ptr<EventReader> reader_;
  std::vector<Event> rest_;  // read from the file and not returned yet
  std::optional<std::int64_t> window_end_us_;
};

Recording open_recording(const std::filesystem::path& path,
                         const std::optional<std::pair<std::int64_t, std::int64_t>>& size,
                         std::optional<std::uint8_t> camera, const std::string& columns,
                         const std::optional<std::string>& time_unit, const std::string& yarp_codec,
                         const std::string& aedat2_layout, const std::string& evt_encoding,
                         const std::string& event_stream_y, const std::string& format) {
  return Recording(open_event_file(path, read_options(size, camera, columns, time_unit, yarp_codec,
                                                      aedat2_layout, evt_encoding, event_stream_y, format)));
}

void write(const std::filesystem::path& path, const py::object& events,
           const std::pair<std::int64_t, std::int64_t>& size) {
  const EventArgument argument(events);
  const py::gil_scoped_release others_run;
  const bool both = std::ranges::any_of(argument.events(), [](const Event& e) { return e.camera != 0; });
  const auto writer = create_event_file(path, image_size_of(size), both ? 2 : 1);
  writer->write(argument.events());
  writer->commit();
}

py::list formats() {
  py::list rows;
  const FormatRegistry registry = built_in_formats();
  for (const RecordingFormat& format : registry.formats()) {
    py::dict row;
    row["name"] = format.name;
    row["extensions"] = format.extensions;
    row["written"] = static_cast<bool>(format.create);
    rows.append(row);
  }
  return rows;
}

/// The field of event_dtype and the unit ("" where there is none) that a name means; None for other names.
std::optional<std::pair<std::string, std::string>> named_column(const std::string& name) {
  const auto named = event_column(name);
  if (!named) return std::nullopt;
  constexpr std::array<const char*, event_columns> fields = {"t", "x", "y", "p", "camera"};
  return std::pair(std::string(fields[static_cast<std::size_t>(named->column)]),
                   std::string(named->unit ? word_of(*named->unit) : ""));
}

template <class T>
using NumberArray = py::array_t<T, py::array::c_style | py::array::forcecast>;

template <class T>
py::array_t<std::int64_t> us_of(const NumberArray<T>& times, const std::string& word) {
  const auto unit = word.empty() ? std::nullopt : std::optional(time_unit_argument(word));
  const std::span<const T> from(times.data(), static_cast<std::size_t>(times.size()));
  if constexpr (std::is_same_v<T, double>) {
    const std::string why = unit ? "" : why_not_seconds(from.first(std::min<std::size_t>(from.size(), 4096)));
    if (!why.empty())
      throw InputError("t", why, "us as whole numbers, s, or as_events(events, time_unit=...)");
  }
  const TimeUnit in = unit.value_or(std::is_same_v<T, double> ? TimeUnit::s : TimeUnit::us);
  py::array_t<std::int64_t> result(times.size());
  std::int64_t* to = result.mutable_data();
  for (std::size_t i = 0; i < from.size(); ++i) {
    const auto t_us = to_us(from[i], in);
    const bool plausible = unit || !t_us || (*t_us <= longest_plausible_us && *t_us >= -longest_plausible_us);
    if (!t_us || !plausible)
      throw InputError("t of event " + std::to_string(i), std::string(py::str(py::cast(from[i]))),
                       plausible ? "times within 2^62 us"
                                 : "times within 4e15 us of 0, or as_events(events, time_unit=...)");
    to[i] = *t_us;
  }
  return result;
}

/// Times of an array, whole numbers or floating-point ones, in the unit of that word; "": us, or s.
py::array times_in_us(const py::array& times, const std::string& word) {
  if (times.dtype().kind() == 'f') return us_of(NumberArray<double>(times), word);
  return us_of(NumberArray<std::int64_t>(times), word);
}

}  // namespace

EventReadOptions read_options(const std::optional<std::pair<std::int64_t, std::int64_t>>& size,
                              std::optional<std::uint8_t> camera, const std::string& columns,
                              const std::optional<std::string>& time_unit, const std::string& yarp_codec,
                              const std::string& aedat2_layout, const std::string& evt_encoding,
                              const std::string& event_stream_y, const std::string& format) {
  EventReadOptions options;
  if (size) options.image_size = image_size_of(*size);
  options.camera = camera;
  options.columns = columns;
  if (time_unit) options.time_unit = time_unit_argument(*time_unit);
  options.yarp_codec = yarp_codec;
  options.aedat2_layout = aedat2_layout;
  options.evt_encoding = evt_encoding;
  options.event_stream_y = event_stream_y;
  options.format = format;
  return options;
}

void add_recordings(py::module_& m) {
  m.attr("event_dtype") = event_dtype();
  py::class_<Recording>(m, "Recording", "A recording that is being read, from its start to its end.")
      .def_property_readonly("size", &Recording::size, "(width, height), or None where the file has no size.")
      .def_property_readonly("format", &Recording::format, "Name of the format, such as \"AEDAT 4.0\".")
      .def_property_readonly("skipped", &Recording::skipped,
                             "Records skipped so far because they are no events of a camera.")
      .def("read", &Recording::read, py::arg("count"), "Up to `count` further events; fewer only at the end.")
      .def("read_window", &Recording::read_window, py::arg("duration_us"),
           "The events of the next window of `duration_us`; None at the end.");
  m.def("open_recording", &open_recording, py::arg("path"), py::arg("size"), py::arg("camera"),
        py::arg("columns"), py::arg("time_unit"), py::arg("yarp_codec"), py::arg("aedat2_layout"),
        py::arg("evt_encoding"), py::arg("event_stream_y"), py::arg("format"));
  m.def("write", &write, py::arg("path"), py::arg("events"), py::arg("size"));
  m.def("formats", &formats);
  // For arrays.py: what the names of fields and the times of arrays mean is what it means in files.
  m.def("event_column", &named_column);
  m.def("times_in_us", &times_in_us);
}

}  // namespace saccade::python
