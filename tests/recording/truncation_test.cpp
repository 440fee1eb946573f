#include "tests/recording/read_events.h"
#include "tests/recording/small_files.h"

namespace saccade {
namespace {

class SmallFiles : public testing::TestWithParam<SmallFile> {};

TEST_P(SmallFiles, GiveTheirEventsWhateverTheBlock) {
  const TempFolder folder;
  const auto path = folder.write(GetParam().name, GetParam().bytes());
  for (const std::size_t block : {1, 2, 1000}) {
    EXPECT_EQ(read_all(*open_event_file(path), block), GetParam().events()) << block;
  }
}

TEST_P(SmallFiles, CutAtAnyByteGiveEveryEventBeforeTheCutAndThenAnErrorUnlessTheyLookWhole) {
  const TempFolder folder;
  const std::string whole = GetParam().bytes();
  std::size_t errors = 0;
  std::size_t piece = 0;
  std::size_t piece_begin = 0;
  std::vector<Event> before;  // of the pieces that are whole
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const auto& pieces = GetParam().pieces;
    while (piece_begin + pieces[piece].bytes.size() <= length) {
      piece_begin += pieces[piece].bytes.size();
      before.insert(before.end(), pieces[piece].events.begin(), pieces[piece].events.end());
      ++piece;
    }
    const bool looks_whole = length == piece_begin && piece > 0 && pieces[piece - 1].may_end;
    const auto path = folder.write(GetParam().name, std::string_view(whole).substr(0, length));
    std::vector<Event> read;
    bool failed = false;
    try {
      const auto reader = open_event_file(path);
      while (reader->read(read, 5) > 0) {
      }
    } catch (const InputError& error) {
      failed = true;
      ASSERT_EQ(error.problems().size(), 1u);
      EXPECT_THAT(error.problems()[0].place, testing::HasSubstr(path.string()));
      EXPECT_FALSE(error.problems()[0].value.empty() || error.problems()[0].expectation.empty());
    }
    EXPECT_EQ(failed, !looks_whole) << "cut at " << length;
    errors += failed ? 1 : 0;
    const std::vector<Event>& in_piece = pieces[piece].events;
    ASSERT_GE(read.size(), before.size()) << "cut at " << length;
    ASSERT_LE(read.size(), before.size() + in_piece.size()) << "cut at " << length;
    EXPECT_TRUE(std::equal(before.begin(), before.end(), read.begin())) << "cut at " << length;
    EXPECT_TRUE(
        std::equal(read.begin() + static_cast<std::ptrdiff_t>(before.size()), read.end(), in_piece.begin()))
        << "cut at " << length;
  }
  RecordProperty("errors", static_cast<int>(errors));
}

INSTANTIATE_TEST_SUITE_P(, SmallFiles, testing::ValuesIn(small_files()), [](const auto& tested) {
  std::string name = tested.param.name;
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
});

}  // namespace
}  // namespace saccade
