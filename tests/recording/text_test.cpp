#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "recording/format_registry.h"
#include "recording/recording_summary.h"
#include "tests/recording/read_events.h"
#include "tests/recording/small_files.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

TEST(TextEvents, HaveTheirCameraInAFifthColumn) {
  TempFolder folder;
  const std::vector<Event> expected = {{5, 1, 2, true, 0}, {6, 3, 4, false, 1}};
  const auto named = folder.write("named.csv", "t_us,x,y,p,camera\n5,1,2,1,0\n6,3,4,0,1\n");
  EXPECT_EQ(read_all(*open_event_file(named), 10), expected);
  const auto ordered = folder.write("ordered.txt", "0 1 2 5 1\n1 3 4 6 0\n");
  EXPECT_EQ(read_all(*open_event_file(ordered, {.columns = "cxytp", .image_size = {}, .camera = {}}), 10),
            expected);
  const auto third = folder.write("third.csv", "t_us,x,y,p,camera\n5,1,2,1,2\n");
  EXPECT_THROW((void)read_all(*open_event_file(third), 10), InputError);
}

TEST(TextEvents, MayBeSeparatedByBlanksTabsOrCommasWithCommentsAndAHeader) {
  TempFolder folder;
  const std::vector<Event> events = {{10, 3, 4, true, 0}, {12, 65535, 0, false, 0}, {12, 5, 6, false, 0}};
  for (const char* content :
       {"10 3 4 1\n12 65535 0 0\n12 5 6 -1\n", "10,3,4,1\r\n12,65535,0,0\r\n12,5,6,0\r\n",
        "# made by hand\n\nt_us,x,y,p\n10, 3, 4, 1\n12\t65535  0 0\n#\n 12 5 6 0",
        "\"timestamp\" \"x\" \"y\" \"polarity\"\n10 3 4 1\n12 65535 0 -1\n12 5 6 -1\n"}) {
    EXPECT_EQ(read_file(folder.write("a.txt", content)), events) << content;
  }
}

TEST(TextEvents, HaveTheirTimeInSecondsWhenItHasADecimalPoint) {
  TempFolder folder;
  const auto path = folder.write("a.txt",
                                 "0 1 1 1\n.5 1 1 1\n2.097134001 1 1 1\n2.09714 1 1 1\n2.0971454999 1 1 1\n"
                                 "2.0971455 1 1 1\n3. 1 1 1\n4.5e-1 1 1 1\n1605537493.718345 1 1 1\n"
                                 "-0.0000015 1 1 1\n");
  std::vector<std::int64_t> times;
  for (const Event& event : read_file(path)) times.push_back(event.t_us);
  EXPECT_THAT(times, testing::ElementsAre(0, 500000, 2097134, 2097140, 2097145, 2097146, 3000000, 450000,
                                          1605537493718345, -2));
}

TEST(TextEvents, ComeInAnotherColumnOrderByTheOption) {
  TempFolder folder;
  EventReadOptions options;
  options.columns = "xypt";
  const std::vector<Event> events = {{10, 3, 4, true, 0}};
  EXPECT_EQ(read_file(folder.write("a.csv", "3,4,1,10\n"), options), events);
  EXPECT_EQ(read_file(folder.write("a.csv", "x,y,p,t\n3,4,1,10\n"), options), events);
  options.columns = "xyt";
  EXPECT_THROW((void)open_event_file(folder / "a.csv", options), InputError);
}

TEST(TextEvents, GoBackInTimeWhereTheFileDoes) {
  TempFolder folder;
  const auto events = read_file(folder.write("a.txt", "10 1 1 1\n5 1 1 1\n"));
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[1].t_us, 5);
}

struct BrokenLine {
  std::string name;
  std::string line;
  std::string message;
};

class BrokenText : public testing::TestWithParam<BrokenLine> {};

TEST_P(BrokenText, GivesTheEventsBeforeItAndThenItsLine) {
  TempFolder folder;
  const auto path = folder.write("a.txt", "# c\n1 2 3 1\n2 2 3 1\n" + GetParam().line + "\n9 2 3 1\n");
  const auto reader = open_event_file(path);
  std::vector<Event> events;
  EXPECT_EQ(reader->read(events, 100), 2u);
  for (int again = 0; again < 2; ++again) {
    EXPECT_THAT([&] { (void)reader->read(events, 100); },
                testing::ThrowsMessage<InputError>(HasSubstr(path.string() + ":4" + GetParam().message)));
  }
  EXPECT_EQ(events.size(), 2u);
}

