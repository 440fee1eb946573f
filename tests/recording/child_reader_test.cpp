#include "recording/child_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>

#include "core/error.h"
#include "tests/recording/read_events.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// Gives a number of events, each at the time of its own number, and then does something.
class CountingReader final : public EventReader {
 public:
  CountingReader(std::int64_t count, std::function<void()> then) : count_(count), then_(std::move(then)) {}
  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t more = 0;
    for (; more < max_events && next_ < count_; ++more, ++next_) {
      events.push_back({next_, static_cast<std::uint16_t>(next_ % 300), 7, next_ % 3 == 0,
                        static_cast<std::uint8_t>(next_ % 2)});
    }
    if (more == 0) then_();
    return more;
  }
  std::optional<ImageSize> image_size() const override { return ImageSize{300, 8}; }
  std::string format() const override { return "counted"; }

 private:
  std::int64_t count_;
  std::function<void()> then_;
  std::int64_t next_ = 0;
};

std::unique_ptr<EventReader> counting(std::int64_t count, const std::function<void()>& then,
                                      unsigned patience_s = 60) {
  return open_in_child(
      "a.h5", "libfragile", [&] { return std::make_unique<CountingReader>(count, then); }, patience_s);
}

const std::int64_t many = 100'000;

TEST(ChildReader, GivesWhatTheReaderInTheChildGives) {
  const auto reader = counting(many, [] {});
  EXPECT_EQ(reader->format(), "counted");
  EXPECT_EQ(reader->image_size(), (ImageSize{300, 8}));
  CountingReader here(many, [] {});
  EXPECT_TRUE(read_all(*reader, 777) == read_all(here, 1000));
  std::vector<Event> none;
  EXPECT_EQ(reader->read(none, 10), 0u) << "an end stays one";
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

TEST(ChildReader, OutlivesAChildThatCrashesAndNamesTheSignal) {
  expect_all_then_error(*counting(many, [] { ::kill(::getpid(), SIGSEGV); }),
                        "libfragile failed (signal 11)");
  expect_all_then_error(*counting(many, [] { std::abort(); }), "libfragile failed (signal 6)");
  expect_all_then_error(*counting(many, [] { ::_exit(7); }), "libfragile failed (exit status 7)");
}

TEST(ChildReader, EndsAChildThatFindsNoEnd) {
  expect_all_then_error(*counting(
                            many,
                            [] {
                              for (;;) ::pause();
                            },
                            1),
                        "libfragile failed (it found no end)");
}

TEST(ChildReader, PassesOnWhatTheChildThrows) {
  expect_all_then_error(*counting(many, [] { throw InputError("a.h5: event 9", "rubbish", "sense"); }),
                        "rubbish, expected sense");
  EXPECT_THAT(
      [] {
        (void)open_in_child("a.h5", "libfragile", []() -> std::unique_ptr<EventReader> {
          throw InputError("a.h5", "nothing", "something");
        });
      },
      ThrowsMessage<InputError>("a.h5: found nothing, expected something"));
  EXPECT_THAT(
      [] {
        (void)open_in_child("a.h5", "libfragile", []() -> std::unique_ptr<EventReader> {
          ::raise(SIGBUS);
          return nullptr;
        });
      },
      ThrowsMessage<InputError>(HasSubstr("libfragile failed (signal 7)")));
  EXPECT_THAT(
      [] {
        (void)open_in_child("a.h5", "libfragile",
                            []() -> std::unique_ptr<EventReader> { throw std::bad_alloc(); });
      },
      testing::Throws<RunError>());
}

TEST(ChildReader, MayBeLeftInTheMiddleAndBesideOthers) {
  auto first = counting(many, [] {});
  auto second = counting(many, [] {});
  std::vector<Event> events;
  EXPECT_EQ(first->read(events, 10), 10u);
  first.reset();
  EXPECT_EQ(read_all(*second).size(), static_cast<std::size_t>(many));
}

}  // namespace
}  // namespace saccade
