#include "recording/hdf5_codec.h"

#include <hdf5.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/error.h"
#include "recording/child_reader.h"
#include "recording/codec.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

constexpr std::size_t block_events = 1 << 16;
/// A chunk is unpacked as a whole.
constexpr std::size_t largest_chunk_bytes = 256u << 20;
/// Sums of two such times have room in 64 bits.
constexpr std::int64_t largest_time = std::int64_t{1} << 61;

/// One of libhdf5's identifiers and how it is closed.
class Handle {
 public:
  Handle() = default;
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  operator hid_t() const { return id_; }

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

/// What libhdf5 says of its last failure: the innermost cause.
std::string last_error() {
  std::string text;
  const auto take = [](unsigned, const H5E_error2_t* error, void* to) -> herr_t {
    if (error->desc != nullptr) *static_cast<std::string*>(to) = error->desc;
    return 0;
  };
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, take, &text);
  return printable(text);
}

// ---- reading -------------------------------------------------------------------------------------

class Hdf5Reader final : public EventReader {
 public:
  Hdf5Reader(const std::filesystem::path& path, const EventReadOptions& options) : name_(path.string()) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    file_ = Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (file_ < 0) {
      throw InputError(name_, "what libhdf5 cannot open (" + last_error() + ")", "a whole HDF5 file");
    }
    if (!exists("/events")) fail_of_layout("no /events");
    H5O_info_t info;
    if (H5Oget_info_by_name(file_, "/events", &info, H5P_DEFAULT) < 0) fail_of_layout("no readable /events");
    if (info.type == H5O_TYPE_GROUP) {
      open_columns();
    } else if (info.type == H5O_TYPE_DATASET) {
      open_table();
    } else {
      fail_of_layout("/events that is neither a group nor a table");
    }
    if (!image_size_) image_size_ = options.image_size;
  }

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t count = 0;
    try {
      while (count < max_events && next_ < length_) {
        count += read_block(events, std::min({max_events - count, block_events, length_ - next_}));
      }
    } catch (const InputError&) {
      if (count == 0) throw;  // else what is broken is met again, and told, by the next call
    }
    return count;
  }
  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override { return is_table_ ? "HDF5, layout of v2e" : "HDF5, layout of DSEC"; }

 private:
  struct Dataset {
    std::string name;
    Handle id;
    std::vector<hsize_t> dims;
    std::size_t bytes = 0;  ///< of a number
  };

  void open_columns() {
    constexpr std::array<const char*, 4> names = {"/events/t", "/events/x", "/events/y", "/events/p"};
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (!exists(names[i])) fail_of_layout("/events without " + std::string(names[i]).substr(8));
      columns_[i] = open_dataset(names[i], 1);
      if (columns_[i].dims[0] != columns_[0].dims[0]) {
        throw InputError(name_, names[i] + (" of " + std::to_string(columns_[i].dims[0])) + " numbers",
                         "as many as /events/t has, " + std::to_string(columns_[0].dims[0]));
      }
    }
    length_ = static_cast<std::size_t>(columns_[0].dims[0]);
    if (exists("/t_offset")) offset_us_ = scalar("/t_offset", largest_time);
    if (exists("/events/width") && exists("/events/height")) {
      image_size_ = ImageSize{static_cast<int>(scalar("/events/width", 65536)),
                              static_cast<int>(scalar("/events/height", 65536))};
    }
  }

  void open_table() {
    is_table_ = true;
    columns_[0] = open_dataset("/events", 2);
    if (columns_[0].dims[1] != 4) {
      throw InputError(name_, "/events of " + std::to_string(columns_[0].dims[1]) + " columns",
                       "4 columns: t, x, y, p");
    }
    length_ = static_cast<std::size_t>(columns_[0].dims[0]);
  }

  bool exists(const char* link) const { return H5Lexists(file_, link, H5P_DEFAULT) > 0; }

  /// With room for one chunk in its cache, so that each is unpacked once.
  Dataset open_dataset(const char* name, int rank) const {
    Dataset dataset;
    dataset.name = name;
    dataset.id = Handle(H5Dopen2(file_, name, H5P_DEFAULT), H5Dclose);
    if (dataset.id < 0) fail(name, "what libhdf5 cannot open (" + last_error() + ")", "numbers");
    const Handle type(H5Dget_type(dataset.id), H5Tclose);
    if (H5Tget_class(type) != H5T_INTEGER) fail(name, "values that are no whole numbers", "whole numbers");
    dataset.bytes = H5Tget_size(type);
    const Handle space(H5Dget_space(dataset.id), H5Sclose);
    const int dims = H5Sget_simple_extent_ndims(space);
    if (dims != rank) {
      fail(name, std::to_string(dims) + " dimensions",
           std::to_string(rank) + (rank == 1 ? " dimension" : " dimensions"));
    }
    dataset.dims.resize(static_cast<std::size_t>(rank));
    if (rank > 0) H5Sget_simple_extent_dims(space, dataset.dims.data(), nullptr);

    const Handle plist(H5Dget_create_plist(dataset.id), H5Pclose);
    check_filters(plist, name);
    if (H5Pget_layout(plist) == H5D_CHUNKED) {
      std::array<hsize_t, H5S_MAX_RANK> chunk{};
      const int chunk_rank = H5Pget_chunk(plist, H5S_MAX_RANK, chunk.data());
      double bytes = static_cast<double>(dataset.bytes);
      for (int i = 0; i < chunk_rank; ++i) bytes *= static_cast<double>(chunk[static_cast<std::size_t>(i)]);
      if (bytes > static_cast<double>(largest_chunk_bytes)) {
        fail(name, "chunks of more than 256 MiB", "chunks of at most 256 MiB");
      }
      const Handle access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
      H5Pset_chunk_cache(access, 521, std::max<std::size_t>(1 << 20, static_cast<std::size_t>(bytes)), 1.0);
      dataset.id = Handle();
      dataset.id = Handle(H5Dopen2(file_, name, access), H5Dclose);
      if (dataset.id < 0) fail(name, "what libhdf5 cannot open (" + last_error() + ")", "numbers");
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
      fail(name,
           "compression by the HDF5 filter " + std::to_string(id) + " " +
               (id == blosc ? "(Blosc)" : "(" + printable(filter.data()) + ")"),
           std::string("gzip, or the filter's plugin for libhdf5 in HDF5_PLUGIN_PATH") +
               (id == blosc
                    ? ": the package hdf5-filter-plugin-blosc-serial has it; with it, h5repack -f GZIP=4 "
                      "makes a copy that needs none"
                    : ""));
    }
  }

  std::int64_t scalar(const char* name, std::int64_t largest) const {
    const Handle id(H5Dopen2(file_, name, H5P_DEFAULT), H5Dclose);
    const Handle type(H5Dget_type(id), H5Tclose);
    const Handle space(H5Dget_space(id), H5Sclose);
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
    const std::size_t stride = is_table_ ? 4 : 1;
    for (std::size_t i = 0; i < count; ++i, ++next_) {
      const auto value = [&](std::size_t column) {
        return is_table_ ? values_[0][stride * i + column] : values_[column][i];
      };
      const std::int64_t t = value(0), x = value(1), y = value(2), p = value(3);
      const bool sound = t <= largest_time && t >= -largest_time && x >= 0 && x <= 65535 && y >= 0 &&
                         y <= 65535 && (p == 0 || p == 1 || p == -1);
      if (!sound && i > 0) return i;
      if (!sound) {
        throw InputError(place(),
                         "t " + std::to_string(t) + ", x " + std::to_string(x) + ", y " + std::to_string(y) +
                             ", p " + std::to_string(p),
                         "x and y of 0 to 65535 and p of 0 or 1, or -1 or 1");
      }
      constexpr std::int64_t half = std::int64_t{1} << 31;
      if (columns_[0].bytes == 4 && t < last_t_ - half) wraps_us_ += 2 * half;
      if (columns_[0].bytes == 4 && t > last_t_ + half && wraps_us_ > 0) wraps_us_ -= 2 * half;
      last_t_ = t;
      events.push_back({offset_us_ + wraps_us_ + t, static_cast<std::uint16_t>(x),
                        static_cast<std::uint16_t>(y), p == 1, 0});
    }
    return count;
  }

  /// The next `count` rows into values_; false where libhdf5 cannot.
  bool load(std::size_t count) {
    if (is_table_) return load(columns_[0], {next_, 0}, {count, 4}, values_[0]);
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (!load(columns_[i], {next_}, {count}, values_[i])) return false;
    }
    return true;
  }

  bool load(const Dataset& dataset, const std::vector<hsize_t>& start, const std::vector<hsize_t>& count,
            std::vector<std::int64_t>& values) {
    std::size_t numbers = 1;
    for (const hsize_t n : count) numbers *= static_cast<std::size_t>(n);
    values.resize(numbers);
    const Handle in_file(H5Dget_space(dataset.id), H5Sclose);
    const Handle in_memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
    if (H5Sselect_hyperslab(in_file, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) >= 0 &&
        H5Dread(dataset.id, H5T_NATIVE_INT64, in_memory, in_file, H5P_DEFAULT, values.data()) >= 0) {
      return true;
    }
    reason_ = last_error();
    return false;
  }

  [[nodiscard]] std::string place() const { return name_ + ": event " + std::to_string(next_); }
  [[noreturn]] void fail(const char* dataset, std::string value, std::string expectation) const {
    throw InputError(name_ + ": " + dataset, std::move(value), std::move(expectation));
  }
  [[noreturn]] void fail_of_layout(std::string value) const {
    throw InputError(name_, std::move(value),
                     "the layout of DSEC (/events/t, x, y, p) or of v2e (/events, N x 4)");
  }

  std::string name_;
  Handle file_;
  bool is_table_ = false;
  std::array<Dataset, 4> columns_;  ///< t, x, y, p; of a table the first alone
  std::array<std::vector<std::int64_t>, 4> values_;
  std::size_t length_ = 0;
  std::size_t next_ = 0;
  std::int64_t offset_us_ = 0;
  std::int64_t wraps_us_ = 0;
  std::int64_t last_t_ = 0;
  std::optional<ImageSize> image_size_;
  std::string reason_;  ///< of the last load() that failed
};