INSTANTIATE_TEST_SUITE_P(
    TextEvents, BrokenText,
    testing::Values(BrokenLine{"TooFew", "3 2 3", ": found 3 fields, expected 4"},
                    BrokenLine{"Unprintable", "3 2\xc2\xb5 3 1", ", column x: found 2.., expected"},
                    BrokenLine{"TooMany", "3 2 3 1 0", ": found 5 fields, expected 4"},
                    BrokenLine{"TrailingComma", "3,2,3,1,", ": found 5 fields, expected 4"},
                    BrokenLine{"EmptyField", "3,,3,1", ", column x: found nothing"},
                    BrokenLine{"WordForTime", "now 2 3 1", ", column t: found now"},
                    BrokenLine{"SecondsAmongMicroseconds", "3.5 2 3 1", ", column t: found 3.5, expected us"},
                    BrokenLine{"TimeTooLarge", "99999999999999999999 2 3 1", ", column t"},
                    BrokenLine{"SecondsTooLarge", "99999999999999.0 2 3 1", ", column t"},
                    BrokenLine{"TwoPoints", "1.2.3 2 3 1", ", column t"},
                    BrokenLine{"NegativeX", "3 -2 3 1", ", column x: found -2"},
                    BrokenLine{"LargeY", "3 2 65536 1", ", column y: found 65536"},
                    BrokenLine{"FractionX", "3 2.5 3 1", ", column x: found 2.5"},
                    BrokenLine{"Polarity", "3 2 3 2", ", column p: found 2"},
                    BrokenLine{"HeaderAgain", "t x y p", ", column t: found t"},
                    BrokenLine{"Endless", std::string(5000, ' ') + "3 2 3 1", ": found a line of more than"}),
    [](const auto& broken) { return broken.param.name; });

// ---- the lines in front of the events ------------------------------------------------------------

const std::vector<Event> two_text_events = {{10, 3, 4, true, 0}, {12, 5, 6, false, 0}};

TEST(TextEvents, ComeInTheOrderOfTheNamesWhereTheOptionHasNone) {
  const TempFolder folder;
  for (const char* content :
       {"x,y,p,t\n3,4,1,10\n5,6,0,12\n", "\xEF\xBB\xBFx;y;p;t\r\n3;4;1;10\r\n5;6;0;12\r\n",
        "# x y pol timestamp\n3 4 1 10\n5 6 0 12\n", "# columns: x, y, p, t\n3,4,1,10\n5,6,0,12\n",
        ",t,x,y,p\n0,10,3,4,True\n1,12,5,6,False\n", "%geometry:240,180\n3,4,1,10\n5,6,0,12\n",
        "%geometry:240,180\nt,x,y,p\n10,3,4,1\n12,5,6,0\n", "240 180\n10 3 4 1\n12 5 6 0\n",
        "p\tlabel\ty\tx\tt\n1\tball\t4\t3\t10\n-1\tnoise\t6\t5\t12\n",
        "t_us,x,y,p,cause\n10,3.0,4.0,1.0,signal\n12,5,6,0,noise\n", "10 3 4 1 7\n12 5 6 0 8\n",
        "Timestamp,X,Y,Polarity\n10,3,4,TRUE\n12,5,6,FALSE\n"}) {
    EXPECT_EQ(read_file(folder.write("a.csv", content)), two_text_events) << content;
  }
}

TEST(TextEvents, ThatAreNotAllReadSayWhichColumnsAreNot) {
  const TempFolder folder;
  EXPECT_EQ(open_event_file(folder.write("a.csv", "t_us,x,y,p,cause\n10,3,4,1,signal\n"))->skipped(),
            "column cause");
  EXPECT_THAT(open_event_file(folder.write("a.csv", "10 3 4 1 7\n"))->skipped(), HasSubstr("column 5"));
  EventReadOptions options;
  options.columns = "txyp_";
  EXPECT_EQ(read_file(folder.write("a.csv", "10 3 4 1 7\n12 5 6 0 7\n"), options), two_text_events);
}

TEST(TextEvents, HaveTheImageSizeOfALineOrOfAComment) {
  const TempFolder folder;
  for (const char* content :
       {"240 180\n0.000010 3 4 1\n", "%geometry:240,180\n3,4,1,10\n", "# geometry: 240x180\n10 3 4 1\n"}) {
    EXPECT_EQ(open_event_file(folder.write("a.txt", content))->image_size(), (ImageSize{240, 180}))
        << content;
  }
}

TEST(TextEvents, WhoseNamesContradictTheOptionOrLeaveTheOrderOpenAreRefusedWhenTheyAreOpened) {
  const TempFolder folder;
  EventReadOptions options;
  options.columns = "txyp";
  EXPECT_THAT([&] { (void)open_event_file(folder.write("a.csv", "x,y,p,t\n3,4,1,1\n"), options); },
              ThrowsMessage<InputError>(HasSubstr("the column order xypt, expected txyp")));
  EXPECT_THAT(
      [&] { (void)open_event_file(folder.write("a.csv", "zeit,spalte,zeile,vorzeichen\n3,4,1,1\n")); },
      ThrowsMessage<InputError>(AllOf(HasSubstr("a.csv:1: found the column names"), HasSubstr("--columns"))));
  EXPECT_THAT([&] { (void)open_event_file(folder.write("a.csv", "secs,nsecs,x,y,p\n3,4,1,1,1\n")); },
              ThrowsMessage<InputError>(HasSubstr("--columns")));
}

