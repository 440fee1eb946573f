#include <hdf5.h>
#include <stdlib.h>
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>
#endif

#include <array>
#include <chrono>
#include <fstream>
#include <iterator>
#include <random>
#include <thread>

#include "core/error.h"
#include "tests/recording/read_events.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// A file as another program would write it, by libhdf5 itself.
class H5File {
 public:
  explicit H5File(const std::filesystem::path& path)
      : id_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT)) {}
  H5File(const H5File&) = delete;
  H5File& operator=(const H5File&) = delete;
  ~H5File() { H5Fclose(id_); }

  void group(const char* name) { H5Gclose(H5Gcreate2(id_, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT)); }

  /// Numbers of any shape, as `type`; chunked and with gzip where `chunk` is not 0.
  void numbers(const char* name, hid_t type, const std::vector<hsize_t>& dims,
               const std::vector<std::int64_t>& values, hsize_t chunk = 0, H5Z_filter_t optional_filter = 0) {
    const hid_t space = dims.empty() ? H5Screate(H5S_SCALAR)
                                     : H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr);
    const hid_t plist = H5Pcreate(H5P_DATASET_CREATE);
    if (chunk > 0) {
      std::vector<hsize_t> chunks = dims;
      chunks[0] = chunk;
      H5Pset_chunk(plist, static_cast<int>(dims.size()), chunks.data());
      if (optional_filter == 0) H5Pset_deflate(plist, 4);
      if (optional_filter != 0) H5Pset_filter(plist, optional_filter, H5Z_FLAG_OPTIONAL, 0, nullptr);
    }
    const hid_t data = H5Dcreate2(id_, name, type, space, H5P_DEFAULT, plist, H5P_DEFAULT);
    if (H5Tget_class(type) == H5T_ENUM) {
      const std::vector<std::int8_t> bytes(values.begin(), values.end());
      H5Dwrite(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data());
    } else {
      H5Dwrite(data, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    }
    H5Dclose(data);
    H5Pclose(plist);
    H5Sclose(space);
  }

  /// The same of floating-point numbers.
  void reals(const char* name, hid_t type, const std::vector<hsize_t>& dims,
             const std::vector<double>& values) {
    const hid_t space = H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr);
    const hid_t data = H5Dcreate2(id_, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Dclose(data);
    H5Sclose(space);
  }
  /// Records of u16 x, u16 y, i16 p, i64 t, from rows of t, x, y, p.
  void records(const char* name, const std::vector<std::array<std::int64_t, 4>>& rows) {
    const hid_t stored = H5Tcreate(H5T_COMPOUND, 14), in_memory = H5Tcreate(H5T_COMPOUND, 32);
    H5Tinsert(stored, "x", 0, H5T_STD_U16LE);
    H5Tinsert(stored, "y", 2, H5T_STD_U16LE);
    H5Tinsert(stored, "p", 4, H5T_STD_I16LE);
    H5Tinsert(stored, "t", 6, H5T_STD_I64LE);
    for (const auto& [member, offset] : {std::pair{"t", 0}, {"x", 8}, {"y", 16}, {"p", 24}})
      H5Tinsert(in_memory, member, static_cast<std::size_t>(offset), H5T_NATIVE_INT64);
    const hsize_t count = rows.size();
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t data = H5Dcreate2(id_, name, stored, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(data, in_memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, rows.data());
    H5Dclose(data);
    H5Sclose(space);
    H5Tclose(stored);
    H5Tclose(in_memory);
  }
  /// Attributes of the file.
  void attribute(const char* name, const std::vector<std::int64_t>& values) {
    const hsize_t count = values.size();
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t id = H5Acreate2(id_, name, H5T_STD_I64LE, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(id, H5T_NATIVE_INT64, values.data());
    H5Aclose(id);
    H5Sclose(space);
  }
  void text_attribute(const char* name, const char* text) {
    const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
    H5Tset_size(type, H5T_VARIABLE);
    const hid_t id = H5Acreate2(id_, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(id, type, &text);
    H5Aclose(id);
    H5Sclose(space);
    H5Tclose(type);
  }

 private:
  hid_t id_;
};

/// NumPy's bool as h5py stores it: an enumeration of one byte.
hid_t numpy_bool() {
  const hid_t type = H5Tenum_create(H5T_STD_I8LE);
  for (const std::int8_t value : std::initializer_list<std::int8_t>{0, 1})
    H5Tenum_insert(type, value == 0 ? "FALSE" : "TRUE", &value);
  return type;
}

std::vector<std::int64_t> numbers_in(const std::filesystem::path& path, const char* name) {
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t data = H5Dopen2(file, name, H5P_DEFAULT);
  const hid_t space = H5Dget_space(data);
  std::vector<std::int64_t> values(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  H5Dread(data, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Sclose(space);
  H5Dclose(data);
  H5Fclose(file);
  return values;
}

/// Sorted events with silences of some ms among them.
std::vector<Event> sorted_events(std::int64_t first_us, int count) {
  std::mt19937 random(3);
  std::vector<Event> events;
  for (std::int64_t t_us = first_us; static_cast<int>(events.size()) < count;) {
    events.push_back({t_us, static_cast<std::uint16_t>(random() % 640),
                      static_cast<std::uint16_t>(random() % 480), random() % 2 == 0, 0});
    t_us += random() % 100 == 0 ? 3500 : static_cast<std::int64_t>(random() % 40);
  }
  return events;
}

void write_file(const std::filesystem::path& path, const std::vector<Event>& events) {
  const auto writer = create_event_file(path, {640, 480});
  writer->write(events);
  writer->commit();
}

TEST(Hdf5, OfDsecIsReadBackExactlyWithItsSize) {
  const TempFolder folder;
  for (const std::int64_t first_us : std::initializer_list<std::int64_t>{0, -77, 1605537493718345}) {
    const auto events = sorted_events(first_us, 150'000);
    write_file(folder / "a.h5", events);
    const auto reader = open_event_file(folder / "a.h5");
    EXPECT_EQ(reader->format(), "HDF5, layout of DSEC");
    EXPECT_EQ(reader->image_size(), (ImageSize{640, 480}));
    EXPECT_TRUE(read_all(*reader, 4321) == events) << first_us;
  }
}

TEST(Hdf5, HasTheSameBytesWheneverItIsWritten) {
  const TempFolder folder;
  const auto events = sorted_events(0, 5000);
  write_file(folder / "a.h5", events);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // times in the file are whole seconds
  write_file(folder / "b.h5", events);
  const auto bytes = [&](const char* name) {
    std::ifstream file(folder / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  EXPECT_EQ(bytes("a.h5"), bytes("b.h5"));
}

TEST(Hdf5, WindowsCutOutByTheIndexOfMillisecondsAreThoseOfTheTimes) {
  const TempFolder folder;
  const auto path = folder / "a.hdf5";
  const auto events = sorted_events(987'654'321, 5000);
  write_file(path, events);
  const auto t = numbers_in(path, "/events/t");
  const auto ms_to_idx = numbers_in(path, "/ms_to_idx");
  EXPECT_EQ(numbers_in(path, "/t_offset"), (std::vector<std::int64_t>{987'654'321}));
  ASSERT_EQ(t.size(), events.size());
  EXPECT_EQ(static_cast<std::int64_t>(ms_to_idx.size()), t.back() / 1000 + 2);
  EXPECT_EQ(ms_to_idx.front(), 0);
  for (std::size_t ms = 0; ms < ms_to_idx.size(); ++ms) {
    const auto first = std::lower_bound(t.begin(), t.end(), static_cast<std::int64_t>(ms) * 1000);
    ASSERT_EQ(ms_to_idx[ms], first - t.begin()) << ms;
  }
}

TEST(Hdf5, OfDsecMayHaveOtherWidthsNoCompressionNoOffsetAndNoSize) {
  const TempFolder folder;
  {
    H5File file(folder / "a.h5");
    file.group("/events");
    file.numbers("/events/t", H5T_STD_I64LE, {3}, {1605537493718345, 1605537493718346, 1605537493718346});
    file.numbers("/events/x", H5T_STD_U16BE, {3}, {0, 65535, 3});
    file.numbers("/events/y", H5T_STD_I32LE, {3}, {4, 5, 6});
    file.numbers("/events/p", H5T_STD_I8LE, {3}, {1, -1, 0});
  }
  const auto reader = open_event_file(folder / "a.h5");
  EXPECT_EQ(reader->image_size(), std::nullopt);
  EXPECT_EQ(read_all(*reader, 2), (std::vector<Event>{{1605537493718345, 0, 4, true, 0},
                                                      {1605537493718346, 65535, 5, false, 0},
                                                      {1605537493718346, 3, 6, false, 0}}));
  EventReadOptions options;
  options.image_size = ImageSize{640, 480};
  EXPECT_EQ(open_event_file(folder / "a.h5", options)->image_size(), options.image_size);
}

TEST(Hdf5, OfV2eIsATableOfFourColumnsWhoseTimeContinuesOverItsWrap) {
  const TempFolder folder;
  const std::int64_t wrap = std::int64_t{1} << 32;
  {
    H5File file(folder / "a.h5");
    file.numbers("/events", H5T_STD_U32LE, {4, 4},
                 {wrap - 3, 10, 20, 1, 5, 11, 21, 0, wrap - 1, 12, 22, 1, 7, 13, 23, 0}, 3);
  }
  const auto reader = open_event_file(folder / "a.h5");
  EXPECT_EQ(reader->format(), "HDF5, layout of v2e");
  EXPECT_EQ(read_all(*reader, 3), (std::vector<Event>{{wrap - 3, 10, 20, true, 0},
                                                      {wrap + 5, 11, 21, false, 0},
                                                      {wrap - 1, 12, 22, true, 0},
                                                      {wrap + 7, 13, 23, false, 0}}));
}

TEST(Hdf5, OfAnotherLayoutIsRejectedWithWhatIsMissing) {
  const TempFolder folder;
  const auto path = folder / "a.h5";
  const auto expect_refusal = [&](const std::string& message, const auto& write) {
    {
      H5File file(path);
      write(file);
    }
    EXPECT_THAT([&] { (void)open_event_file(path); },
                ThrowsMessage<InputError>(AllOf(HasSubstr(path.string()), HasSubstr(message))));
  };
  expect_refusal("no datasets, expected events of one camera", [](H5File&) {});
  expect_refusal("found /events/t (1), /events/x (3), expected events", [](H5File& file) {
    file.group("/events");
    file.numbers("/events/t", H5T_STD_U32LE, {1}, {1});
    file.numbers("/events/x", H5T_STD_U16LE, {3}, {1, 2, 3});
  });
  expect_refusal("of 2 numbers, expected as many as /events/t has, 1", [](H5File& file) {
    file.group("/events");
    file.numbers("/events/t", H5T_STD_U32LE, {1}, {1});
    for (const char* name : {"/events/x", "/events/y", "/events/p"}) {
      file.numbers(name, H5T_STD_U16LE, {2}, {1, 1});
    }
  });
  expect_refusal("/events of 5 columns", [](H5File& file) {
    file.numbers("/events", H5T_STD_U32LE, {1, 5}, {1, 2, 3, 4, 5});
  });
  expect_refusal(
      "/events: found floating-point times without fractions, up to 1, expected times whose unit is stated",
      [](H5File& file) {
        file.numbers("/events", H5T_IEEE_F64LE, {1, 4}, {1, 2, 3, 1});
      });
  expect_refusal("the table /data/events (1 x 4), expected the order of its columns, --columns",
                 [](H5File& file) {
                   file.group("/data");
                   file.numbers("/data/events", H5T_STD_U32LE, {1, 4}, {1, 2, 3, 1});
                 });
  expect_refusal("found events of /a, events of /b, expected", [](H5File& file) {
    for (const std::string group : {"/a", "/b"}) {
      file.group(group.c_str());
      for (const char* name : {"/t", "/x", "/y", "/p"})
        file.numbers((group + name).c_str(), H5T_STD_U16LE, {1}, {1});
    }
  });
  expect_refusal("/events: found 1 dimensions", [](H5File& file) {
    file.numbers("/events", H5T_STD_U32LE, {4}, {1, 2, 3, 1});
  });
}

const std::vector<Event> of_layouts = {{1'500'000, 3, 4, true, 0}, {1'500'125, 345, 259, false, 0}};

TEST(Hdf5, OfTheCommonLayoutsGivesTheSameEvents) {
  const TempFolder folder;
  const auto path = folder / "a.h5";
  const auto columns = [](H5File& file, const std::string& group, const std::vector<const char*>& names,
                          hid_t time, hid_t polarity, double us_per_unit) {
    if (!group.empty()) file.group(group.c_str());
    file.reals((group + "/" + names[0]).c_str(), time, {2}, {1500000 / us_per_unit, 1500125 / us_per_unit});
    file.numbers((group + "/" + names[1]).c_str(), H5T_STD_U16LE, {2}, {3, 345});
    file.numbers((group + "/" + names[2]).c_str(), H5T_STD_I16LE, {2}, {4, 259});
    file.numbers((group + "/" + names[3]).c_str(), polarity, {2}, {1, 0});
  };
  const hid_t truth = numpy_bool();
  const auto expect_events = [&](const char* what, const auto& write) {
    {
      H5File file(path);
      write(file);
    }
    EXPECT_EQ(read_file(path), of_layouts) << what;
  };
  expect_events("DSEC with NumPy's bool", [&](H5File& file) {
    columns(file, "/events", {"t", "x", "y", "p"}, H5T_STD_U32LE, truth, 1);
  });
  expect_events("event_utils", [&](H5File& file) {
    columns(file, "/events", {"ts", "xs", "ys", "ps"}, H5T_IEEE_F64LE, truth, 1e6);
    file.attribute("sensor_resolution", {260, 346});
  });
  EXPECT_EQ(open_event_file(path)->image_size(), (ImageSize{346, 260}));
  expect_events("e2calib", [&](H5File& file) {
    columns(file, "", {"t", "x", "y", "p"}, H5T_STD_I64LE, H5T_STD_U8LE, 1);
  });
  expect_events("nanoseconds by name", [&](H5File& file) {
    columns(file, "/dvs", {"t_ns", "x", "y", "p"}, H5T_STD_I64LE, H5T_STD_U8LE, 1e-3);
  });
  expect_events("Metavision", [&](H5File& file) {
    file.group("/CD");
    file.records("/CD/events", {{1'500'000, 3, 4, 1}, {1'500'125, 345, 259, 0}});
    file.text_attribute("geometry", "346x260");
  });
  EXPECT_EQ(open_event_file(path)->image_size(), (ImageSize{346, 260}));
  EXPECT_EQ(open_event_file(path)->format(), "HDF5, events of /CD/events");
  H5Tclose(truth);
}

TEST(Hdf5, OfMvsecHasTablesOfBothCameras) {
  const TempFolder folder;
  {
    H5File file(folder / "a.hdf5");
    file.group("/davis");
    for (const char* eye : {"/davis/left", "/davis/right"}) {
      file.group(eye);
      const double later_s = eye == std::string("/davis/right") ? 50e-6 : 0.0;
      file.reals((eye + std::string("/events")).c_str(), H5T_IEEE_F64LE, {2, 4},
                 {3, 4, 1506117883.5 + later_s, 1, 345, 259, 1506117883.500125 + later_s, -1});
    }
  }
  const std::int64_t t = 1506117883500000;
  EXPECT_EQ(read_file(folder / "a.hdf5"), (std::vector<Event>{{t, 3, 4, true, 0},
                                                              {t + 50, 3, 4, true, 1},
                                                              {t + 125, 345, 259, false, 0},
                                                              {t + 175, 345, 259, false, 1}}));
}

TEST(Hdf5, TakesTheUnitAndTheOrderOfColumnsFromTheOptions) {
  const TempFolder folder;
  {
    H5File file(folder / "a.h5");
    file.group("/data");
    file.numbers("/data/events", H5T_STD_I64LE, {2, 4}, {3, 4, 1, 1'500'000'000, 345, 259, 0, 1'500'125'000});
  }
  EventReadOptions options;
  options.columns = "xypt";
  options.time_unit = TimeUnit::ns;
  EXPECT_EQ(read_file(folder / "a.h5", options), of_layouts);
}

TEST(Hdf5, WithTimesThatCanHardlyBeInUsOrWithPixelsThatAreNoWholeNumbersIsRefused) {
  const TempFolder folder;
  const auto message = [&](double x, const std::vector<std::int64_t>& times) -> std::string {
    {
      H5File file(folder / "a.h5");
      file.numbers("/t", H5T_STD_I64LE, {1}, times);
      file.reals("/x", H5T_IEEE_F64LE, {1}, {x});
      for (const char* name : {"/y", "/p"}) file.numbers(name, H5T_STD_I64LE, {1}, {1});
    }
    try {
      (void)read_file(folder / "a.h5");
    } catch (const InputError& error) {
      return error.what();
    }
    return "read";
  };
  EXPECT_EQ(message(2.0, {1'600'000'000'000'000}), "read");
  EXPECT_THAT(message(2.5, {1}), HasSubstr("event 0: found t 1, x 2.5, y 1, p 1, expected whole x and y"));
  EXPECT_THAT(message(2.0, {1'600'000'000'000'000'000}),
              AllOf(HasSubstr("event 0: found t 1600000000000000000"), HasSubstr("--time-unit")));
}

constexpr H5Z_filter_t blosc = 32001;

TEST(Hdf5, CompressedWithBloscWithoutThePluginIsAnErrorThatNamesThePlugin) {
  // The helper process inherits the environment; "::" keeps libhdf5 from loading plugins.
  ::setenv("HDF5_PLUGIN_PRELOAD", "::", 1);
  const TempFolder folder;
  const auto message = [&](H5Z_filter_t filter) -> std::string {
    {
      H5File file(folder / "a.h5");
      file.numbers("/events", H5T_STD_U32LE, {1, 4}, {1, 2, 3, 1}, 1, filter);
    }
    try {
      (void)open_event_file(folder / "a.h5");
    } catch (const InputError& error) {
      return error.what();
    }
    return "opened";
  };
  EXPECT_THAT(message(blosc), AllOf(HasSubstr("/events: found compression by the HDF5 filter 32001 (Blosc)"),
                                    HasSubstr("the package hdf5-filter-plugin-blosc-serial has it")));
  EXPECT_THAT(message(305), HasSubstr("/events: found compression by the HDF5 filter 305"));
  ::unsetenv("HDF5_PLUGIN_PRELOAD");
}

TEST(Hdf5, CompressedWithBloscIsReadWithThePlugin) {
#ifdef __SANITIZE_ADDRESS__
  const __lsan::ScopedDisabler the_plugin_leaks;
#endif
  if (H5Zfilter_avail(blosc) <= 0) GTEST_SKIP() << "SKIPPED: libhdf5 has no plugin for Blosc here";
  const TempFolder folder;
  std::vector<std::int64_t> values;
  std::vector<Event> events;
  for (std::int64_t i = 0; i < 5000; ++i) {
    values.insert(values.end(), {i, i % 640, i % 480, 1});
    events.push_back({i, static_cast<std::uint16_t>(i % 640), static_cast<std::uint16_t>(i % 480), true, 0});
  }
  {
    H5File file(folder / "a.h5");
    file.numbers("/events", H5T_STD_U32LE, {5000, 4}, values, 1000, blosc);
  }
  EXPECT_LT(std::filesystem::file_size(folder / "a.h5"), 5000u * 16u / 2u) << "it is not compressed";
  EXPECT_TRUE(read_file(folder / "a.h5") == events);
}

TEST(Hdf5, AnInvalidValueIsAnErrorAfterTheEventsBeforeIt) {
  const TempFolder folder;
  const auto path = folder / "a.h5";
  for (const std::vector<std::int64_t>& row :
       {std::vector<std::int64_t>{3, 65536, 1, 1}, {3, 1, -1, 1}, {3, 1, 1, 2}}) {
    {
      std::vector<std::int64_t> values = {1, 5, 6, 1, 2, 5, 6, 0};
      values.insert(values.end(), row.begin(), row.end());
      H5File file(path);
      file.numbers("/events", H5T_STD_I64LE, {3, 4}, values);
    }
    expect_events_then_error(path, {{1, 5, 6, true, 0}, {2, 5, 6, false, 0}}, "event 2: found t 3");
  }
}

TEST(Hdf5, RejectsToWriteWhatItCannotHoldAndLeavesNothing) {
  const TempFolder folder;
  for (const std::vector<Event>& events :
       {std::vector<Event>{{5, 0, 0, true, 0}, {4, 0, 0, true, 0}},
        std::vector<Event>{{5, 0, 0, true, 0}, {5 + (std::int64_t{1} << 32), 0, 0, true, 0}},
        std::vector<Event>{{5, 640, 0, true, 0}}, std::vector<Event>{{5, 0, 0, true, 1}}}) {
    const auto writer = create_event_file(folder / "a.h5", {640, 480});
    EXPECT_THROW(writer->write(events), InputError);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder / ""));
}

TEST(Hdf5, WithABrokenChunkGivesTheEventsBeforeIt) {
  const TempFolder folder;
  const auto path = folder / "a.h5";
  std::vector<std::int64_t> values;
  std::mt19937 random(1);
  for (std::int64_t i = 0; i < 3000; ++i) {
    for (const std::int64_t value :
         {i, static_cast<std::int64_t>(random() % 640), static_cast<std::int64_t>(random() % 480), i % 2}) {
      values.push_back(value);
    }
  }
  {
    H5File file(path);
    file.numbers("/events", H5T_STD_U32LE, {3000, 4}, values, 1000);
  }
  // gzip checks its sum at a stream's end; the third of the three streams is spoilt in its middle.
  std::string bytes = bytes_of(path);
  std::size_t third = 0;
  for (int i = 0; i < 3; ++i) third = bytes.find("\x78\x5e", third + 1);
  ASSERT_NE(third, std::string::npos);
  for (std::size_t i = third + 1000; i < third + 1100; ++i) bytes[i] = static_cast<char>(~bytes[i]);
  folder.write("a.h5", bytes);
  const auto reader = open_event_file(path);
  std::vector<Event> events;
  while (events.size() < 2000) ASSERT_GT(reader->read(events, 10'000), 0u);
  EXPECT_EQ(events.size(), 2000u);
  EXPECT_THAT([&] { (void)reader->read(events, 10); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("event 2000: found what libhdf5 cannot read ("),
                                              testing::Not(HasSubstr("read ()")))));
}

TEST(Hdf5, CutOffAnywhereIsRejected) {
  const TempFolder folder;
  write_file(folder / "whole.h5", sorted_events(1000, 300));
  const std::string whole = bytes_of(folder / "whole.h5");
  for (std::size_t length = 0; length < whole.size(); length += 1 + whole.size() / 150) {
    const auto path = folder.write("cut.h5", whole.substr(0, length));
    EXPECT_THROW((void)read_file(path), InputError) << length;
  }
  EXPECT_THROW((void)read_file(folder.write("cut.h5", whole.substr(0, whole.size() - 1))), InputError);
}

TEST(Hdf5, MayHoldNoEvents) {
  const TempFolder folder;
  write_file(folder / "a.h5", {});
  EXPECT_TRUE(read_file(folder / "a.h5").empty());
}

TEST(Hdf5, WithAnyByteChangedGivesEventsOrAnInputErrorAndNoCrash) {
  const TempFolder folder;
  write_file(folder / "whole.h5", sorted_events(1000, 300));
  const std::string whole = bytes_of(folder / "whole.h5");
  std::mt19937 random(7);
  int refused = 0, crashed = 0;
  const int files = 200;
  for (int i = 0; i < files; ++i) {
    std::string bytes = whole;
    // Most of what describes a file is at its start, and anywhere else too.
    const std::size_t at = random() % (i % 2 == 0 ? std::min<std::size_t>(2048, bytes.size()) : bytes.size());
    for (std::size_t k = 0; k < 1 + random() % 4 && at + k < bytes.size(); ++k) {
      bytes[at + k] = static_cast<char>(i % 3 == 0 ? 0xff : random());
    }
    const auto path = folder.write("broken.h5", bytes);
    try {
      EXPECT_LE(read_file(path).size(), 1'000'000u);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path.string()));
      ++refused;
      if (std::string(error.what()).find("libhdf5 failed") != std::string::npos) ++crashed;
    }
  }
  std::printf("%d of %d spoilt files refused, with %d libhdf5 crashed\n", refused, files, crashed);
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace saccade