// ---- writing -------------------------------------------------------------------------------------

/// A dataset of one dimension that grows.
template <class T>
class Column {
 public:
  Column(hid_t parent, const char* name, hid_t in_file, hid_t in_memory) : in_memory_(in_memory) {
    const hsize_t none = 0, unlimited = H5S_UNLIMITED, chunk = block_events;
    const Handle space(H5Screate_simple(1, &none, &unlimited), H5Sclose);
    const Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    H5Pset_chunk(plist, 1, &chunk);
    H5Pset_shuffle(plist);
    H5Pset_deflate(plist, 4);
    id_ = Handle(H5Dcreate2(parent, name, in_file, space, H5P_DEFAULT, plist, H5P_DEFAULT), H5Dclose);
    values_.reserve(block_events);
  }

  /// False where libhdf5 cannot.
  [[nodiscard]] bool push(T value) {
    values_.push_back(value);
    return values_.size() < block_events || flush();
  }
  [[nodiscard]] bool flush() {
    const hsize_t count = values_.size(), whole = length_ + count;
    if (count == 0) return id_ >= 0;
    if (H5Dset_extent(id_, &whole) < 0) return false;
    const Handle in_file(H5Dget_space(id_), H5Sclose);
    const Handle in_memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
    H5Sselect_hyperslab(in_file, H5S_SELECT_SET, &length_, nullptr, &count, nullptr);
    if (H5Dwrite(id_, in_memory_, in_memory, in_file, H5P_DEFAULT, values_.data()) < 0) return false;
    length_ = whole;
    values_.clear();
    return true;
  }
  [[nodiscard]] hsize_t size() const { return length_ + values_.size(); }

