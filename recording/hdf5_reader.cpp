#include "recording/hdf5_reader.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "recording/codec.h"
#include "recording/hdf5_handle.h"
#include "recording/hdf5_layout.h"
#include "recording/number_text.h"
#include "recording/two_cameras.h"

namespace saccade {
namespace {

constexpr std::size_t block_events = 1 << 16;
/// A chunk is decompressed as a whole.
constexpr std::size_t largest_chunk_bytes = 256u << 20;
/// Sums of two such times fit into 64 bits.
constexpr std::int64_t largest_time = std::int64_t{1} << 61;

class Hdf5Reader final : public EventReader {
 public:
  Hdf5Reader(const std::filesystem::path& path, Hdf5Layout layout, const EventReadOptions& options)
      : name_(path.string()),
        layout_(std::move(layout)),
        file_(H5Fopen(name_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose) {
    image_size_ = layout_.image_size ? layout_.image_size : options.image_size;
    for (const Hdf5Column& column : layout_.columns) open_column(column);
    for (const Part& part : parts_) {
      const std::string at_name = dataset_of(EventColumn::t).name;
      if (part.dims[0] != dataset_of(EventColumn::t).dims[0])
        throw InputError(
            name_, part.name + " of " + std::to_string(part.dims[0]) + " numbers",
            "as many as " + at_name + " has, " + std::to_string(dataset_of(EventColumn::t).dims[0]));
    }
    length_ = static_cast<std::size_t>(parts_.front().dims[0]);
    if (!layout_.offset.empty()) offset_us_ = scalar(layout_.offset.c_str(), largest_time);
    const auto named = std::ranges::find(layout_.columns, EventColumn::t, &Hdf5Column::column)->unit;
    const std::optional<TimeUnit> stated = options.time_unit ? options.time_unit : named;
    const bool real = cell(EventColumn::t).real;
    unit_ = stated.value_or(real ? TimeUnit::s : TimeUnit::us);
    // The layout with an offset is DSEC's, in us.
    may_be_implausible_ = stated || (!layout_.offset.empty() && !real);
    if (!stated && real) check_times();
  }

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t count = 0;
    try {
      while (count < max_events && next_ < length_) {
        count += read_block(events, std::min({max_events - count, block_events, length_ - next_}));
      }
    } catch (const InputError&) {
      if (count == 0) throw;  // otherwise the next call reads the broken place again and throws
    }
    return count;
  }
  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override { return "HDF5, " + layout_.name; }

 private:
  /// A dataset, and what is read of each of its rows: cells of 8 bytes, whole numbers or doubles.
  struct Part {
    std::string name;
    Hdf5Handle id;
    Hdf5Handle memory_type;
    std::vector<hsize_t> dims;
    std::size_t cells = 1;
    std::vector<std::int64_t> values;
  };
  /// Where a column's numbers are.
  struct Cell {
    std::optional<std::size_t> part;  ///< none: the file has no such column
    std::size_t place = 0;            ///< in the cells of a row
    bool real = false;
    std::size_t bytes = 8;  ///< in the file
  };

  [[nodiscard]] const Cell& cell(EventColumn column) const {
    return cells_[static_cast<std::size_t>(column)];
  }
  [[nodiscard]] const Part& dataset_of(EventColumn column) const { return parts_[*cell(column).part]; }

