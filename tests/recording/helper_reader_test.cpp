#include "recording/helper_reader.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <thread>

#include "core/error.h"
#include "tests/recording/counting_reader.h"
#include "tests/recording/read_events.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

std::unique_ptr<EventReader> fragile(std::int64_t count, const std::string& how,
                                     const std::string& limit_s = "60") {
  return open_in_helper("a.h5", "libfragile",
                        {SACCADE_FRAGILE_READER, {std::to_string(count), how, limit_s}});
}

const std::int64_t many = 100'000;

TEST(HelperReader, ReturnsTheEventsOfTheReaderInTheHelper) {
  const auto reader = fragile(many, "end");
  EXPECT_EQ(reader->format(), "counted");
  EXPECT_EQ(reader->image_size(), (ImageSize{300, 8}));
  CountingReader here(many, [] {});
  EXPECT_TRUE(read_all(*reader, 777) == read_all(here, 1000));
  std::vector<Event> none;
  EXPECT_EQ(reader->read(none, 10), 0u) << "a second read at the end";
}

/// Reads all and expects all events, and then, twice, an InputError.
void expect_all_then_error(EventReader& reader, const std::string& message) {
  std::vector<Event> events;
  while (events.size() < static_cast<std::size_t>(many)) reader.read(events, 3000);
  ASSERT_EQ(events.size(), static_cast<std::size_t>(many));
  EXPECT_EQ(events.back().t_us, many - 1);
  for (int again = 0; again < 2; ++again) {
    EXPECT_THAT([&] { (void)reader.read(events, 10); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("a.h5"), HasSubstr(message))));
  }
}

TEST(HelperReader, ACrashOfTheHelperIsAnErrorWithTheSignalAfterTheEvents) {
  expect_all_then_error(*fragile(many, "segv"), "libfragile failed (signal 11)");
  expect_all_then_error(*fragile(many, "abort"), "libfragile failed (signal 6)");
  expect_all_then_error(*fragile(many, "exit"), "libfragile failed (exit status 7)");
}

TEST(HelperReader, AHelperThatHangsIsEndedAtTheTimeLimit) {
  expect_all_then_error(*fragile(many, "hang", "1"), "libfragile failed (time limit)");
}

TEST(HelperReader, ABadMessageOfTheHelperIsAnError) {
  expect_all_then_error(*fragile(many, "nonsense"), "libfragile failed (bad message)");
}

TEST(HelperReader, ErrorsOfTheHelperAreThrownHere) {
  expect_all_then_error(*fragile(many, "bad input"), "rubbish, expected sense");
  EXPECT_THAT([] { (void)fragile(1, "open: bad input"); },
              ThrowsMessage<InputError>("a.h5: event 9: found rubbish, expected sense"));
  EXPECT_THAT([] { (void)fragile(1, "open: bus"); },
              ThrowsMessage<InputError>(HasSubstr("libfragile failed (signal 7)")));
  EXPECT_THROW((void)fragile(1, "open: no memory"), RunError);
}

TEST(HelperReader, MayBeDestroyedBeforeTheEndWhileAnotherOneReads) {
  auto first = fragile(many, "end");
  auto second = fragile(many, "end");
  std::vector<Event> events;
  EXPECT_EQ(first->read(events, 10), 10u);
  first.reset();
  EXPECT_EQ(read_all(*second).size(), static_cast<std::size_t>(many));
}

TEST(HelperReader, AProgramThatCannotBeStartedIsNamed) {
  EXPECT_THAT(
      [] {
        (void)open_in_helper("a.h5", "libfragile", {"/nowhere/reader", {}});
      },
      ThrowsMessage<RunError>(
          AllOf(HasSubstr("a.h5"), HasSubstr("/nowhere/reader"), HasSubstr("No such file"))));
  EXPECT_THAT([] { (void)find_helper("saccade-no-such-reader"); },
              ThrowsMessage<RunError>(HasSubstr("saccade-no-such-reader is missing; searched in /")));
}

std::atomic<int> forks = 0;

void write_h5(const std::filesystem::path& path, const std::vector<Event>& events) {
  const auto writer = create_event_file(path, {640, 480});
  writer->write(events);
  writer->commit();
}

TEST(HelperReader, Hdf5IsReadBesideOtherThreadsWithoutFork) {
  ASSERT_EQ(::pthread_atfork([] { ++forks; }, nullptr, nullptr), 0);
  const TempFolder folder;
  std::vector<Event> events;
  for (std::int64_t t = 0; t < 30'000; ++t) events.push_back({t, 3, 4, t % 2 == 0, 0});
  write_h5(folder / "a.h5", events);
  std::atomic<int> whole = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] { whole += read_file(folder / "a.h5") == events ? 1 : 0; });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(whole, 4);
  EXPECT_EQ(forks, 0) << "a forked process inherits locks that other threads hold";
}

TEST(HelperReader, TheHelperInheritsNoOpenFile) {
  const TempFolder folder;
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);  // without O_CLOEXEC
  const auto reader = fragile(many, "end");
  ::close(pipe[1]);
  ASSERT_EQ(::fcntl(pipe[0], F_SETFL, O_NONBLOCK), 0);
  char byte = 0;
  EXPECT_EQ(::read(pipe[0], &byte, 1), 0) << "nobody holds the other end";
  ::close(pipe[0]);
}

}  // namespace
}  // namespace saccade
