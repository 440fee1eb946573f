#include "recording/array_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "core/error.h"
#include "recording/hdf5_library.h"
#include "recording/output_file.h"
#include "recording/zip_writer.h"

namespace saccade {
namespace {

/// Rows of an array until the file is put together: a file without a name, in the folder of the output.
class Spool {
 public:
  explicit Spool(const std::filesystem::path& beside) : place_(beside.string()) {
    std::string name = beside.string() + ".rows.XXXXXX";
    file_ = ::mkstemp(name.data());
    if (file_ < 0) fail();
    ::unlink(name.c_str());
  }
  Spool(Spool&& other) noexcept
      : place_(std::move(other.place_)), file_(std::exchange(other.file_, -1)), size_(other.size_) {}
  Spool& operator=(Spool&&) = delete;
  ~Spool() {
    if (file_ >= 0) ::close(file_);
  }

  void write(std::span<const std::byte> bytes) {
    size_ += bytes.size();
    while (!bytes.empty()) {
      const auto done = ::write(file_, bytes.data(), bytes.size());
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) fail();
      bytes = bytes.subspan(static_cast<std::size_t>(done));
    }
  }
  [[nodiscard]] std::uint64_t size() const { return size_; }
  template <class Take>
  void read(const Take& take) {
    std::string block(1 << 20, '\0');
    if (::lseek(file_, 0, SEEK_SET) != 0) fail();
    for (;;) {
      const auto done = ::read(file_, block.data(), block.size());
      if (done < 0 && errno == EINTR) continue;
      if (done < 0) fail();
      if (done == 0) return;
      take(std::string_view(block.data(), static_cast<std::size_t>(done)));
    }
  }

 private:
  [[noreturn]] void fail() const {
    const int cause = errno;
    const std::string message = place_ + ": cannot be written: " + std::string(std::strerror(cause));
    if (cause == ENOSPC || cause == EDQUOT || cause == EFBIG) throw DiskFull(message);
    throw RunError(message);
  }

  std::string place_;
  int file_ = -1;
  std::uint64_t size_ = 0;
};

class NpzArrayFile final : public ArrayFile {
 public:
  explicit NpzArrayFile(const std::filesystem::path& path) : out_(path) {}

  std::size_t add(const std::string& name, ArrayType type,
                  const std::vector<std::size_t>& row_shape) override {
    std::string shape;
    for (const std::size_t length : row_shape) shape += " " + std::to_string(length) + ",";
    arrays_.push_back({name, word_of(type), shape, detail::row_bytes(type, row_shape), Spool(out_.path())});
    return arrays_.size() - 1;
  }
  void append(std::size_t number, std::span<const std::byte> rows) override {
    SACCADE_CHECK(rows.size() % arrays_.at(number).bytes == 0);
    arrays_[number].rows.write(rows);
  }
  void put(const std::string& name, const std::vector<std::string>& texts) override {
    arrays_.push_back({name, "'|S" + std::to_string(detail::longest(texts)) + "'", "", detail::longest(texts),
                       Spool(out_.path())});
    const std::string bytes = detail::padded(texts);
    arrays_.back().rows.write(std::as_bytes(std::span<const char>(bytes)));
  }
  void commit() override {
    std::vector<detail::ZipEntry> entries;
    for (Array& array : arrays_) {
      constexpr std::size_t header_bytes = 192;
      const std::string header = detail::npy_header(
          array.type, std::to_string(array.rows.size() / array.bytes) + "," + array.shape, header_bytes);
      std::uint32_t crc = detail::crc_of(header);
      array.rows.read([&](std::string_view bytes) { crc = detail::crc_of(bytes, crc); });
      const std::uint64_t size = header.size() + array.rows.size();
      entries.push_back({array.name + ".npy", false, crc, size, size, offset_});
      put(entries.back().local_header());
      put(header);
      array.rows.read([&](std::string_view bytes) { put(bytes); });
    }
    const std::uint64_t directory = offset_;
    for (const detail::ZipEntry& entry : entries) put(entry.directory_entry());
    put(detail::zip_end(entries.size(), directory, offset_ - directory));
    out_.commit();
  }

 private:
  struct Array {
    std::string name;
    std::string type;   ///< as NumPy writes it
    std::string shape;  ///< of a row
    std::size_t bytes;  ///< of a row
    Spool rows;
  };

  static std::string word_of(ArrayType type) {
    switch (type) {
      case ArrayType::u8:
        return "'|u1'";
      case ArrayType::i64:
        return "'<i8'";
      case ArrayType::f32:
        return "'<f4'";
      case ArrayType::f64:
        return "'<f8'";
    }
    return {};
  }
  void put(std::string_view bytes) {
    out_.write(bytes);
    offset_ += bytes.size();
  }

  OutputFile out_;
  std::vector<Array> arrays_;
  std::uint64_t offset_ = 0;
};

}  // namespace

std::unique_ptr<ArrayFile> create_array_file(const std::filesystem::path& path) {
  if (path.extension() == ".npz") return std::make_unique<NpzArrayFile>(path);
  SACCADE_CHECK(path.extension() == ".h5");
  return std::unique_ptr<ArrayFile>(hdf5_library().create_arrays(path));
}

}  // namespace saccade