  void open_column(const Hdf5Column& column) {
    Cell& at = cells_[static_cast<std::size_t>(column.column)];
    const auto known = std::ranges::find(parts_, column.dataset, &Part::name);
    at.part = static_cast<std::size_t>(known - parts_.begin());
    if (known == parts_.end()) parts_.push_back(open_dataset(column.dataset.c_str(), column.place ? 2 : 1));
    Part& part = parts_[*at.part];
    const Hdf5Handle type(H5Dget_type(part.id), H5Tclose);
    Hdf5Handle number;
    if (!column.member.empty()) {
      const int index = H5Tget_member_index(type, column.member.c_str());
      number = Hdf5Handle(H5Tget_member_type(type, static_cast<unsigned>(std::max(index, 0))), H5Tclose);
    }
    const hid_t stored = column.member.empty() ? static_cast<hid_t>(type) : static_cast<hid_t>(number);
    const H5T_class_t kind = H5Tget_class(stored);
    // NumPy's bool is an enumeration.
    if (kind != H5T_INTEGER && kind != H5T_FLOAT && kind != H5T_ENUM)
      fail(column.dataset.c_str(), "values that are no numbers", "whole or floating-point numbers");
    at.real = kind == H5T_FLOAT;
    at.bytes = H5Tget_size(stored);
    const hid_t in_memory = at.real ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64;
    if (column.member.empty()) {
      at.place = static_cast<std::size_t>(column.place.value_or(0));
      part.cells = column.place ? static_cast<std::size_t>(part.dims[1]) : 1;
      part.memory_type = Hdf5Handle(H5Tcopy(in_memory), H5Tclose);
      return;
    }
    at.place = part.memory_type < 0 ? 0 : part.cells;
    part.cells = at.place + 1;
    Hdf5Handle record(H5Tcreate(H5T_COMPOUND, part.cells * sizeof(std::int64_t)), H5Tclose);
    for (const Hdf5Column& other : layout_.columns) {
      const Cell& added = cell(other.column);
      if (other.dataset != column.dataset || added.part != at.part || added.place > at.place) continue;
      H5Tinsert(record, other.member.c_str(), added.place * sizeof(std::int64_t),
                added.real ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT64);
    }
    part.memory_type = std::move(record);
  }

  /// With room for one chunk in its cache, so that each is decompressed once.
  Part open_dataset(const char* name, int rank) const {
    Part dataset;
    dataset.name = name;
    dataset.id = Hdf5Handle(H5Dopen2(file_, name, H5P_DEFAULT), H5Dclose);
    if (dataset.id < 0) fail(name, "what libhdf5 cannot open (" + last_hdf5_error() + ")", "numbers");
    const Hdf5Handle type(H5Dget_type(dataset.id), H5Tclose);
    const Hdf5Handle space(H5Dget_space(dataset.id), H5Sclose);
    const int dims = H5Sget_simple_extent_ndims(space);
    if (dims != rank) {
      fail(name, std::to_string(dims) + " dimensions",
           std::to_string(rank) + (rank == 1 ? " dimension" : " dimensions"));
    }
    dataset.dims.resize(static_cast<std::size_t>(rank));
    if (rank > 0) H5Sget_simple_extent_dims(space, dataset.dims.data(), nullptr);

    const Hdf5Handle plist(H5Dget_create_plist(dataset.id), H5Pclose);
    check_filters(plist, name);
    if (H5Pget_layout(plist) == H5D_CHUNKED) {
      std::array<hsize_t, H5S_MAX_RANK> chunk{};
      const int chunk_rank = H5Pget_chunk(plist, H5S_MAX_RANK, chunk.data());
      double bytes = static_cast<double>(H5Tget_size(type));
      for (int i = 0; i < chunk_rank; ++i) bytes *= static_cast<double>(chunk[static_cast<std::size_t>(i)]);
      if (bytes > static_cast<double>(largest_chunk_bytes)) {
        fail(name, "chunks of more than 256 MiB", "chunks of at most 256 MiB");
      }
      const Hdf5Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
      H5Pset_chunk_cache(access, 521, std::max<std::size_t>(1 << 20, static_cast<std::size_t>(bytes)), 1.0);
      dataset.id = Hdf5Handle();
      dataset.id = Hdf5Handle(H5Dopen2(file_, name, access), H5Dclose);
      if (dataset.id < 0) fail(name, "what libhdf5 cannot open (" + last_hdf5_error() + ")", "numbers");
    }
    return dataset;
  }