TEST(TextEvents, AreBrokenInsideAtAWholeWrongLineAndTornAtACutOne) {
  const TempFolder folder;
  const auto torn = [&](const char* content) {
    const auto path = folder.write("a.csv", content);
    return summarise_recording(built_in_formats(), path, {}, 1000).torn.value();
  };
  EXPECT_FALSE(torn("1 2 3 1\n2 2 x 1\n3 2 3 1\n").is_cut);
  EXPECT_TRUE(torn("1 2 3 1\n2 2").is_cut);
  EXPECT_TRUE(torn("1 2").is_cut);
  EXPECT_THROW((void)torn("1 2 3\n2 2 3 1\n"), InputError) << "the first line is wrong: another file";
}

TEST(TextEvents, InAZipFileAreReadLikeTheTextItself) {
  const TempFolder folder;
  EXPECT_THAT(
      [&] {
        (void)open_event_file(folder.write("a.zip", stored_zip({{"a.png", "png"}})));
      },
      ThrowsMessage<InputError>(AllOf(HasSubstr("a ZIP file of a.png"), HasSubstr("one text"))));
  EXPECT_THAT(
      [&] {
        (void)open_event_file(folder.write("a.zip", stored_zip({{"a.txt", "1"}, {"b.txt", "1"}})));
      },
      ThrowsMessage<InputError>(HasSubstr("a ZIP file of a.txt, b.txt")));
  const auto path = folder.write("a.zip", stored_zip({{"events/a.txt", "240 180\n10 3 4 1\n12 5 6 0\n"}}));
  EXPECT_EQ(read_file(path), two_text_events);
  EXPECT_EQ(open_event_file(path)->format(), "text in ZIP");
}

// ---- the unit of the time ------------------------------------------------------------------------

std::vector<std::int64_t> times_in(const std::filesystem::path& path, const EventReadOptions& options = {}) {
  std::vector<std::int64_t> times;
  for (const Event& event : read_file(path, options)) times.push_back(event.t_us);
  return times;
}

TEST(TextEvents, HaveTheUnitOfTheirColumnsName) {
  const TempFolder folder;
  const auto times = [&](const std::string& name, const char* first, const char* second) {
    return times_in(folder.write("a.csv", name + ",x,y,p\n" + first + ",1,1,1\n" + second + ",1,1,1\n"));
  };
  EXPECT_THAT(times("t_ns", "1600000000000000499", "1600000000000000500"),
              ElementsAre(1600000000000000, 1600000000000001));
  EXPECT_THAT(times("timestamp_ns", "-1500", "2000"), ElementsAre(-2, 2));
  EXPECT_THAT(times("#timestamp [ns]", "1000", "2000"), ElementsAre(1, 2));
  EXPECT_THAT(times("# time (ms)", "1000", "2000.0004"), ElementsAre(1000000, 2000000));
  EXPECT_THAT(times("t_ms", "1", "2.5"), ElementsAre(1000, 2500));
  EXPECT_THAT(times("t_s", "1", "2"), ElementsAre(1000000, 2000000));
  EXPECT_THAT(times("time_sec", "1", "2.5"), ElementsAre(1000000, 2500000));
  EXPECT_THAT(times("\"Timestamp [µs]\"", "1", "2"), ElementsAre(1, 2));
  EXPECT_THAT(times("t_us", "1", "2.5"), ElementsAre(1, 3));
  EXPECT_THAT(times("timestampNs", "1000", "2000"), ElementsAre(1, 2));
}

TEST(TextEvents, HaveTheUnitOfTheOptionBeforeThatOfTheName) {
  const TempFolder folder;
  EventReadOptions options;
  options.time_unit = TimeUnit::ns;
  EXPECT_THAT(times_in(folder.write("a.txt", "1600000000000050000 1 1 1\n"), options),
              ElementsAre(1600000000000050));
  EXPECT_THAT(times_in(folder.write("a.txt", "t_us x y p\n5000 1 1 1\n"), options), ElementsAre(5));
  options.time_unit = TimeUnit::us;
  EXPECT_THAT(times_in(folder.write("a.txt", "1600000000000050000 1 1 1\n"), options),
              ElementsAre(1600000000000050000));
  EXPECT_THAT(times_in(folder.write("a.txt", "5.0 1 1 1\n6.0 1 1 1\n"), options), ElementsAre(5, 6));
}

TEST(TextEvents, WithoutAUnitThatCanHardlyBeUsOrSAreRefusedWithTheOption) {
  const TempFolder folder;
  std::string slow;
  for (int i = 0; i < 12; ++i) slow += std::to_string(2 * i) + ".5 1 1 1\n";
  for (const std::string& content :
       {std::string("1600000000000000000 1 1 1\n"), std::string("5.0 1 1 1\n6.0 1 1 1\n"),
        std::string("1600000000000.5 1 1 1\n"), std::string("1.8e+04 1 1 1\n2.4e+04 1 1 1\n"), slow}) {
    EXPECT_THAT([&] { (void)open_event_file(folder.write("a.txt", content)); },
                ThrowsMessage<InputError>(AllOf(HasSubstr("a.txt:1, column t"), HasSubstr("--time-unit"))))
        << content;
  }
}

}  // namespace
}  // namespace saccade
