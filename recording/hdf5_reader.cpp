#include "recording/hdf5_reader.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "recording/codec.h"
#include "recording/hdf5_handle.h"

namespace saccade::inline v0_1 {
namespace {

constexpr std::size_t block_events = 1 << 16;
/// A chunk is decompressed as a whole.
constexpr std::size_t largest_chunk_bytes = 256u << 20;
/// Sums of two such times fit into 64 bits.
constexpr std::int64_t largest_time = std::int64_t{1} << 61;

class Hdf5Reader final : public EventReader {
 public:
  Hdf5Reader(const std::filesystem::path& path, const EventReadOptions& options) : name_(path.string()) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    file_ = Hdf5Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
    if (file_ < 0) {
      throw InputError(name_, "what libhdf5 cannot open (" + last_hdf5_error() + ")", "a whole HDF5 file");
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
      if (count == 0) throw;  // otherwise the next call reads the broken place again and throws
    }
    return count;
  }
  std::optional<ImageSize> image_size() const override { return image_size_; }
  std::string format() const override { return is_table_ ? "HDF5, layout of v2e" : "HDF5, layout of DSEC"; }

 private:
  struct Dataset {
    std::string name;
    Hdf5Handle id;
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
    if (exists("/events/camera")) {
      camera_ = open_dataset("/events/camera", 1);
      if (camera_->dims[0] != columns_[0].dims[0]) {
        throw InputError(name_, "/events/camera of " + std::to_string(camera_->dims[0]) + " numbers",
                         "as many as /events/t has, " + std::to_string(columns_[0].dims[0]));
      }
    }
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

  /// With room for one chunk in its cache, so that each is decompressed once.
  Dataset open_dataset(const char* name, int rank) const {
    Dataset dataset;
    dataset.name = name;
    dataset.id = Hdf5Handle(H5Dopen2(file_, name, H5P_DEFAULT), H5Dclose);
    if (dataset.id < 0) fail(name, "what libhdf5 cannot open (" + last_hdf5_error() + ")", "numbers");
    const Hdf5Handle type(H5Dget_type(dataset.id), H5Tclose);
    if (H5Tget_class(type) != H5T_INTEGER) fail(name, "values that are no whole numbers", "whole numbers");
    dataset.bytes = H5Tget_size(type);
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
      double bytes = static_cast<double>(dataset.bytes);
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
    const std::size_t stride = is_table_ ? 4 : 1;
    for (std::size_t i = 0; i < count; ++i, ++next_) {
      const auto value = [&](std::size_t column) {
        return is_table_ ? values_[0][stride * i + column] : values_[column][i];
      };
      const std::int64_t t = value(0), x = value(1), y = value(2), p = value(3);
      const std::int64_t camera = camera_ ? cameras_[i] : 0;
      const bool sound = (camera == 0 || camera == 1) && t <= largest_time && t >= -largest_time && x >= 0 &&
                         x <= 65535 && y >= 0 && y <= 65535 && (p == 0 || p == 1 || p == -1);
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
                        static_cast<std::uint16_t>(y), p == 1, static_cast<std::uint8_t>(camera)});
    }
    return count;
  }

  /// The next `count` rows into values_; false where libhdf5 cannot.
  bool load(std::size_t count) {
    if (is_table_) return load(columns_[0], {next_, 0}, {count, 4}, values_[0]);
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (!load(columns_[i], {next_}, {count}, values_[i])) return false;
    }
    return !camera_ || load(*camera_, {next_}, {count}, cameras_);
  }

  bool load(const Dataset& dataset, const std::vector<hsize_t>& start, const std::vector<hsize_t>& count,
            std::vector<std::int64_t>& values) {
    std::size_t numbers = 1;
    for (const hsize_t n : count) numbers *= static_cast<std::size_t>(n);
    values.resize(numbers);
    const Hdf5Handle in_file(H5Dget_space(dataset.id), H5Sclose);
    const Hdf5Handle in_memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                               H5Sclose);
    if (H5Sselect_hyperslab(in_file, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) >= 0 &&
        H5Dread(dataset.id, H5T_NATIVE_INT64, in_memory, in_file, H5P_DEFAULT, values.data()) >= 0) {
      return true;
    }
    reason_ = last_hdf5_error();
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
  Hdf5Handle file_;
  bool is_table_ = false;
  std::array<Dataset, 4> columns_;  ///< t, x, y, p; of a table the first alone
  std::array<std::vector<std::int64_t>, 4> values_;
  std::optional<Dataset> camera_;  ///< where there are two
  std::vector<std::int64_t> cameras_;
  std::size_t length_ = 0;
  std::size_t next_ = 0;
  std::int64_t offset_us_ = 0;
  std::int64_t wraps_us_ = 0;
  std::int64_t last_t_ = 0;
  std::optional<ImageSize> image_size_;
  std::string reason_;  ///< of the last load() that failed
};

}  // namespace

std::unique_ptr<EventReader> open_hdf5_here(const std::filesystem::path& path,
                                            const EventReadOptions& options) {
  return std::make_unique<Hdf5Reader>(path, options);
}

}  // namespace saccade::inline v0_1
