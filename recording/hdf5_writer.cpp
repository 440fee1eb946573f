// saccade-hdf5-writer.so: what writes with libhdf5.
#include "recording/hdf5_library.h"

#include <algorithm>
#include <array>
#include <optional>

#include "core/error.h"
#include "recording/codec.h"
#include "recording/hdf5_handle.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

constexpr std::size_t chunk_events = 1 << 16;

/// Properties of a new dataset. Without the time at which it is made, the same contents are the same bytes.
Hdf5Handle dataset_properties() {
  Hdf5Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(plist, false);
  return plist;
}

/// A dataset of one dimension that grows.
template <class T>
class Column {
 public:
  Column(hid_t parent, const char* name, hid_t in_file, hid_t in_memory) : in_memory_(in_memory) {
    const hsize_t none = 0, unlimited = H5S_UNLIMITED, chunk = chunk_events;
    const Hdf5Handle space(H5Screate_simple(1, &none, &unlimited), H5Sclose);
    const Hdf5Handle plist = dataset_properties();
    H5Pset_chunk(plist, 1, &chunk);
    H5Pset_shuffle(plist);
    H5Pset_deflate(plist, 4);
    id_ = Hdf5Handle(H5Dcreate2(parent, name, in_file, space, H5P_DEFAULT, plist, H5P_DEFAULT), H5Dclose);
    values_.reserve(chunk_events);
  }

  /// False where libhdf5 cannot.
  [[nodiscard]] bool push(T value) {
    values_.push_back(value);
    return values_.size() < chunk_events || flush();
  }
  [[nodiscard]] bool flush() {
    const hsize_t count = values_.size(), whole = length_ + count;
    if (count == 0) return id_ >= 0;
    if (H5Dset_extent(id_, &whole) < 0) return false;
    const Hdf5Handle in_file(H5Dget_space(id_), H5Sclose);
    const Hdf5Handle in_memory(H5Screate_simple(1, &count, nullptr), H5Sclose);
    H5Sselect_hyperslab(in_file, H5S_SELECT_SET, &length_, nullptr, &count, nullptr);
    if (H5Dwrite(id_, in_memory_, in_memory, in_file, H5P_DEFAULT, values_.data()) < 0) return false;
    length_ = whole;
    values_.clear();
    return true;
  }
  [[nodiscard]] hsize_t size() const { return length_ + values_.size(); }

 private:
  Hdf5Handle id_;
  hid_t in_memory_;
  hsize_t length_ = 0;
  std::vector<T> values_;
};