 private:
  Handle id_;
  hid_t in_memory_;
  hsize_t length_ = 0;
  std::vector<T> values_;
};

class Hdf5Writer final : public EventWriter {
 public:
  Hdf5Writer(const std::filesystem::path& path, ImageSize size) : out_(path), size_(size) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    file_ = Handle(H5Fcreate(out_.part().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
    const Handle group(H5Gcreate2(file_, "/events", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    check(group >= 0);
    x_.emplace(group, "x", H5T_STD_U16LE, H5T_NATIVE_UINT16);
    y_.emplace(group, "y", H5T_STD_U16LE, H5T_NATIVE_UINT16);
    t_.emplace(group, "t", H5T_STD_U32LE, H5T_NATIVE_UINT32);
    p_.emplace(group, "p", H5T_STD_U8LE, H5T_NATIVE_UINT8);
    ms_to_idx_.emplace(file_, "ms_to_idx", H5T_STD_U64LE, H5T_NATIVE_UINT64);
    write_scalar("/events/width", size.width);
    write_scalar("/events/height", size.height);
  }

  void write(std::span<const Event> events) override {
    for (const Event& event : events) {
      check_writable(event, size_, 1, out_.path());
      if (!first_us_) first_us_ = last_us_ = event.t_us;
      const std::int64_t t = event.t_us - *first_us_;
      if (event.t_us < last_us_ || t > std::int64_t{0xffffffff}) {
        throw InputError(out_.path().string(), "an event at " + std::to_string(event.t_us) + " us",
                         "events sorted by time, within 2^32 us of the first one, at " +
                             std::to_string(*first_us_) + " us");
      }
      last_us_ = event.t_us;
      bool ok = true;
      for (std::int64_t ms = static_cast<std::int64_t>(ms_to_idx_->size()); ms * 1000 <= t; ++ms) {
        ok = ok && ms_to_idx_->push(t_->size());
      }
      ok = ok && x_->push(event.x) && y_->push(event.y) && t_->push(static_cast<std::uint32_t>(t)) &&
           p_->push(event.on ? 1 : 0);
      check(ok);
    }
  }

  void commit() override {
    check(ms_to_idx_->push(t_->size()));
    check(x_->flush() && y_->flush() && t_->flush() && p_->flush() && ms_to_idx_->flush());
    write_scalar("/t_offset", first_us_.value_or(0));
    close_columns();
    check(H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0);
    file_ = Handle();
    out_.commit();
  }

 private:
  void write_scalar(const char* name, std::int64_t value) {
    const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle id(H5Dcreate2(file_, name, H5T_STD_I64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                    H5Dclose);
    check(H5Dwrite(id, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value) >= 0);
  }

  void close_columns() {
    x_.reset();
    y_.reset();
    t_.reset();
    p_.reset();
    ms_to_idx_.reset();
  }

  void check(bool ok) const {
    if (!ok) throw RunError(out_.path().string() + ": cannot be written: libhdf5: " + last_error());
  }

  OutputFile out_;
  ImageSize size_;
  Handle file_;
  std::optional<Column<std::uint16_t>> x_, y_;
  std::optional<Column<std::uint32_t>> t_;
  std::optional<Column<std::uint8_t>> p_;
  std::optional<Column<std::uint64_t>> ms_to_idx_;
  std::optional<std::int64_t> first_us_;
  std::int64_t last_us_ = 0;
};

}  // namespace

std::unique_ptr<EventReader> open_hdf5(const std::filesystem::path& path, const EventReadOptions& options) {
  return open_in_child(path.string(), "libhdf5", [&] { return std::make_unique<Hdf5Reader>(path, options); });
}

std::unique_ptr<EventWriter> create_hdf5(const std::filesystem::path& path, ImageSize image_size,
                                         int cameras) {
  if (cameras > 1) {
    throw InputError(path.string(), "two cameras", "one camera in DSEC's layout, or a .csv file");
  }
  return std::make_unique<Hdf5Writer>(path, image_size);
}

}  // namespace saccade
