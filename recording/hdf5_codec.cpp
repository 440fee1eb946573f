#include "recording/hdf5_codec.h"

#include "core/error.h"
#include "recording/codec.h"
#include "recording/hdf5_handle.h"
#include "recording/helper_reader.h"
#include "recording/input_file.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

constexpr std::size_t chunk_events = 1 << 16;

/// A dataset of one dimension that grows.
template <class T>
class Column {
 public:
  Column(hid_t parent, const char* name, hid_t in_file, hid_t in_memory) : in_memory_(in_memory) {
    const hsize_t none = 0, unlimited = H5S_UNLIMITED, chunk = chunk_events;
    const Hdf5Handle space(H5Screate_simple(1, &none, &unlimited), H5Sclose);
    const Hdf5Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
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
    const Hdf5Handle id(H5Dcreate2(file_, name, H5T_STD_I64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
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

}  // namespace

RecordingFormat hdf5_format() {
  RecordingFormat format;
  format.name = "HDF5";
  format.extensions = {".h5", ".hdf5"};
  format.sniff = [](const FileStart& start) {
    return start.bytes.starts_with("\x89HDF\r\n\x1a\n") ? Match::certain : Match::none;
  };
  format.open = [](InputFile file, const EventReadOptions& options) {
    const std::string size = options.image_size ? text_of(*options.image_size) : std::string();
    const std::string unit(options.time_unit ? word_of(*options.time_unit) : "");
    return open_in_helper(file.name(), "libhdf5",
                          {find_helper("saccade-hdf5-reader"), {file.name(), size, options.columns, unit}});
  };
  format.create = [](const std::filesystem::path& path, ImageSize size,
                     int cameras) -> std::unique_ptr<EventWriter> {
    return std::make_unique<Hdf5Writer>(path, size, cameras);
  };
  format.cameras = 2;
  format.longest_us = std::int64_t{0xffffffff};
  format.read_in_helper = true;
  format.reads =
      "a group of datasets t, x, y, p (DSEC with `/t_offset` and `/events/{width,height,camera}`, M3ED, "
      "event_utils, "
      "e2calib), records of them (Metavision's `/CD/events`), or a table N x 4 `events` (v2e: t, x, y, p; "
      "MVSEC: x, y, t, "
      "p; others by `--columns`); of a left and a right camera both, merged by time; gzip, other filters "
      "with libhdf5's "
      "plugin for them";
  format.writes =
      "DSEC's layout with gzip; `/ms_to_idx` up to the ms after the last event, `/t_offset` the first "
      "event's time; of two cameras `/events/camera`, 0 left and 1 right";
  format.time =
      "in the unit of the name or of `--time-unit`, else whole numbers us, floating-point s; 32 bits "
      "continued over wraps; "
      "written: 32 bits of us after `/t_offset`";
  format.axes = "top left, 1 is ON";
  format.limits = "sorted by time, 2^32 us";
  return format;
}

}  // namespace saccade
