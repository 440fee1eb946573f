#include "recording/array_file.h"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>
#include <numeric>
#include <string>
#include <thread>

#include "core/error.h"
#include "recording/array_rows.h"
#include "recording/helper_process.h"
#include "recording/helper_reader.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

/// Two arrays and a table of texts, in pieces.
void fill(ArrayFile& file) {
  const std::size_t t = file.add("t_us", ArrayType::i64, {});
  const std::size_t image = file.add("left/image", ArrayType::f32, {2, 3});
  file.put("objects", {"nothing", "room", "a ball"});
  for (std::int64_t i = 0; i < 5; ++i) {
    file.append(t, std::span<const std::int64_t>(&i, 1));
    std::vector<float> values(6);
    std::iota(values.begin(), values.end(), static_cast<float>(10 * i));
    file.append(image, std::span<const float>(values));
  }
}

std::string bytes_of(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

template <class T>
std::vector<T> read_hdf5(hid_t file, const char* name, hid_t type, std::vector<hsize_t> shape) {
  const hid_t id = H5Dopen2(file, name, H5P_DEFAULT);
  EXPECT_GE(id, 0) << name;
  const hid_t space = H5Dget_space(id);
  std::vector<hsize_t> found(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space)));
  H5Sget_simple_extent_dims(space, found.data(), nullptr);
  EXPECT_EQ(found, shape) << name;
  std::vector<T> values(std::accumulate(found.begin(), found.end(), std::size_t{1}, std::multiplies<>()));
  EXPECT_GE(H5Dread(id, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), 0);
  H5Sclose(space);
  H5Dclose(id);
  return values;
}

