#include "recording/array_rows.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>

#include "core/error.h"
#include "recording/codec.h"
#include "recording/helper_process.h"
#include "recording/helper_reader.h"
#include "recording/input_file.h"
#include "recording/npy_columns.h"
#include "recording/unpacked_part.h"
#include "recording/zip_members.h"

namespace saccade {
namespace {

constexpr std::size_t most_row_bytes = std::size_t{1} << 30;

std::optional<ArrayType> type_of_word(const std::string& word) {
  if (word == "|u1") return ArrayType::u8;
  if (word == "<i8") return ArrayType::i64;
  if (word == "<f4") return ArrayType::f32;
  if (word == "<f8") return ArrayType::f64;
  return std::nullopt;
}

/// Throws where a row has no size that is possible.
void check_shape(const std::string& file, const std::string& name, ArrayType type,
                 const std::vector<std::size_t>& shape) {
  std::size_t bytes = size_of(type);
  for (std::size_t i = 1; i < shape.size(); ++i) {
    if (shape[i] > 0 && bytes > most_row_bytes / shape[i]) bytes = most_row_bytes;
    bytes *= std::max<std::size_t>(shape[i], 1);
    if (bytes > most_row_bytes)
      throw InputError(file, "the array " + printable(name) + " with rows of 2^30 bytes or more",
                       "arrays of saccade");
  }
}

class NpzRows final : public ArrayRows {
 public:
  NpzRows(const std::filesystem::path& path, const std::string& name, ArrayType type,
          std::vector<std::size_t> shape, const ZipMember& member, std::size_t header_bytes)
      : ArrayRows(type, std::move(shape)), name_(name), file_(path) {
    (void)file_.discard(member.place);
    part_.begin(member.decompressor(), member.stored_bytes);
    (void)part_.discard(header_bytes);
  }

  bool next(std::string& row) override {
    if (done_ == shape()[0]) return false;
    if (!read_bytes(part_, row_bytes(), row)) {
      throw InputError(
          file_.name(),
          "the end of the array " + printable(name_) + " after " + std::to_string(done_) + " rows",
          std::to_string(shape()[0]) + " rows");
    }
    ++done_;
    return true;
  }

 private:
  std::string name_;
  InputFile file_;
  UnpackedPart part_{file_};
  std::size_t done_ = 0;
};

std::unique_ptr<ArrayRows> open_npz_array(const std::filesystem::path& path, const std::string& name) {
  InputFile file(path);
  std::unique_ptr<ArrayRows> found;
  for_each_zip_member(file, [&](const ZipMember& member) {
    UnpackedPart part(file);
    part.begin(member.decompressor(), member.stored_bytes);
    if (member.name == name + ".npy") {
      std::size_t header_bytes = 0;
      const NpyHeader header = read_npy_header(part, file, header_bytes);
      const std::optional<ArrayType> type = type_of_word(header.type);
      if (type && !header.shape.empty() && !header.fortran_order && std::ranges::min(header.shape) >= 0) {
        std::vector<std::size_t> shape(header.shape.begin(), header.shape.end());
        check_shape(path.string(), name, *type, shape);
        found = std::make_unique<NpzRows>(path, name, *type, std::move(shape), member, header_bytes);
      }
    }
    if (!part.discard_rest()) file.fail("the end of the file in a member", "the rest of a ZIP file");
  });
  return found;
}

class HelperRows final : public ArrayRows {
 public:
  HelperRows(ArrayType type, std::vector<std::size_t> shape, std::unique_ptr<HelperProcess> process)
      : ArrayRows(type, std::move(shape)), process_(std::move(process)) {}

  bool next(std::string& row) override {
    row.clear();
    if (done_ == shape()[0]) return false;
    ++done_;
    while (row.size() < row_bytes()) {
      const std::optional<std::string> bytes = process_->receive(HelperMessageKind::rows);
      if (!bytes || bytes->empty()) process_->fail_of_library("(bad message)");
      row += *bytes;
    }
    if (row.size() != row_bytes()) process_->fail_of_library("(bad message)");
    return true;
  }

 private:
  std::unique_ptr<HelperProcess> process_;
  std::size_t done_ = 0;
};

std::unique_ptr<ArrayRows> open_array_in_helper(const std::filesystem::path& path, const std::string& name) {
  auto process = std::make_unique<HelperProcess>(
      path.string(), "libhdf5",
      HelperCommand{find_helper("saccade-hdf5-reader"), {std::filesystem::absolute(path).string(), name}});
  const std::optional<std::string> opened = process->receive(HelperMessageKind::opened);
  if (!opened) return nullptr;
  HelperArray head{};
  if (opened->size() < sizeof head) process->fail_of_library("(bad message)");
  std::memcpy(&head, opened->data(), sizeof head);
  constexpr std::uint32_t most_lengths = 8;
  if (head.type > static_cast<std::uint32_t>(ArrayType::f64) || head.lengths < 1 ||
      head.lengths > most_lengths || opened->size() != sizeof head + head.lengths * sizeof(std::uint64_t))
    process->fail_of_library("(bad message)");
  std::vector<std::uint64_t> lengths(head.lengths);
  std::memcpy(lengths.data(), opened->data() + sizeof head, lengths.size() * sizeof(std::uint64_t));
  std::vector<std::size_t> shape(lengths.begin(), lengths.end());
  const auto type = static_cast<ArrayType>(head.type);
  check_shape(path.string(), name, type, shape);
  return std::make_unique<HelperRows>(type, std::move(shape), std::move(process));
}

}  // namespace

std::unique_ptr<ArrayRows> open_array(const std::filesystem::path& file, const std::string& name) {
  return file.extension() == ".npz" ? open_npz_array(file, name) : open_array_in_helper(file, name);
}

}  // namespace saccade