  void check_filters(hid_t plist, const char* name) const {
    const int filters = H5Pget_nfilters(plist);
    for (int i = 0; i < filters; ++i) {
      std::array<char, 64> filter{};
      std::size_t no_values = 0;
      const H5Z_filter_t id = H5Pget_filter2(plist, static_cast<unsigned>(i), nullptr, &no_values, nullptr,
                                             filter.size() - 1, filter.data(), nullptr);
      if (id >= 0 && H5Zfilter_avail(id) > 0) continue;
      constexpr H5Z_filter_t blosc = 32001;
      constexpr H5Z_filter_t ecf = 0x8ecf;
      fail(name,
           "compression by the HDF5 filter " + std::to_string(id) + " " +
               (id == blosc ? "(Blosc)"
                : id == ecf ? "(Metavision's ECF)"
                            : "(" + printable(filter.data()) + ")"),
           std::string("gzip, or the filter's plugin for libhdf5 in HDF5_PLUGIN_PATH") +
               (id == blosc
                    ? ": the package hdf5-filter-plugin-blosc-serial has it; with it, h5repack -f GZIP=4 "
                      "makes a copy that needs none"
                    : ""));
    }
  }

  std::int64_t scalar(const char* name, std::int64_t largest) const {
    const Hdf5Handle id(H5Dopen2(file_, name, H5P_DEFAULT), H5Dclose);
    const Hdf5Handle type(H5Dget_type(id), H5Tclose);
    const Hdf5Handle space(H5Dget_space(id), H5Sclose);
    std::int64_t value = 0;
    if (H5Tget_class(type) != H5T_INTEGER || H5Sget_simple_extent_npoints(space) != 1 ||
        H5Dread(id, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value) < 0) {
      fail(name, "no readable number", "one whole number");
    }
    if (value > largest || value < -largest) {
      fail(name, std::to_string(value), "at most " + std::to_string(largest));
    }
    return value;
  }

  /// Appends up to `count` events; none only by throwing.
  std::size_t read_block(std::vector<Event>& events, std::size_t count) {
    // Where a chunk is broken, fewer and fewer at once until only it is left.
    while (!load(count)) {
      if (count == 1) {
        throw InputError(place(), "what libhdf5 cannot read (" + reason_ + ")", "events");
      }
      count = (count + 1) / 2;
    }
    for (std::size_t i = 0; i < count; ++i, ++next_) {
      const std::optional<std::int64_t> t = time_us(i);
      const std::int64_t x = whole(EventColumn::x, i), y = whole(EventColumn::y, i);
      const std::int64_t p = whole(EventColumn::p, i);
      const std::int64_t camera = cell(EventColumn::camera).part ? whole(EventColumn::camera, i) : 0;
      const bool plausible = may_be_implausible_ || !t || std::abs(*t) <= longest_plausible_us;
      const bool sound = t && plausible && (camera == 0 || camera == 1) && x >= 0 && x <= 65535 && y >= 0 &&
                         y <= 65535 && (p == 0 || p == 1 || p == -1);
      if (!sound && i > 0) return i;
      if (!plausible)
        throw InputError(place(), "t " + text_at(EventColumn::t, i), std::string(unit_expectation));
      if (!sound) {
        throw InputError(place(),
                         "t " + text_at(EventColumn::t, i) + ", x " + text_at(EventColumn::x, i) + ", y " +
                             text_at(EventColumn::y, i) + ", p " + text_at(EventColumn::p, i),
                         "whole x and y of 0 to 65535, p of 0 or 1, or -1 or 1, and times within 2^61 us");
      }
      events.push_back({offset_us_ + *t, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), p == 1,
                        static_cast<std::uint8_t>(camera)});
    }
    return count;
  }

  [[nodiscard]] std::int64_t raw(EventColumn column, std::size_t row) const {
    const Cell& at = cell(column);
    const Part& part = parts_[*at.part];
    return part.values[row * part.cells + at.place];
  }
  /// A number that must be whole; one that is not is out of every range.
  [[nodiscard]] std::int64_t whole(EventColumn column, std::size_t row) const {
    constexpr std::int64_t no_number = std::numeric_limits<std::int64_t>::min();
    if (!cell(column).real) return raw(column, row);
    const double real = std::bit_cast<double>(raw(column, row));
    return real == std::round(real) && std::abs(real) < 1e6 ? static_cast<std::int64_t>(real) : no_number;
  }
  [[nodiscard]] std::string text_at(EventColumn column, std::size_t row) const {
    std::string text;
    if (cell(column).real) {
      append_number(text, std::bit_cast<double>(raw(column, row)));
    } else {
      append_number(text, raw(column, row));
    }
    return text;
  }

