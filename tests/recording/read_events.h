#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "core/error.h"
#include "recording/event_file.h"
#include "tests/recording/temp_folder.h"

namespace saccade {

inline std::vector<Event> read_all(EventReader& reader, std::size_t block = 1000) {
  std::vector<Event> events;
  while (reader.read(events, block) > 0) {
  }
  return events;
}

inline std::vector<Event> read_file(const std::filesystem::path& path, const EventReadOptions& options = {}) {
  return read_all(*open_event_file(path, options));
}

/// Whether the file gives exactly these events and then, twice, an error with this message.
inline void expect_events_then_error(const std::filesystem::path& path, const std::vector<Event>& events,
                                     const std::string& message) {
  const auto reader = open_event_file(path);
  std::vector<Event> read;
  if (!events.empty()) {
    EXPECT_EQ(reader->read(read, events.size() + 100), events.size());
  }
  for (int again = 0; again < 2; ++again) {
    EXPECT_THAT([&] { (void)reader->read(read, 100); },
                testing::ThrowsMessage<InputError>(
                    testing::AllOf(testing::HasSubstr(path.string()), testing::HasSubstr(message))));
  }
  EXPECT_EQ(read, events);
}

/// How many of the files that begin like `whole` end in an InputError; each gives a beginning of `events`.
inline std::size_t count_errors_of_cut_files(const std::string& whole, const std::vector<Event>& events) {
  const TempFolder folder;
  std::size_t errors = 0;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const auto path = folder.write("cut", std::string_view(whole).substr(0, length));
    std::vector<Event> read;
    try {
      const auto reader = open_event_file(path);
      while (reader->read(read, 5) > 0) {
      }
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), testing::HasSubstr(path.string()));
      ++errors;
    }
    const bool is_beginning =
        read.size() <= events.size() && std::equal(read.begin(), read.end(), events.begin());
    EXPECT_TRUE(is_beginning) << "cut at " << length;
  }
  return errors;
}

/// Recordings that are not part of the repository.
class RealRecording : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(SACCADE_SHARED_DATA)) {
      GTEST_SKIP() << "SKIPPED: the real recordings are not at " SACCADE_SHARED_DATA;
    }
  }
  static std::filesystem::path path_of(const std::string& name) {
    return std::filesystem::path(SACCADE_SHARED_DATA) / name;
  }
  static std::vector<Event> read_real(const std::string& name) { return read_file(path_of(name)); }
};

}  // namespace saccade
