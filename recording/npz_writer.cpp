#include <zlib.h>

#include <array>
#include <vector>

#include "core/error.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/npz_codec.h"
#include "recording/output_file.h"
#include "recording/zip_writer.h"

namespace saccade {
namespace {

using detail::crc_of;
using detail::npy_header;
using detail::zip_end;
using detail::ZipEntry;

constexpr std::size_t npy_header_bytes = 192;  ///< of the array of events, with room for the number of rows
constexpr int deflate_level = 1;
constexpr std::size_t output_bytes = 1 << 16;
constexpr std::size_t most_pending_bytes = 1 << 18;

/// Deflates bytes without a header, as ZIP files hold them.
class Deflater {
 public:
  Deflater() {
    SACCADE_CHECK(deflateInit2(&stream_, deflate_level, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) ==
                  Z_OK);
  }
  ~Deflater() { deflateEnd(&stream_); }
  Deflater(const Deflater&) = delete;
  Deflater& operator=(const Deflater&) = delete;

  /// Calls `write` with the deflated bytes.
  template <class Write>
  void run(std::string_view bytes, bool last, const Write& write) {
    stream_.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));  // zlib does not change it
    stream_.avail_in = static_cast<uInt>(bytes.size());
    std::array<char, output_bytes> out;
    do {
      stream_.next_out = reinterpret_cast<Bytef*>(out.data());
      stream_.avail_out = static_cast<uInt>(out.size());
      SACCADE_CHECK(deflate(&stream_, last ? Z_FINISH : Z_NO_FLUSH) != Z_STREAM_ERROR);
      write(std::string_view(out.data(), out.size() - stream_.avail_out));
    } while (stream_.avail_out == 0);
  }

 private:
  z_stream stream_{};
};

class NumpyWriter final : public EventWriter {
 public:
  NumpyWriter(const std::filesystem::path& path, ImageSize image_size, int cameras)
      : file_(path), image_size_(image_size), cameras_(cameras), zipped_(path.extension() == ".npz") {
    if (zipped_) begin_zip();
    put(events_header());
  }

  void write(std::span<const Event> events) override {
    for (const Event& event : events) {
      check_writable(event, image_size_, cameras_, file_.path());
      append_little(pending_, event.x);
      append_little(pending_, event.y);
      append_little(pending_, event.t_us);
      pending_ += event.on ? '\1' : '\0';
      if (cameras_ > 1) pending_ += static_cast<char>(event.camera);
      ++rows_;
      if (pending_.size() >= most_pending_bytes) put_rows(false);
    }
  }

  void commit() override {
    put_rows(true);
    if (zipped_) finish_zip();
    replace(header_place_, events_header());
    file_.commit();
  }

 private:
  void put(std::string_view bytes) {
    file_.write(bytes);
    offset_ += bytes.size();
  }
  void replace(std::uint64_t place, std::string_view bytes) {
    file_.overwrite(static_cast<std::int64_t>(place), std::as_bytes(std::span(bytes)));
  }

  [[nodiscard]] std::string events_header() const {
    const std::string camera = cameras_ > 1 ? ", ('camera', '|u1')" : "";
    return npy_header("[('x', '<u2'), ('y', '<u2'), ('t', '<i8'), ('p', '|b1')" + camera + "]",
                      std::to_string(rows_) + ",", npy_header_bytes);
  }

  void begin_zip() {
    constexpr std::size_t size_header_bytes = 128;
    std::string size = npy_header("'<i8'", "3,", size_header_bytes);
    for (const int length : {image_size_.width, image_size_.height, 2})
      append_little(size, std::int64_t{length});
    size_entry_ = {"sensor_size.npy", false, crc_of(size), size.size(), size.size(), 0};
    put(size_entry_.local_header());
    put(size);
    events_entry_ = {"events.npy", true, 0, 0, 0, offset_};
    put(events_entry_.local_header());
    // The header of the array is a stored block of the deflated bytes, so that it can be replaced when the number of rows
    // is there: type of the block, length, its complement.
    data_place_ = offset_;
    std::string block(1, '\0');
    append_little(block, static_cast<std::uint16_t>(npy_header_bytes));
    append_little(block, static_cast<std::uint16_t>(~npy_header_bytes));
    put(block);
    header_place_ = offset_;
  }

  void put_rows(bool last) {
    if (zipped_) {
      rows_crc_ = crc_of(pending_, rows_crc_);
      deflater_.run(pending_, last, [this](std::string_view bytes) { put(bytes); });
    } else {
      put(pending_);
    }
    rows_bytes_ += pending_.size();
    pending_.clear();
  }

  void finish_zip() {
    events_entry_.stored = offset_ - data_place_;
    events_entry_.unpacked = npy_header_bytes + rows_bytes_;
    events_entry_.crc = static_cast<std::uint32_t>(
        crc32_combine(crc_of(events_header()), rows_crc_, static_cast<z_off_t>(rows_bytes_)));
    replace(events_entry_.place, events_entry_.local_header());
    const std::uint64_t directory = offset_;
    put(size_entry_.directory_entry());
    put(events_entry_.directory_entry());
    const std::uint64_t directory_bytes = offset_ - directory;
    put(zip_end(2, directory, directory_bytes));
  }

  OutputFile file_;
  ImageSize image_size_;
  int cameras_;
  bool zipped_;
  std::uint64_t offset_ = 0;
  std::uint64_t header_place_ = 0;  ///< of the header of the array of events
  std::uint64_t data_place_ = 0;    ///< of the deflated bytes
  std::uint64_t rows_ = 0;
  std::uint64_t rows_bytes_ = 0;
  std::uint32_t rows_crc_ = 0;
  std::string pending_;  ///< rows
  ZipEntry size_entry_, events_entry_;
  Deflater deflater_;
};

}  // namespace

std::unique_ptr<EventWriter> create_numpy(const std::filesystem::path& path, ImageSize image_size,
                                          int cameras) {
  return std::make_unique<NumpyWriter>(path, image_size, cameras);
}

}  // namespace saccade
