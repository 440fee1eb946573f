#include "recording/hdf5_layout.h"

#include <algorithm>
#include <array>
#include <map>

#include "core/error.h"
#include "recording/number_text.h"
#include "recording/text_header.h"

namespace saccade {
namespace {

constexpr std::size_t most_objects = 4096;
constexpr std::int64_t largest_length_px = 65536;

/// A dataset as far as its type and shape tell.
struct Found {
  std::string path;
  std::vector<hsize_t> dims;
  std::vector<std::string> members;  ///< of records
};

std::string parent_of(const std::string& path) { return path.substr(0, path.rfind('/')); }
std::string name_of(const std::string& path) { return path.substr(path.rfind('/') + 1); }

std::string in_words(const Found& found) {
  std::string text = printable(found.path) + " (";
  for (const hsize_t length : found.dims) text += (text.ends_with('(') ? "" : " x ") + std::to_string(length);
  for (const std::string& member : found.members)
    text += (text.ends_with('(') ? "" : " ") + printable(member);
  return found.dims.empty() && found.members.empty() ? printable(found.path) : text + ")";
}

std::vector<Found> datasets_in(hid_t file) {
  std::vector<std::string> paths;
  const auto take = [](hid_t, const char* name, const H5O_info_t* info, void* to) -> herr_t {
    auto& all = *static_cast<std::vector<std::string>*>(to);
    if (info->type == H5O_TYPE_DATASET) all.push_back("/" + std::string(name));
    return all.size() < most_objects ? 0 : 1;
  };
  H5Ovisit(file, H5_INDEX_NAME, H5_ITER_INC, take, &paths);
  std::vector<Found> all;
  for (std::string& path : paths) {
    const Hdf5Handle id(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (id < 0) {
      all.push_back({std::move(path), {}, {}});  // the reader says why
      continue;
    }
    Found found{std::move(path), {}, {}};
    const Hdf5Handle space(H5Dget_space(id), H5Sclose);
    const int rank = H5Sget_simple_extent_ndims(space);
    found.dims.resize(static_cast<std::size_t>(std::max(rank, 0)));
    if (rank > 0) H5Sget_simple_extent_dims(space, found.dims.data(), nullptr);
    const Hdf5Handle type(H5Dget_type(id), H5Tclose);
    if (H5Tget_class(type) == H5T_COMPOUND) {
      for (int i = 0; i < H5Tget_nmembers(type); ++i) {
        char* const member = H5Tget_member_name(type, static_cast<unsigned>(i));
        if (member == nullptr) continue;
        found.members.emplace_back(member);
        H5free_memory(member);
      }
    }
    all.push_back(std::move(found));
  }
  return all;
}

/// An attribute's text, or its numbers as "260 346"; empty where there is none.
std::string attribute(hid_t file, const std::string& object, const char* name) {
  const std::string path = object.empty() ? "/" : object;
  if (H5Aexists_by_name(file, path.c_str(), name, H5P_DEFAULT) <= 0) return {};
  const Hdf5Handle id(H5Aopen_by_name(file, path.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const Hdf5Handle type(H5Aget_type(id), H5Tclose);
  const Hdf5Handle space(H5Aget_space(id), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  constexpr std::size_t longest = 256;
  if (H5Tget_class(type) == H5T_STRING && count == 1) {
    if (H5Tis_variable_str(type) > 0) {
      char* text = nullptr;
      if (H5Aread(id, type, static_cast<void*>(&text)) < 0 || text == nullptr) return {};
      std::string copy(text);
      H5free_memory(text);
      return copy;
    }
    const std::size_t bytes = H5Tget_size(type);
    std::string text(std::min(bytes, longest), '\0');
    if (bytes > longest || H5Aread(id, type, text.data()) < 0) return {};
    return text.substr(0, text.find('\0'));
  }
  if (H5Tget_class(type) != H5T_INTEGER || count < 1 || count > 2) return {};
  std::array<std::int64_t, 2> numbers{};
  if (H5Aread(id, H5T_NATIVE_INT64, numbers.data()) < 0) return {};
  return std::to_string(numbers[0]) + (count == 2 ? " " + std::to_string(numbers[1]) : "");
}

/// The numbers of a small dataset; none where it is something else.
std::vector<std::int64_t> small_numbers(hid_t file, const std::string& path) {
  if (H5Lexists(file, path.c_str(), H5P_DEFAULT) <= 0) return {};
  const Hdf5Handle id(H5Dopen2(file, path.c_str(), H5P_DEFAULT), H5Dclose);
  const Hdf5Handle type(H5Dget_type(id), H5Tclose);
  const Hdf5Handle space(H5Dget_space(id), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  if (H5Tget_class(type) != H5T_INTEGER || count < 1 || count > 2) return {};
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(count));
  if (H5Dread(id, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data()) < 0) return {};
  return numbers;
}

std::optional<ImageSize> size_of(std::int64_t width, std::int64_t height) {
  const auto is_length = [](std::int64_t px) { return px > 0 && px <= largest_length_px; };
  if (!is_length(width) || !is_length(height)) return std::nullopt;
  return ImageSize{static_cast<int>(width), static_cast<int>(height)};
}

/// The size that the file states for the events at `path`, in a group or a dataset.
std::optional<ImageSize> image_size_at(hid_t file, const std::string& path, const std::string& group) {
  const auto width = small_numbers(file, group + "/width"), height = small_numbers(file, group + "/height");
  if (!width.empty() && !height.empty()) return size_of(width[0], height[0]);
  for (const std::string& place : {path, group, std::string()}) {
    // Metavision: geometry "1280x720", or width and height; event_utils: sensor_resolution (height, width).
    if (const auto size = parse_size(attribute(file, place, "geometry")))
      return size_of(size->width, size->height);
    std::int64_t w = 0, h = 0;
    if (parse_number(attribute(file, place, "width"), w) && parse_number(attribute(file, place, "height"), h))
      return size_of(w, h);
    if (const auto pair = size_in_line(attribute(file, place, "sensor_resolution")))
      return size_of(pair->height, pair->width);
  }
  const auto resolution = small_numbers(file, group + "/calib/resolution");  // of M3ED
  return resolution.size() == 2 ? size_of(resolution[0], resolution[1]) : std::nullopt;
}

bool has_all(const std::vector<Hdf5Column>& columns) {
  return std::ranges::all_of(
      std::array{EventColumn::t, EventColumn::x, EventColumn::y, EventColumn::p},
      [&](EventColumn c) { return std::ranges::count(columns, c, &Hdf5Column::column) == 1; });
}

/// Adds the column that `name` is, unless there is one of it already.
void add_named(hid_t file, const std::string& dataset, const std::string& name, const std::string& member,
               std::vector<Hdf5Column>& columns) {
  const auto named = event_column(name);
  if (!named || std::ranges::count(columns, named->column, &Hdf5Column::column) > 0) return;
  std::optional<TimeUnit> unit = named->unit;
  for (const char* const key : {"unit", "units"}) {
    if (!unit && named->column == EventColumn::t) unit = spelled_time_unit(attribute(file, dataset, key));
  }
  columns.push_back({named->column, dataset, member, {}, unit});
}

/// The order of a table's columns; none where nothing says it.
std::optional<std::string> order_of(const std::string& path, const EventReadOptions& options) {
  if (options.columns != EventReadOptions{}.columns) return options.columns;
  if (path == "/events") return "txyp";
  if (path.starts_with("/davis/")) return "xytp";
  return std::nullopt;
}

std::vector<Hdf5Layout> candidates(hid_t file, const std::string& name, const std::vector<Found>& datasets,
                                   const EventReadOptions& options) {
  std::vector<Hdf5Layout> layouts;
  const auto add = [&](const std::string& path, const std::string& group, std::vector<Hdf5Column> columns) {
    Hdf5Layout layout{"events of " + printable(path.empty() ? "/" : path), path, std::move(columns), {}, {}};
    for (const std::string& place : {group + "/t_offset", std::string("/t_offset")}) {
      if (layout.offset.empty() && H5Lexists(file, place.c_str(), H5P_DEFAULT) > 0) layout.offset = place;
    }
    layout.image_size = image_size_at(file, path, group);
    layouts.push_back(std::move(layout));
  };
  std::map<std::string, std::vector<Hdf5Column>> groups;
  for (const Found& found : datasets) {
    if (found.members.empty())
      add_named(file, found.path, name_of(found.path), {}, groups[parent_of(found.path)]);
    std::vector<Hdf5Column> columns;
    for (const std::string& member : found.members) add_named(file, found.path, member, member, columns);
    if (has_all(columns)) add(found.path, parent_of(found.path), std::move(columns));
    if (name_of(found.path) != "events" || !found.members.empty()) continue;
    const auto order = order_of(found.path, options);
    if (found.dims.size() == 2 && !order)
      throw InputError(name, "the table " + in_words(found), "the order of its columns, --columns");
    const std::string letters = order.value_or("txyp");
    if (found.dims.size() == 2 && found.dims[1] != letters.size())
      throw InputError(name, found.path + " of " + std::to_string(found.dims[1]) + " columns",
                       std::to_string(letters.size()) + " columns, " + letters + " (--columns)");
    for (std::size_t i = 0; i < letters.size(); ++i) {
      const auto column = event_column(letters[i] == 'c' ? "camera" : letters.substr(i, 1));
      if (column) columns.push_back({column->column, found.path, {}, i, {}});
    }
    add(found.path, parent_of(found.path), std::move(columns));
    if (found.path == "/events") layouts.back().name = "layout of v2e";
  }
  for (auto& [group, columns] : groups) {
    if (!has_all(columns)) continue;
    const bool is_dsec = group == "/events" && name_of(columns[0].dataset).size() == 1;
    add(group, group, std::move(columns));
    if (is_dsec) layouts.back().name = "layout of DSEC";
  }
  return layouts;
}

}  // namespace

std::vector<Hdf5Layout> hdf5_layouts(hid_t file, const std::string& name, const EventReadOptions& options) {
  const std::vector<Found> datasets = datasets_in(file);
  std::vector<Hdf5Layout> layouts = candidates(file, name, datasets, options);
  const auto main = std::ranges::find(layouts, "/events", &Hdf5Layout::path);
  if (main != layouts.end()) return {*main};
  const auto is_of = [](const char* eye) {
    return [eye](const Hdf5Layout& layout) { return layout.path.find(eye) != std::string::npos; };
  };
  std::stable_partition(layouts.begin(), layouts.end(), is_of("left"));
  const bool is_pair = layouts.size() == 2 && is_of("left")(layouts[0]) && is_of("right")(layouts[1]);
  if (layouts.size() == 1 || is_pair) return layouts;
  std::string text;
  if (layouts.empty()) {
    constexpr std::size_t most_listed = 16;
    for (std::size_t i = 0; i < std::min(most_listed, datasets.size()); ++i)
      text += (i == 0 ? "" : ", ") + in_words(datasets[i]);
    if (datasets.size() > most_listed)
      text += " and " + std::to_string(datasets.size() - most_listed) + " more";
    if (datasets.empty()) text = "no datasets";
  } else {
    for (const Hdf5Layout& layout : layouts) text += (text.empty() ? "" : ", ") + layout.name;
  }
  throw InputError(
      name, text,
      "events of one camera, or of a left and a right one: datasets t, x, y and p in a group (DSEC, M3ED, "
      "event_utils, e2calib), records of them (Metavision), or a table events (v2e, MVSEC)");
}

}  // namespace saccade
