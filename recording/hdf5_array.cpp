#include "recording/hdf5_array.h"

#include <optional>

#include "core/error.h"
#include "recording/codec.h"
#include "recording/hdf5_handle.h"

namespace saccade {
namespace {

/// And the type in memory.
std::optional<std::pair<ArrayType, hid_t>> type_of(hid_t in_file) {
  for (const auto& [type, stored, memory] : {std::tuple{ArrayType::u8, H5T_STD_U8LE, H5T_NATIVE_UINT8},
                                             {ArrayType::i64, H5T_STD_I64LE, H5T_NATIVE_INT64},
                                             {ArrayType::f32, H5T_IEEE_F32LE, H5T_NATIVE_FLOAT},
                                             {ArrayType::f64, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE}}) {
    if (H5Tequal(in_file, stored) > 0) return std::pair(type, memory);
  }
  return std::nullopt;
}

class Hdf5Rows final : public ArrayRows {
 public:
  Hdf5Rows(std::string name, ArrayType type, hid_t memory, std::vector<hsize_t> shape, Hdf5Handle file,
           Hdf5Handle array)
      : ArrayRows(type, {shape.begin(), shape.end()}),
        name_(std::move(name)),
        memory_(memory),
        count_(std::move(shape)),
        start_(count_.size(), 0),
        file_(std::move(file)),
        array_(std::move(array)) {
    count_[0] = 1;
  }

  bool next(std::string& row) override {
    if (start_[0] == this->shape()[0]) return false;
    row.resize(row_bytes());
    const Hdf5Handle in_file(H5Dget_space(array_), H5Sclose);
    const Hdf5Handle in_memory(H5Screate_simple(static_cast<int>(count_.size()), count_.data(), nullptr),
                               H5Sclose);
    H5Sselect_hyperslab(in_file, H5S_SELECT_SET, start_.data(), nullptr, count_.data(), nullptr);
    if (H5Dread(array_, memory_, in_memory, in_file, H5P_DEFAULT, row.data()) < 0)
      throw InputError(name_, "a row that libhdf5 cannot read: " + last_hdf5_error(), "a sound file");
    ++start_[0];
    return true;
  }

 private:
  std::string name_;
  hid_t memory_;
  std::vector<hsize_t> count_;
  std::vector<hsize_t> start_;
  Hdf5Handle file_;
  Hdf5Handle array_;
};

}  // namespace

std::unique_ptr<ArrayRows> open_hdf5_array_here(const std::filesystem::path& path, const std::string& name) {
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (file < 0)
    throw InputError(path.string(), "a file that libhdf5 cannot open: " + last_hdf5_error(), "HDF5");
  Hdf5Handle array(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (array < 0) return nullptr;
  const Hdf5Handle stored(H5Dget_type(array), H5Tclose);
  const auto type = type_of(stored);
  const Hdf5Handle space(H5Dget_space(array), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  if (!type || rank < 1) return nullptr;
  std::vector<hsize_t> shape(static_cast<std::size_t>(rank));
  H5Sget_simple_extent_dims(space, shape.data(), nullptr);
  return std::make_unique<Hdf5Rows>(path.string(), type->first, type->second, std::move(shape),
                                    std::move(file), std::move(array));
}

}  // namespace saccade
