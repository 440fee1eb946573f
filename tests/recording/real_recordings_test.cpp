#include "tests/recording/read_events.h"

namespace saccade {
namespace {

struct Known {
  std::string file;
  std::string format;
  std::optional<ImageSize> size;
  std::size_t count;
  std::vector<Event> first;
  Event last;
};

/// Their counts and events were found by other decoders.
class KnownRecording : public RealRecording, public testing::WithParamInterface<Known> {};

TEST_P(KnownRecording, HasItsCountAndItsFirstAndLastEvents) {
  const auto reader = open_event_file(path_of(GetParam().file));
  EXPECT_EQ(reader->format(), GetParam().format);
  EXPECT_EQ(reader->image_size(), GetParam().size);
  const auto events = read_all(*reader);
  ASSERT_EQ(events.size(), GetParam().count);
  EXPECT_EQ(std::vector<Event>(events.begin(), events.begin() + 5), GetParam().first);
  EXPECT_EQ(events.back(), GetParam().last);
}

TEST_P(KnownRecording, ReadsBackTheSameFromTheWritersThatHoldAnyImage) {
  const auto reader = open_event_file(path_of(GetParam().file));
  const ImageSize size = reader->image_size().value_or(ImageSize{1280, 720});
  const auto events = read_all(*reader);
  const TempFolder folder;
  for (const char* name : {"a.aedat4", "a.raw", "a.log"}) {
    const auto writer = create_event_file(folder / name, size);
    writer->write(events);
    writer->commit();
    EXPECT_TRUE(read_file(folder / name) == events) << name;
    std::printf(
        "%s as %s: %.2f bytes per event\n", GetParam().file.c_str(), name,
        static_cast<double>(std::filesystem::file_size(folder / name)) / static_cast<double>(events.size()));
  }
}

INSTANTIATE_TEST_SUITE_P(, KnownRecording,
                         testing::Values(Known{"ball_looming_dvs128_aedat2.aedat",
                                               "AEDAT 2.0 DVS128 (guessed)",
                                               ImageSize{128, 128},
                                               314716,
                                               {{913454806, 46, 51, true, 0},
                                                {913457458, 109, 42, true, 0},
                                                {913460877, 121, 35, true, 0},
                                                {913461052, 72, 104, true, 0},
                                                {913466951, 75, 81, true, 0}},
                                               {1000887418, 85, 74, true, 0}},
                                         Known{"hand_wave_dvs128_lz4.aedat4",
                                               "AEDAT 4.0 LZ4",
                                               ImageSize{128, 128},
                                               348461,
                                               {{1718924384950507, 37, 96, true, 0},
                                                {1718924384950510, 25, 20, true, 0},
                                                {1718924384950529, 44, 56, true, 0},
                                                {1718924384950556, 46, 44, false, 0},
                                                {1718924384950614, 23, 107, false, 0}},
                                               {1718924390340512, 15, 76, false, 0}},
                                         Known{"head_dvxplorer320x240_lz4.aedat4",
                                               "AEDAT 4.0 LZ4",
                                               ImageSize{320, 240},
                                               111954,
                                               {{1605537493718345, 154, 204, false, 0},
                                                {1605537493718348, 149, 206, false, 0},
                                                {1605537493718349, 148, 199, true, 0},
                                                {1605537493718354, 139, 30, false, 0},
                                                {1605537493718360, 130, 181, true, 0}},
                                               {1605537494308262, 88, 237, true, 0}},
                                         Known{"spinning_dot_gen3vga_evt2.raw",
                                               "EVT2",
                                               std::nullopt,
                                               539481,
                                               {{1317888, 237, 121, true, 0},
                                                {1317888, 246, 121, true, 0},
                                                {1317888, 248, 132, true, 0},
                                                {1317888, 239, 133, true, 0},
                                                {1317888, 256, 134, true, 0}},
                                               {1367888, 210, 142, true, 0}},
                                         Known{"driving_gen41hd_evt3.raw",
                                               "EVT3",
                                               std::nullopt,
                                               219596,
                                               {{11718656, 874, 200, false, 0},
                                                {11718656, 806, 200, true, 0},
                                                {11718656, 882, 201, false, 0},
                                                {11718656, 1085, 201, true, 0},
                                                {11718656, 1235, 201, true, 0}},
                                               {11727457, 1218, 572, true, 0}},
                                         Known{"ncars_car_atis_dat2.dat",
                                               "DAT 2",
                                               std::nullopt,
                                               4407,
                                               {{0, 6, 18, true, 0},
                                                {66, 42, 35, false, 0},
                                                {89, 38, 19, false, 0},
                                                {94, 27, 24, true, 0},
                                                {95, 41, 38, true, 0}},
                                               {99937, 48, 47, true, 0}},
                                         Known{"plane_synthetic_es2_dvs.es",
                                               "Event Stream 2 DVS",
                                               ImageSize{320, 240},
                                               473225,
                                               {{0, 0, 0, true, 0},
                                                {0, 1, 0, true, 0},
                                                {0, 2, 0, true, 0},
                                                {0, 3, 0, true, 0},
                                                {0, 4, 0, true, 0}},
                                               {999000, 38, 193, true, 0}}),
                         [](const auto& known) {
                           return known.param.file.substr(
                               0, known.param.file.find('_', known.param.file.find('_') + 1));
                         });

TEST_F(RealRecording, TheDigitOfNmnistHasItsCountAndItsFirstAndLastTimes) {
  const auto events = read_real("nmnist_sample.bin");
  ASSERT_EQ(events.size(), 4325u);
  EXPECT_EQ(events.front(), (Event{654, 7, 15, true, 0}));
  EXPECT_EQ(events.back().t_us, 311175);
}

TEST_F(RealRecording, TheHeadHasItsOtherStreamsCounted) {
  const auto reader = open_event_file(path_of("head_dvxplorer320x240_lz4.aedat4"));
  (void)read_all(*reader);
  EXPECT_EQ(reader->skipped(), "59 packets of stream 2 (IMUS)");
}

}  // namespace
}  // namespace saccade