class Hdf5Writer final : public EventWriter {
 public:
  Hdf5Writer(const std::filesystem::path& path, ImageSize size, int cameras)
      : out_(path), size_(size), cameras_(cameras) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    file_ = Hdf5Handle(H5Fcreate(out_.part().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
    const Hdf5Handle group(H5Gcreate2(file_, "/events", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
    check(group >= 0);
    x_.emplace(group, "x", H5T_STD_U16LE, H5T_NATIVE_UINT16);
    y_.emplace(group, "y", H5T_STD_U16LE, H5T_NATIVE_UINT16);
    t_.emplace(group, "t", H5T_STD_U32LE, H5T_NATIVE_UINT32);
    p_.emplace(group, "p", H5T_STD_U8LE, H5T_NATIVE_UINT8);
    if (cameras_ == 2) camera_.emplace(group, "camera", H5T_STD_U8LE, H5T_NATIVE_UINT8);
    ms_to_idx_.emplace(file_, "ms_to_idx", H5T_STD_U64LE, H5T_NATIVE_UINT64);
    write_scalar("/events/width", size.width);
    write_scalar("/events/height", size.height);
  }

  void write(std::span<const Event> events) override {
    for (const Event& event : events) {
      check_writable(event, size_, cameras_, out_.path());
      if (!first_us_) first_us_ = last_us_ = event.t_us;
      const bool in_range = event.t_us >= -largest_offset_us && event.t_us <= largest_offset_us;
      const std::int64_t t = in_range ? event.t_us - *first_us_ : 0;
      if (!in_range || event.t_us < last_us_ || t > std::int64_t{0xffffffff}) {
        throw InputError(out_.path().string(), "an event at " + std::to_string(event.t_us) + " us",
                         "events sorted by time, within 2^61 us of 0 and 2^32 us of the first one, at " +
                             std::to_string(*first_us_) + " us");
      }
      last_us_ = event.t_us;
      bool ok = true;
      for (std::int64_t ms = static_cast<std::int64_t>(ms_to_idx_->size()); ms * 1000 <= t; ++ms) {
        ok = ok && ms_to_idx_->push(t_->size());
      }
      ok = ok && x_->push(event.x) && y_->push(event.y) && t_->push(static_cast<std::uint32_t>(t)) &&
           p_->push(event.on ? 1 : 0) && (!camera_ || camera_->push(event.camera));
      check(ok);
    }
  }

  void commit() override {
    check(ms_to_idx_->push(t_->size()));
    check(!camera_ || camera_->flush());
    check(x_->flush() && y_->flush() && t_->flush() && p_->flush() && ms_to_idx_->flush());
    write_scalar("/t_offset", first_us_.value_or(0));
    close_columns();
    check(H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0);
    file_ = Hdf5Handle();
    out_.commit();
  }

 private:
  void write_scalar(const char* name, std::int64_t value) {
    const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
    const Hdf5Handle plist = dataset_properties();
    const Hdf5Handle id(H5Dcreate2(file_, name, H5T_STD_I64LE, space, H5P_DEFAULT, plist, H5P_DEFAULT),
                        H5Dclose);
    check(H5Dwrite(id, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, &value) >= 0);
  }

  void close_columns() {
    x_.reset();
    y_.reset();
    t_.reset();
    p_.reset();
    camera_.reset();
    ms_to_idx_.reset();
  }

  void check(bool ok) const {
    if (!ok) throw_unwritten(out_.path());
  }

  OutputFile out_;
  ImageSize size_;
  int cameras_;
  Hdf5Handle file_;
  std::optional<Column<std::uint16_t>> x_, y_;
  std::optional<Column<std::uint32_t>> t_;
  std::optional<Column<std::uint8_t>> p_, camera_;
  std::optional<Column<std::uint64_t>> ms_to_idx_;
  std::optional<std::int64_t> first_us_;
  std::int64_t last_us_ = 0;
};

class Hdf5ArrayFile final : public ArrayFile {
 public:
  explicit Hdf5ArrayFile(const std::filesystem::path& path) : out_(path) {
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    file_ = Hdf5Handle(H5Fcreate(out_.part().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT), H5Fclose);
    check(file_ >= 0);
    with_groups_ = Hdf5Handle(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
    H5Pset_create_intermediate_group(with_groups_, 1);
  }

  std::size_t add(const std::string& name, ArrayType type,
                  const std::vector<std::size_t>& row_shape) override {
    Array array{type, detail::row_bytes(type, row_shape), {0}, {}};
    for (const std::size_t length : row_shape) array.shape.push_back(length);
    std::vector<hsize_t> most = array.shape;
    std::vector<hsize_t> chunk = array.shape;
    most[0] = H5S_UNLIMITED;
    constexpr std::size_t chunk_bytes = 1 << 16;
    chunk[0] = std::max<std::size_t>(1, chunk_bytes / array.bytes);
    const int rank = static_cast<int>(array.shape.size());
    const Hdf5Handle space(H5Screate_simple(rank, array.shape.data(), most.data()), H5Sclose);
    const Hdf5Handle plist = dataset_properties();
    H5Pset_chunk(plist, rank, chunk.data());
    H5Pset_shuffle(plist);
    H5Pset_deflate(plist, 1);
    array.id = Hdf5Handle(
        H5Dcreate2(file_, name.c_str(), types_of(type)[0], space, with_groups_, plist, H5P_DEFAULT),
        H5Dclose);
    check(array.id >= 0);
    arrays_.push_back(std::move(array));
    return arrays_.size() - 1;
  }

  void append(std::size_t number, std::span<const std::byte> rows) override {
    Array& array = arrays_.at(number);
    SACCADE_CHECK(rows.size() % array.bytes == 0);
    std::vector<hsize_t> start(array.shape.size(), 0), count = array.shape;
    start[0] = array.shape[0];
    count[0] = rows.size() / array.bytes;
    if (count[0] == 0) return;
    array.shape[0] += count[0];
    check(H5Dset_extent(array.id, array.shape.data()) >= 0);
    const Hdf5Handle in_file(H5Dget_space(array.id), H5Sclose);
    const Hdf5Handle in_memory(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr),
                               H5Sclose);
    H5Sselect_hyperslab(in_file, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr);
    check(H5Dwrite(array.id, types_of(array.type)[1], in_memory, in_file, H5P_DEFAULT, rows.data()) >= 0);
  }

  void put(const std::string& name, const std::vector<std::string>& texts) override {
    const std::string bytes = detail::padded(texts);
    const hsize_t count = texts.size();
    const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type, detail::longest(texts));
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    const Hdf5Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Hdf5Handle plist = dataset_properties();
    const Hdf5Handle id(H5Dcreate2(file_, name.c_str(), type, space, with_groups_, plist, H5P_DEFAULT),
                        H5Dclose);
    check(id >= 0 && H5Dwrite(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) >= 0);
  }

  void commit() override {
    arrays_.clear();
    check(H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0);
    file_ = Hdf5Handle();
    out_.commit();
  }

 private:
  struct Array {
    ArrayType type;
    std::size_t bytes;  ///< of a row
    std::vector<hsize_t> shape;
    Hdf5Handle id;
  };

  /// In the file and in memory.
  static std::array<hid_t, 2> types_of(ArrayType type) {
    switch (type) {
      case ArrayType::u8:
        return {H5T_STD_U8LE, H5T_NATIVE_UINT8};
      case ArrayType::i64:
        return {H5T_STD_I64LE, H5T_NATIVE_INT64};
      case ArrayType::f32:
        return {H5T_IEEE_F32LE, H5T_NATIVE_FLOAT};
      case ArrayType::f64:
        return {H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE};
    }
    return {};
  }
  void check(bool ok) const {
    if (!ok) throw_unwritten(out_.path());
  }

  OutputFile out_;
  Hdf5Handle file_;
  Hdf5Handle with_groups_;
  std::vector<Array> arrays_;
};

EventWriter* create_events(const std::filesystem::path& path, ImageSize size, int cameras) {
  return new Hdf5Writer(path, size, cameras);
}

ArrayFile* create_arrays(const std::filesystem::path& path) { return new Hdf5ArrayFile(path); }

}  // namespace
}  // namespace saccade

extern "C" {
extern const saccade::Hdf5Library saccade_hdf5_writer_1;
const saccade::Hdf5Library saccade_hdf5_writer_1{&saccade::create_events, &saccade::create_arrays};
}
