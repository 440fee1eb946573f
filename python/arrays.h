#pragma once

#include <pybind11/numpy.h>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/event.h"
#include "recording/event_columns.h"
#include "recording/event_file.h"

namespace saccade::python {

/// The dtype of events: x, y (uint16), p (bool, true = ON), t (int64, us), camera (uint8). It has the memory layout of
/// Event, so that arrays of it are passed without a copy in both directions.
[[nodiscard]] pybind11::dtype event_dtype();

/// An array that owns the events.
[[nodiscard]] pybind11::array array_of(std::vector<Event>&& events);

/// Events of an argument, as long as this object exists: the array's own memory where its dtype is event_dtype() and it
/// is contiguous, else a copy. Throws a Python exception for an argument that holds no events.
class EventArgument {
 public:
  explicit EventArgument(const pybind11::object& argument);
  [[nodiscard]] std::span<const Event> events() const { return events_; }

 private:
  pybind11::array array_;
  std::span<const Event> events_;
};

/// Of the words s, ms, us and ns. Throws InputError for others.
[[nodiscard]] TimeUnit time_unit_argument(const std::string& word);

/// Width and height. Throws InputError unless both are in [1, 65535].
[[nodiscard]] ImageSize image_size_of(const std::pair<std::int64_t, std::int64_t>& size);

/// How a recording is read, from the arguments of open().
[[nodiscard]] EventReadOptions read_options(const std::optional<std::pair<std::int64_t, std::int64_t>>& size,
                                            std::optional<std::uint8_t> camera, const std::string& columns,
                                            const std::optional<std::string>& time_unit,
                                            const std::string& yarp_codec, const std::string& aedat2_layout,
                                            const std::string& evt_encoding,
                                            const std::string& event_stream_y, const std::string& format);

}  // namespace saccade::python
