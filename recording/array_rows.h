#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "recording/array_file.h"

namespace saccade {

/// An array of a file that ArrayFile wrote, row by row: memory does not grow with it.
class ArrayRows {
 public:
  ArrayRows(ArrayType type, std::vector<std::size_t> shape) : type_(type), shape_(std::move(shape)) {}
  ArrayRows(const ArrayRows&) = delete;
  ArrayRows& operator=(const ArrayRows&) = delete;
  virtual ~ArrayRows() = default;

  [[nodiscard]] ArrayType type() const { return type_; }
  /// At least one length: that of the rows comes first.
  [[nodiscard]] const std::vector<std::size_t>& shape() const { return shape_; }
  [[nodiscard]] std::size_t row_bytes() const {
    std::size_t bytes = size_of(type_);
    for (std::size_t i = 1; i < shape_.size(); ++i) bytes *= shape_[i];
    return bytes;
  }
  /// The bytes of the next row, in the computer's byte order; false at the end. Throws InputError.
  virtual bool next(std::string& row) = 0;

 private:
  ArrayType type_;
  std::vector<std::size_t> shape_;
};

/// Of a .npz or .h5 file, which a helper process reads (recording/helper_reader.h). Null where the file has no array of
/// numbers of this name. Throws InputError.
[[nodiscard]] std::unique_ptr<ArrayRows> open_array(const std::filesystem::path& file,
                                                    const std::string& name);

}  // namespace saccade
