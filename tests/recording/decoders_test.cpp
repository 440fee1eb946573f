// The decoders of words, and the sources of bytes below the readers of files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <zlib.h>

#include <random>

#include "core/error.h"
#include "recording/decompressor.h"
#include "recording/event_packet.h"
#include "recording/evt21_decoder.h"
#include "recording/evt2_decoder.h"
#include "recording/evt3_decoder.h"
#include "recording/prophesee_header.h"
#include "recording/spawn_settings.h"
#include "recording/text_source.h"
#include "recording/unpacked_part.h"
#include "recording/yarp_codec.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

template <class Word>
std::string little_endian(std::initializer_list<Word> words) {
  std::string bytes;
  for (Word word : words) {
    for (std::size_t i = 0; i < sizeof(Word); ++i, word = static_cast<Word>(word >> 8U))
      bytes += static_cast<char>(word & 0xffU);
  }
  return bytes;
}

template <class Decoder>
std::vector<Event> decoded(Decoder& decoder, const std::string& bytes) {
  std::vector<Event> events(1000);
  events.resize(decoder.run(bytes, events).events);
  return events;
}

TEST(Evt2Decoder, ReadsTimePixelAndPolarity) {
  Evt2Decoder decoder(1'000'000);
  const auto events = decoded(
      decoder, little_endian<std::uint32_t>({
                   0x1000'0000U | 5U << 22U,  // ON before any time
                   0x8000'0000U | 3U,         // 3 x 64 us
                   0x1000'0000U | 5U << 22U | 7U << 11U | 9U, 0x0000'0000U | 6U << 22U | 8U << 11U | 10U,
                   0xb000'0000U,  // no such type
               }));
  EXPECT_THAT(events, ElementsAre(Event{1'000'197, 7, 9, true, 0}, Event{1'000'198, 8, 10, false, 0}));
  EXPECT_EQ(decoder.counts().events_without_time, 1);
  EXPECT_EQ(decoder.counts().undefined[0xb], 1);
}

TEST(Evt2Decoder, StopsWhereTheRoomEnds) {
  Evt2Decoder decoder;
  const std::string bytes =
      little_endian<std::uint32_t>({0x8000'0000U, 0x1000'0000U, 0x1000'0001U, 0x1000'0002U});
  std::array<Event, 2> out;
  const EvtStep step = decoder.run(bytes, out);
  EXPECT_EQ(step.words, 2U);
  EXPECT_EQ(step.events, 1U);
}

TEST(Evt21Decoder, ReadsThirtyTwoPixelsOfAWordInBothOrders) {
  const std::uint64_t time = 0x8ULL << 60U | 3ULL << 32U;
  const std::uint64_t word = 0x1ULL << 60U | 5ULL << 54U | 64ULL << 43U | 9ULL << 32U | 0x8000'0005U;
  for (const Evt21Order order : {Evt21Order::little, Evt21Order::legacy}) {
    Evt21Decoder decoder(0, order);
    std::string bytes = little_endian<std::uint64_t>({time, word});
    if (order == Evt21Order::legacy)
      bytes = bytes.substr(4, 4) + bytes.substr(0, 4) + bytes.substr(12, 4) + bytes.substr(8, 4);
    EXPECT_EQ(load_evt21(bytes.data(), order), time);
    EXPECT_THAT(decoded(decoder, bytes), ElementsAre(Event{197, 64, 9, true, 0}, Event{197, 66, 9, true, 0},
                                                     Event{197, 95, 9, true, 0}));
  }
}

TEST(Evt3Decoder, ReadsSinglePixelsAndVectors) {
  Evt3Decoder decoder;
  const auto events = decoded(decoder, little_endian<std::uint16_t>({
                                           Evt3::time_high << 12U | 1U,
                                           Evt3::time_low << 12U | 5U,
                                           Evt3::addr_y << 12U | 20U,
                                           Evt3::addr_x << 12U | 0x800U | 30U,
                                           Evt3::vect_base_x << 12U | 100U,
                                           Evt3::vect_12 << 12U | 0x801U,
                                           Evt3::vect_8 << 12U | 0x02U,
                                       }));
  EXPECT_THAT(events, ElementsAre(Event{4101, 30, 20, true, 0}, Event{4101, 100, 20, false, 0},
                                  Event{4101, 111, 20, false, 0}, Event{4101, 113, 20, false, 0}));
}