TEST(ArrayFile, OfHdf5HasTheArraysInTheirGroups) {
  const fs::path folder = fs::path(testing::TempDir()) / "array_file_hdf5";
  fs::remove_all(folder);
  fs::create_directory(folder);
  const auto file = create_array_file(folder / "a.h5");
  fill(*file);
  EXPECT_FALSE(fs::exists(folder / "a.h5"));
  file->commit();
  const hid_t id = H5Fopen((folder / "a.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(id, 0);
  EXPECT_EQ(read_hdf5<std::int64_t>(id, "t_us", H5T_NATIVE_INT64, {5}),
            (std::vector<std::int64_t>{0, 1, 2, 3, 4}));
  const auto image = read_hdf5<float>(id, "left/image", H5T_NATIVE_FLOAT, {5, 2, 3});
  EXPECT_EQ(image[0], 0.0F);
  EXPECT_EQ(image[29], 45.0F);
  H5Fclose(id);
}

TEST(ArrayFile, HasTheSameBytesWheneverItIsWritten) {
  const fs::path folder = fs::path(testing::TempDir()) / "array_file_times";
  fs::remove_all(folder);
  fs::create_directory(folder);
  const auto write = [&](const std::string& name) {
    const auto file = create_array_file(folder / name);
    fill(*file);
    file->commit();
  };
  for (const char* name : {"a.h5", "a.npz"}) write(name);
  // Times in files are whole seconds, in ZIP files whole pairs of them.
  std::this_thread::sleep_for(std::chrono::milliseconds(2100));
  for (const char* name : {"b.h5", "b.npz"}) write(name);
  EXPECT_EQ(bytes_of(folder / "a.h5"), bytes_of(folder / "b.h5"));
  EXPECT_EQ(bytes_of(folder / "a.npz"), bytes_of(folder / "b.npz"));
}

TEST(ArrayFile, OfNumpyIsAnUncompressedZipFileAndLeavesNothingElse) {
  const fs::path folder = fs::path(testing::TempDir()) / "array_file_npz";
  fs::remove_all(folder);
  fs::create_directory(folder);
  {
    const auto file = create_array_file(folder / "a.npz");
    fill(*file);
    EXPECT_FALSE(fs::exists(folder / "a.npz"));
    file->commit();
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
  const std::string bytes = bytes_of(folder / "a.npz");
  const std::size_t header = bytes.find("{'descr': '<f4', 'fortran_order': False, 'shape': (5, 2, 3,), }");
  ASSERT_NE(header, std::string::npos);
  float last = 0.0F;
  std::memcpy(&last, bytes.data() + bytes.find('\n', header) + 1 + 29 * sizeof(float), sizeof(float));
  EXPECT_EQ(last, 45.0F);
  EXPECT_NE(bytes.find("left/image.npy"), std::string::npos);
  EXPECT_NE(bytes.find("'|S7'"), std::string::npos);
}

TEST(ArrayFile, ThatIsNotFinishedLeavesNothing) {
  const fs::path folder = fs::path(testing::TempDir()) / "array_file_left";
  fs::remove_all(folder);
  fs::create_directory(folder);
  for (const char* name : {"a.npz", "a.h5"}) {
    fill(*create_array_file(folder / name));
    EXPECT_TRUE(fs::is_empty(folder)) << name;
  }
  EXPECT_THROW((void)create_array_file(folder / "absent" / "a.npz"), RunError);
}

TEST(ArrayRows, AreThoseThatWereWritten) {
  const fs::path folder = fs::path(testing::TempDir()) / "array_rows";
  fs::remove_all(folder);
  fs::create_directory(folder);
  for (const char* const name : {"a.npz", "a.h5"}) {
    SCOPED_TRACE(name);
    const auto file = create_array_file(folder / name);
    fill(*file);
    const std::vector<std::size_t> shape = {100, 400};
    const std::size_t large =
        file->add("large", ArrayType::f64, shape);  // rows of more than a message of the helper
    std::vector<double> values(40'000);
    for (int i = 0; i < 2; ++i) {
      std::iota(values.begin(), values.end(), 1e6 * i);
      file->append(large, std::span<const double>(values));
    }
    file->commit();

    const auto image = open_array(folder / name, "left/image");
    ASSERT_NE(image, nullptr);
    EXPECT_EQ(image->type(), ArrayType::f32);
    EXPECT_EQ(image->shape(), (std::vector<std::size_t>{5, 2, 3}));
    EXPECT_EQ(image->row_bytes(), 24U);
    std::string row;
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(image->next(row));
      std::vector<float> found(6);
      ASSERT_EQ(row.size(), 24U);
      std::memcpy(found.data(), row.data(), row.size());
      for (int k = 0; k < 6; ++k)
        EXPECT_EQ(found[static_cast<std::size_t>(k)], static_cast<float>(10 * i + k));
    }
    EXPECT_FALSE(image->next(row));
    EXPECT_FALSE(image->next(row));

    const auto rows = open_array(folder / name, "large");
    ASSERT_NE(rows, nullptr);
    ASSERT_TRUE(rows->next(row));
    ASSERT_TRUE(rows->next(row));
    ASSERT_EQ(row.size(), 320'000U);
    std::memcpy(values.data(), row.data(), row.size());
    EXPECT_EQ(values.front(), 1e6);
    EXPECT_EQ(values.back(), 1e6 + 39'999);
    EXPECT_FALSE(rows->next(row));

    EXPECT_EQ(open_array(folder / name, "right/image"), nullptr);
    EXPECT_EQ(open_array(folder / name, "objects"), nullptr) << "texts";
  }
}

TEST(ArrayRows, OfABrokenFileAreAnError) {
  const fs::path folder = fs::path(testing::TempDir()) / "array_rows_broken";
  fs::remove_all(folder);
  fs::create_directory(folder);
  EXPECT_THROW((void)open_array(folder / "none.npz", "t_us"), InputError);
  EXPECT_THROW((void)open_array(folder / "none.h5", "t_us"), InputError);
  for (const char* const name : {"a.npz", "a.h5"}) {
    const auto file = create_array_file(folder / name);
    fill(*file);
    file->commit();
    const std::string bytes = bytes_of(folder / name);
    // Cut anywhere, the file is an error, or the rows before the cut and an error, or the whole array.
    for (std::size_t length = 1; length < bytes.size(); length += 1 + bytes.size() / 40) {
      std::ofstream(folder / (std::string("cut_") + name), std::ios::binary) << bytes.substr(0, length);
      try {
        const auto rows = open_array(folder / (std::string("cut_") + name), "t_us");
        std::string row;
        for (std::int64_t i = 0; rows && rows->next(row); ++i) {
          std::int64_t value = -1;
          ASSERT_EQ(row.size(), sizeof value);
          std::memcpy(&value, row.data(), sizeof value);
          EXPECT_EQ(value, i);
        }
      } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("cut_"), std::string::npos) << error.what();
      }
    }
  }
}

TEST(HelperProcess, ThatCannotBeStartedIsAnError) {
  EXPECT_THROW(HelperProcess("a.h5", "libfragile", {"/no/such/program", {}}), RunError);
}

}  // namespace
}  // namespace saccade