  /// Of a row in memory; none where it is not within 2^61 us. Times of 32 bits are continued over their wraps.
  std::optional<std::int64_t> time_us(std::size_t row) {
    std::optional<std::int64_t> t_us;
    if (cell(EventColumn::t).real) {
      t_us = to_us(std::bit_cast<double>(raw(EventColumn::t, row)), unit_);
    } else {
      const std::int64_t t = raw(EventColumn::t, row);
      constexpr std::int64_t half = std::int64_t{1} << 31;
      if (cell(EventColumn::t).bytes == 4) {
        if (t < last_t_ - half) wraps_ += 2 * half;
        if (t > last_t_ + half && wraps_ > 0) wraps_ -= 2 * half;
        last_t_ = t;
      }
      t_us = t > largest_time || t < -largest_time ? std::nullopt : to_us(t + wraps_, unit_);
    }
    return t_us && *t_us <= largest_time && *t_us >= -largest_time ? t_us : std::nullopt;
  }

  /// Throws where floating-point times without a unit are hardly s.
  void check_times() {
    if (length_ == 0 || !load(std::min<std::size_t>(length_, 4096))) return;  // the first read() says why
    std::vector<double> times;
    for (std::size_t i = 0; i < std::min<std::size_t>(length_, 4096); ++i)
      times.push_back(std::bit_cast<double>(raw(EventColumn::t, i)));
    const std::string why = why_not_seconds(times);
    if (!why.empty())
      throw InputError(name_ + ": " + dataset_of(EventColumn::t).name, why, std::string(unit_expectation));
  }

  /// The next `count` rows into the parts' values; false where libhdf5 cannot.
  bool load(std::size_t count) {
    return std::ranges::all_of(parts_, [&](Part& part) { return load(part, count); });
  }

  bool load(Part& part, std::size_t count) {
    const bool is_table = part.dims.size() == 2;
    std::vector<hsize_t> start = {next_}, rows = {count};
    if (is_table) start.push_back(0);
    if (is_table) rows.push_back(part.dims[1]);
    part.values.resize(count * part.cells);
    const Hdf5Handle in_file(H5Dget_space(part.id), H5Sclose);
    const Hdf5Handle in_memory(H5Screate_simple(static_cast<int>(rows.size()), rows.data(), nullptr),
                               H5Sclose);
    if (H5Sselect_hyperslab(in_file, H5S_SELECT_SET, start.data(), nullptr, rows.data(), nullptr) >= 0 &&
        H5Dread(part.id, part.memory_type, in_memory, in_file, H5P_DEFAULT, part.values.data()) >= 0) {
      return true;
    }
    reason_ = last_hdf5_error();
    return false;
  }

  [[nodiscard]] std::string place() const { return name_ + ": event " + std::to_string(next_); }
  [[noreturn]] void fail(const char* dataset, std::string value, std::string expectation) const {
    throw InputError(name_ + ": " + dataset, std::move(value), std::move(expectation));
  }

  std::string name_;
  Hdf5Layout layout_;
  Hdf5Handle file_;
  std::vector<Part> parts_;
  std::array<Cell, event_columns> cells_;
  std::size_t length_ = 0;
  std::size_t next_ = 0;
  TimeUnit unit_ = TimeUnit::us;
  bool may_be_implausible_ = false;  ///< times may lie anywhere: their unit is stated
  std::int64_t offset_us_ = 0;
  std::int64_t wraps_ = 0;
  std::int64_t last_t_ = 0;
  std::optional<ImageSize> image_size_;
  std::string reason_;  ///< of the last load() that failed
};

}  // namespace

std::unique_ptr<EventReader> open_hdf5_here(const std::filesystem::path& path,
                                            const EventReadOptions& options) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (file < 0) {
    throw InputError(path.string(), "what libhdf5 cannot open (" + last_hdf5_error() + ")",
                     "a whole HDF5 file");
  }
  std::vector<std::unique_ptr<EventReader>> readers;
  for (Hdf5Layout& layout : hdf5_layouts(file, path.string(), options))
    readers.push_back(std::make_unique<Hdf5Reader>(path, std::move(layout), options));
  if (readers.size() == 1) return std::move(readers[0]);
  return merge_cameras(std::move(readers[0]), std::move(readers[1]));
}

}  // namespace saccade
