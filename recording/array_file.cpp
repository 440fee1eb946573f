#include "recording/array_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "core/error.h"
#include "recording/hdf5_handle.h"
#include "recording/output_file.h"
#include "recording/zip_writer.h"

namespace saccade {
namespace {

std::size_t row_bytes(ArrayType type, const std::vector<std::size_t>& shape) {
  std::size_t bytes = size_of(type);
  for (const std::size_t length : shape) bytes *= length;
  return bytes;
}

std::size_t longest(const std::vector<std::string>& texts) {
  std::size_t length = 1;
  for (const std::string& text : texts) length = std::max(length, text.size());
  return length;
}

/// The texts one after the other, filled up with zeros.
std::string padded(const std::vector<std::string>& texts) {
  std::string bytes;
  for (const std::string& text : texts) bytes += text + std::string(longest(texts) - text.size(), '\0');
  return bytes;
}

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
    Array array{type, row_bytes(type, row_shape), {0}, {}};
    for (const std::size_t length : row_shape) array.shape.push_back(length);
    std::vector<hsize_t> most = array.shape;
    std::vector<hsize_t> chunk = array.shape;
    most[0] = H5S_UNLIMITED;
    constexpr std::size_t chunk_bytes = 1 << 16;
    chunk[0] = std::max<std::size_t>(1, chunk_bytes / array.bytes);
    const int rank = static_cast<int>(array.shape.size());
    const Hdf5Handle space(H5Screate_simple(rank, array.shape.data(), most.data()), H5Sclose);
    const Hdf5Handle plist(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
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
    const std::string bytes = padded(texts);
    const hsize_t count = texts.size();
    const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(type, longest(texts));
    H5Tset_strpad(type, H5T_STR_NULLPAD);
    const Hdf5Handle space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    const Hdf5Handle id(H5Dcreate2(file_, name.c_str(), type, space, with_groups_, H5P_DEFAULT, H5P_DEFAULT),
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
    arrays_.push_back({name, word_of(type), shape, row_bytes(type, row_shape), Spool(out_.path())});
    return arrays_.size() - 1;
  }
  void append(std::size_t number, std::span<const std::byte> rows) override {
    SACCADE_CHECK(rows.size() % arrays_.at(number).bytes == 0);
    arrays_[number].rows.write(rows);
  }
  void put(const std::string& name, const std::vector<std::string>& texts) override {
    arrays_.push_back(
        {name, "'|S" + std::to_string(longest(texts)) + "'", "", longest(texts), Spool(out_.path())});
    const std::string bytes = padded(texts);
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
  return std::make_unique<Hdf5ArrayFile>(path);
}

}  // namespace saccade