TEST(PacketDecoder, ReadsPacketsOfOneEncodingEach) {
  PacketDecoder decoder;
  std::vector<Event> events;
  const std::string mono = little_endian<std::uint64_t>({1ULL << 63U | 9ULL << 48U | 7ULL << 32U | 2'400U});
  EXPECT_FALSE(decoder.decode("mono", 5'000'000, mono, events));
  EXPECT_THAT(events, ElementsAre(Event{5'002, 7, 9, true, 0}));
  const auto broken = decoder.decode("mono", 0, mono.substr(1), events);
  EXPECT_TRUE(broken) << "no whole word";
  EXPECT_TRUE(decoder.decode("morse", 0, mono, events)) << "no such encoding";
}

TEST(StampUnwrapper, ContinuesACounterOverItsWraps) {
  StampUnwrapper known(80, 24);
  EXPECT_EQ(known.extend(0xff'fff0, std::nan("")), 0xff'fff0);
  EXPECT_EQ(known.extend(0x10, std::nan("")), 0x100'0010);
  StampUnwrapper with_host(80, 24);  // wraps every 1.34 s
  (void)with_host.extend(0, 100.0);
  EXPECT_EQ(with_host.extend(100, 100.0 + 3 * 0x100'0000 * 80e-9), 3 * 0x100'0000 + 100);
}

TEST(PropheseeHeader, HasKeysInLowerCaseAndTheSize) {
  TempFolder folder;
  InputFile file(folder.write("a.raw", "% Evt 3.0\n% geometry 1280x720\n% end\nrest"));
  const PropheseeHeader header(file);
  EXPECT_EQ(header.value("evt"), "3.0");
  EXPECT_EQ(header.value("date"), "");
  EXPECT_EQ(header.image_size(), (ImageSize{1280, 720}));
  EXPECT_EQ(file.peek(4), "rest");
}

TEST(PropheseeHeader, RefusesOneWithoutAnEnd) {
  TempFolder folder;
  InputFile file(folder.write("a.raw", "% evt 3.0\n% geometry 12"));
  EXPECT_THROW(PropheseeHeader{file}, InputError);
}

std::string random_text(std::size_t bytes) {
  std::mt19937 random(1);
  std::string text;
  while (text.size() < bytes) text += static_cast<char>('a' + random() % 4);
  return text;
}

std::string deflated(const std::string& text) {
  std::string bytes(compressBound(static_cast<uLong>(text.size())) + 64, '\0');
  z_stream stream{};
  EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, -15, 8, Z_DEFAULT_STRATEGY), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
  stream.avail_in = static_cast<uInt>(text.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  bytes.resize(stream.total_out);
  deflateEnd(&stream);
  return bytes;
}

TEST(Decompressor, UnpacksPieceByPiece) {
  const std::string text = random_text(5'000);
  const std::string packed = deflated(text);
  const auto decompressor = make_deflate_decompressor();
  decompressor->begin();
  std::string unpacked;
  std::array<char, 7> out;
  for (std::string_view left = packed; !left.empty() || decompressor->unfinished();) {
    const auto step = decompressor->run(left.substr(0, 11), out);
    ASSERT_EQ(step.error, nullptr);
    ASSERT_TRUE(step.read + step.written > 0);
    unpacked.append(out.data(), step.written);
    left.remove_prefix(step.read);
  }
  EXPECT_EQ(unpacked, text);
}

TEST(Decompressor, ReportsBytesThatAreNoFrame) {
  for (const auto& decompressor :
       {make_lz4_decompressor(), make_zstd_decompressor(), make_bzip2_decompressor()}) {
    decompressor->begin();
    std::array<char, 64> out;
    EXPECT_NE(decompressor->run("this is no frame at all", out).error, nullptr);
  }
}

TEST(UnpackedPart, IsAPartOfAFileAsUnpackedBytes) {
  TempFolder folder;
  const std::string text = random_text(200'000);
  const std::string packed = deflated(text);
  InputFile file(folder.write("a.bin", packed + "after"));
  UnpackedPart part(file);
  part.begin(make_deflate_decompressor(), packed.size());
  EXPECT_EQ(part.peek(10).substr(0, 10), text.substr(0, 10));
  EXPECT_TRUE(part.discard(150'000));
  std::string rest;
  EXPECT_TRUE(read_bytes(part, 50'000, rest));
  EXPECT_EQ(rest, text.substr(150'000));
  EXPECT_TRUE(part.over());
  EXPECT_EQ(part.crc(),
            crc32(0, reinterpret_cast<const Bytef*>(text.data()), static_cast<uInt>(text.size())));
  EXPECT_EQ(file.peek(5), "after");
}

TEST(UnpackedPart, FailsWhereTheFileEndsInIt) {
  TempFolder folder;
  const std::string packed = deflated(random_text(50'000));
  InputFile file(folder.write("a.bin", packed.substr(0, packed.size() / 2)));
  UnpackedPart part(file);
  part.begin(make_deflate_decompressor(), packed.size());
  const auto read = [&] {
    while (!part.peek(1).empty()) part.skip(1);
  };
  EXPECT_THROW(read(), InputError);
}

TEST(TextSource, IsTheFileItselfWhereItIsNoZip) {
  TempFolder folder;
  TextSource text(InputFile(folder.write("a.txt", "one\ntwo\n")));
  EXPECT_FALSE(text.is_in_zip());
  EXPECT_EQ(text.peek(100), "one\ntwo\n");
  text.skip(4);
  EXPECT_EQ(text.peek(1), "two\n");
  EXPECT_THAT(text.name(), HasSubstr("a.txt"));
}

/// Exit status of a program with standard output in a file.
int run(SpawnSettings& settings, std::vector<std::string> words) {
  pid_t child = 0;
  EXPECT_EQ(settings.start(std::move(words), child), 0);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  return WEXITSTATUS(status);
}

TEST(SpawnSettings, StartAProgramInAFolderWithItsOutput) {
  TempFolder folder;
  const std::string out = (folder / "out").string();
  std::FILE* const file = std::fopen(out.c_str(), "w");
  SpawnSettings settings;
  settings.use_nothing(0);
  settings.use(fileno(file), 1);
  settings.work_in((folder / "").string());
  EXPECT_EQ(run(settings, {"sh", "-c", "pwd; cat; exit 3"}), 3);
  std::fclose(file);
  EXPECT_THAT(bytes_of(out), HasSubstr("saccade_test_"));
}

TEST(SpawnSettings, ReportAProgramThatIsNotThere) {
  SpawnSettings settings;
  pid_t child = 0;
  EXPECT_EQ(settings.start({"/no/such/program"}, child), ENOENT);
}

}  // namespace
}  // namespace saccade
