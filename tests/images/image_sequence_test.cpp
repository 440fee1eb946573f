#include "images/image_sequence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

#include "core/error.h"
#include "tests/images/npy.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr double white = 255.0;

/// What the call complains of; "accepted" where it does not.
template <class Call>
std::string complaint(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

class Images : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  /// Writes an image of one value.
  void save(const std::string& name, int type, const cv::Scalar& value, cv::Size size = {3, 2}) const {
    fs::create_directories(fs::path(path(name)).parent_path());
    setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
    ASSERT_TRUE(cv::imwrite(path(name), cv::Mat(size, type, value)));
  }
  /// The first pixel of every image.
  [[nodiscard]] std::vector<float> values(const std::string& name,
                                          std::span<const ImageTime> named = {}) const {
    const auto sequence = open_image_sequence(path(name), white, named);
    std::vector<float> image;
    std::vector<float> first;
    while (sequence->read(image)) first.push_back(image.at(0));
    return first;
  }
  [[nodiscard]] std::string complaint_of(const std::string& name) const {
    return complaint([&] { static_cast<void>(values(name)); });
  }

  TempFolder folder_;
};

TEST_F(Images, NumbersInNamesAreSortedByValueAndOtherFilesAreSkipped) {
  const char* const in_order[] = {"a9.PNG",       "frame2.png",   "frame10.png",
                                  "frame010.png", "frame10a.png", "frame99999999999999999999.png"};
  std::vector<float> expected;
  for (int i = 5; i >= 0; --i) save(std::string("shots/") + in_order[i], CV_8U, 40.0 * i);
  save(".hidden.png", CV_8U, 1);
  fs::rename(path(".hidden.png"), path("shots/.hidden.png"));
  folder_.write("shots/notes.txt", "no image");
  fs::create_directory(path("shots/sub.png"));
  // frame010 and frame10 are the same number: then the names decide, letter by letter.
  const auto sequence = open_image_sequence(path("shots"), white);
  EXPECT_EQ(sequence->info().count, 6);
  EXPECT_EQ(sequence->info().skipped_files, 3);
  EXPECT_FALSE(sequence->info().linear);
  std::vector<std::string> names;
  for (int i = 0; i < 6; ++i) names.push_back(fs::path(sequence->name_of(i)).filename());
  EXPECT_THAT(names, ElementsAre("a9.PNG, image 0", "frame2.png, image 1", "frame010.png, image 2",
                                 "frame10.png, image 3", "frame10a.png, image 4",
                                 "frame99999999999999999999.png, image 5"));
}

TEST_F(Images, IntegersAreSrgbAndBecomeLinearLight) {
  // Linear shares of white from the tables of the sRGB standard's transfer function.
  const std::pair<int, double> table[] = {{0, 0.0},         {1, 0.000303527}, {10, 0.00303527},
                                          {11, 0.00334654}, {55, 0.0382044},  {128, 0.215861},
                                          {188, 0.502886},  {255, 1.0}};
  double worst = 0.0;
  int k = 0;
  for (const auto& [level, share] : table) {
    save("a/" + std::to_string(k) + ".png", CV_8U, level);
    save("b/" + std::to_string(k) + ".png", CV_16U, level * 257);
    save("c/" + std::to_string(k++) + ".png", CV_8UC3, cv::Scalar::all(level));
  }
  const std::vector<float> grey = values("a");
  EXPECT_EQ(values("b"), grey);  // 16 bit: 257 times the level is the same light
  EXPECT_EQ(values("c"), grey);  // grey written as colour
  for (std::size_t i = 0; i < grey.size(); ++i) {
    worst = std::max(worst, std::abs(static_cast<double>(grey[i]) / white - std::data(table)[i].second));
  }
  std::printf("worst difference from the table: %.1e of white\n", worst);
  EXPECT_LT(worst, 1e-6);  // the table has six digits
  EXPECT_EQ(grey.back(), 255.0F);

  const auto brighter = open_image_sequence(path("a"), 1000.0);
  std::vector<float> image;
  while (brighter->read(image)) continue;
  EXPECT_EQ(image[0], 1000.0F);
}

TEST_F(Images, ColourBecomesLuminanceAfterItIsLinear) {
  save("8/0.png", CV_8UC3, {0, 0, 255});  // blue, green, red
  save("8/1.png", CV_8UC3, {0, 255, 0});
  save("8/2.png", CV_8UC3, {255, 0, 0});
  save("8/3.png", CV_8UC3, {0, 188, 188});
  save("8/4.png", CV_8UC4, {0, 188, 188, 7});  // alpha is left out
  const std::vector<float> light = values("8");
  EXPECT_NEAR(light[0], 0.2126 * white, 1e-4);
  EXPECT_NEAR(light[1], 0.7152 * white, 1e-4);
  EXPECT_NEAR(light[2], 0.0722 * white, 1e-4);
  EXPECT_NEAR(light[3], 0.502886 * (0.7152 + 0.2126) * white, 1e-3);
  EXPECT_EQ(light[4], light[3]);

  save("f/0.exr", CV_32FC3, {2.0, 30.0, 400.0});
  cv::imwrite(path("f/1.tiff"), cv::Mat(2, 3, CV_32FC3, cv::Scalar(2.0, 30.0, 400.0)),
              {cv::IMWRITE_TIFF_COMPRESSION, 1});  // without, OpenCV would round to LogLuv
  for (const float value : values("f")) {
    EXPECT_NEAR(value, 0.0722 * 2.0 + 0.7152 * 30.0 + 0.2126 * 400.0, 1e-4);
  }
}

TEST_F(Images, FloatsAreLinearLuminanceAlready) {
  // A different number in every pixel, so that rows, columns and images cannot be mixed up.
  std::vector<float> numbers(std::size_t{3} * 4 * 5);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    numbers[i] = std::exp2(static_cast<float>(i) - 30.0F) * 1.1F;
  fs::create_directory(path("exr"));
  fs::create_directory(path("tiff"));
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  for (std::size_t k = 0; k < 3; ++k) {
    const cv::Mat image(4, 5, CV_32F, numbers.data() + 20 * k);
    const std::string name = std::to_string(k);
    cv::imwrite(path("exr/" + name + ".exr"), image, {cv::IMWRITE_EXR_TYPE, cv::IMWRITE_EXR_TYPE_FLOAT});
    cv::imwrite(path("tiff/" + name + ".tiff"), image);
  }
  folder_.write("one.npy", npy_header("<f4", "3, 4, 5") + raw_bytes(numbers));
  const std::vector<double> doubles(numbers.begin(), numbers.end());
  folder_.write("two.npy", npy_header("<f8", "3, 4, 5,", 2) + raw_bytes(doubles));
  for (const char* name : {"exr", "tiff", "one.npy", "two.npy"}) {
    const auto sequence = open_image_sequence(path(name), white);
    EXPECT_EQ(sequence->info().size, (ImageSize{5, 4})) << name;
    EXPECT_EQ(sequence->info().count, 3) << name;
    EXPECT_TRUE(sequence->info().linear) << name;
    std::vector<float> image;
    std::vector<float> all;
    while (sequence->read(image)) all.insert(all.end(), image.begin(), image.end());
    EXPECT_EQ(all, numbers) << name;
  }
}

TEST_F(Images, IntegersInANumpyArrayAreLinearToo) {
  folder_.write("u1.npy", npy_header("|u1", "2, 1, 2") + raw_bytes<std::uint8_t>({0, 1, 200, 255}));
  folder_.write("u2.npy", npy_header("<u2", "2, 1, 2") + raw_bytes<std::uint16_t>({0, 1, 200, 65535}));
  EXPECT_THAT(values("u1.npy"), ElementsAre(0.0F, 200.0F));
  EXPECT_THAT(values("u2.npy"), ElementsAre(0.0F, 200.0F));
}

TEST_F(Images, AnInvalidNumpyArrayIsAnErrorWithTheReason) {
  const std::string data(48, '\0');  // 2 x 2 x 3 float32
  const std::string good = npy_header("<f4", "2, 2, 3") + data;
  struct Case {
    std::string bytes, says;
  };
  const Case cases[] = {
      {npy_header("<f4", "2, 2, 3", 1, "True") + data,
       "found an array in Fortran order, expected one in C order (numpy.ascontiguousarray)"},
      {npy_header(">f4", "2, 2, 3") + data,
       "found numbers of the type >f4, expected float32 (<f4), float64 (<f8), uint8 (|u1) or uint16 (<u2)"},
      {npy_header("<i8", "2, 2, 3") + data, "found numbers of the type <i8, expected float32"},
      {npy_header("<f4", "4, 3") + data,
       "found an array of 2 dimensions, expected three: images, height, width"},
      {npy_header("<f4", "1, 2, 2, 3") + data, "found an array of 4 dimensions"},
      {npy_header("<f4", "2, 0, 3") + data, "found images of 3 x 0, expected width and height in [1, 16384]"},
      {npy_header("<f4", "2, 2, 99999999999") + data, "found images of 99999999999 x 2"},
      {good.substr(0, good.size() - 1), "found 47 bytes of images, expected 2 images of 24 bytes"},
      {good + "abc", "found 51 bytes of images, expected 2 images of 24 bytes"},
      {npy_header("<f4", "9223372036854775807, 2, 3") + data,
       "found 48 bytes of images, expected 9223372036854775807 images of 24 bytes"},
      {npy_header("<f4", "-2, 2, 3") + data,
       "found the header {'descr': '<f4', 'fortran_order': False, 'shape': "},
      {npy_header("<f4', 'descr': '<f4", "2, 2, 3") + data, "found the header"},
      {npy_header("<f4", "2, 2, 3", 3) + data,
       "found version 3, expected a NumPy array (.npy of version 1 or 2)"},
      {good.substr(0, 40), "found a file that is cut off in its header"},
      {good.substr(0, 9), "found a file that is cut off in its header"},
      {"", "found another kind of file, expected a NumPy array"},
      {"P5 2 2 255\n1234", "found another kind of file, expected a NumPy array"}};
  for (const Case& wrong : cases) {
    folder_.write("a.npy", wrong.bytes);
    EXPECT_THAT(complaint_of("a.npy"), HasSubstr(path("a.npy") + ": " + wrong.says));
  }
  folder_.write("a.npy", good);
  EXPECT_EQ(complaint_of("a.npy"), "accepted");
}

TEST_F(Images, ImagesOfDifferentSizeOrTypeAreAnErrorWithTheirName) {
  save("size/1.png", CV_8U, 1);
  save("size/2.png", CV_8U, 1, {4, 2});
  EXPECT_EQ(complaint_of("size"),
            path("size/2.png") + ", image 1: found an image of 4x2, expected 3x2, as the first one");
  save("kind/1.png", CV_16U, 1);
  save("kind/2.tiff", CV_32F, 1);
  EXPECT_EQ(complaint_of("kind"),
            path("kind/2.tiff") + ", image 1: found float, expected 16 bit, as the first one");
  save("int/1.tiff", CV_32S, 1);
  EXPECT_THAT(complaint_of("int"), HasSubstr("expected 8 or 16 bit without a sign, or float"));
}

TEST_F(Images, AFileThatCannotBeDecodedIsAnErrorWithItsName) {
  EXPECT_EQ(complaint_of("nowhere"),
            path("nowhere") +
                ": found no such file or folder, expected a folder of images, a NumPy "
                "array (.npy) or a video");
  fs::create_directory(path("empty"));
  EXPECT_EQ(complaint_of("empty"),
            path("empty") +
                ": found an empty folder, expected images: .bmp .exr .jpeg .jpg .pgm .png .ppm .tif .tiff");
  folder_.write("empty/notes.txt", "");
  EXPECT_THAT(complaint_of("empty"), HasSubstr("found none among 1 files, expected images"));

  cv::Mat noise(64, 64, CV_8U);
  cv::theRNG().state = 1;
  cv::randu(noise, 0, 255);
  for (const std::string kind : {"png", "jpg", "bmp", "tiff"}) {
    fs::create_directory(path(kind));
    cv::imwrite(path(kind + "/1." + kind), noise);
    EXPECT_EQ(complaint_of(kind), "accepted");
    const std::string bytes = bytes_of(folder_ / (kind + "/1." + kind));
    folder_.write(kind + "/2." + kind, bytes.substr(0, bytes.size() / 2));
    EXPECT_THAT(complaint_of(kind), HasSubstr(path(kind + "/2." + kind) + ", image 1: found "));
    folder_.write(kind + "/2." + kind, "");
    EXPECT_THAT(complaint_of(kind), HasSubstr("found a file that cannot be decoded, expected a whole image"));
  }
  folder_.write("clip.mp4", "no video");
  EXPECT_EQ(complaint_of("clip.mp4"),
            path("clip.mp4") +
                ": found a file that cannot be decoded, expected a video, a NumPy array "
                "(.npy) or a folder of images");
}

TEST_F(Images, APgmMustHaveWhiteAt255Or65535) {
  fs::create_directory(path("a"));
  folder_.write("a/1.pgm", "P5\n# 2 3 4\n1 1\n# more\n65535\n\xff\xff");
  EXPECT_THAT(values("a"), ElementsAre(255.0F));
  folder_.write("a/1.pgm", std::string("P5 1 1 1023\n\x03\xff", 14));
  EXPECT_EQ(complaint_of("a"),
            path("a/1.pgm") + ", image 0: found white at 1023, expected white at 255 or 65535");
  folder_.write("a/1.pgm", "P2\n1 1 100\n50\n");
  EXPECT_THAT(complaint_of("a"), HasSubstr("found white at 100"));
}

TEST_F(Images, AVideoIsReadImageByImageWithItsRate) {
  const std::string name = path("ramp.avi");
  cv::VideoWriter video(name, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('F', 'F', 'V', '1'), 120.0, {16, 8});
  ASSERT_TRUE(video.isOpened());
  std::vector<float> expected;
  for (int k = 0; k < 20; ++k) {
    const cv::Mat image(8, 16, CV_8UC3, cv::Scalar::all(12 * k));
    video.write(image);
    save("png/" + std::to_string(k) + ".png", CV_8UC3, cv::Scalar::all(12 * k), {16, 8});
  }
  video.release();
  const auto sequence = open_image_sequence(name, white);
  EXPECT_EQ(sequence->info().size, (ImageSize{16, 8}));
  EXPECT_EQ(sequence->info().count, 20);
  EXPECT_DOUBLE_EQ(sequence->info().images_per_s.value_or(0.0), 120.0);
  EXPECT_EQ(values("ramp.avi"), values("png"));
}

/// The file of a video whose images are shown at other times: the times of a Matroska file's blocks are replaced, in ms.
void set_times(const std::string& name, const std::vector<std::int16_t>& times_ms) {
  std::string bytes = bytes_of(name);
  std::size_t image = 0;
  // SimpleBlock: id, a length of up to 8 bytes whose first one tells how many, track 1, the time from its cluster's.
  for (std::size_t at = bytes.find("\xa3"); at != std::string::npos; at = bytes.find("\xa3", at + 1)) {
    const auto first = static_cast<unsigned char>(bytes[at + 1]);
    const std::size_t length_bytes = static_cast<std::size_t>(std::countl_zero(first)) + 1;
    const std::size_t track = at + 1 + length_bytes;
    if (length_bytes > 8 || track + 3 >= bytes.size() || bytes[track] != '\x81' || image >= times_ms.size())
      continue;
    const auto old = static_cast<std::int16_t>(static_cast<unsigned char>(bytes[track + 1]) << 8 |
                                               static_cast<unsigned char>(bytes[track + 2]));
    if (old != static_cast<std::int16_t>(10 * image)) continue;  // other bytes
    bytes[track + 1] = static_cast<char>(times_ms[image] >> 8);
    bytes[track + 2] = static_cast<char>(times_ms[image] & 0xff);
    ++image;
  }
  ASSERT_EQ(image, times_ms.size());
  std::ofstream(name, std::ios::binary) << bytes;
}

TEST_F(Images, AVideoOfVariableRateHasTheTimesOfItsContainer) {
  const std::string name = path("ramp.mkv");
  const std::vector<std::int16_t> times_ms = {0, 10, 50, 61, 190, 200, 213, 300};
  cv::VideoWriter video(name, cv::CAP_FFMPEG, cv::VideoWriter::fourcc('F', 'F', 'V', '1'), 100.0, {16, 8});
  ASSERT_TRUE(video.isOpened());
  for (std::size_t k = 0; k < times_ms.size(); ++k)
    video.write(cv::Mat(8, 16, CV_8UC3, cv::Scalar::all(12.0 * static_cast<double>(k))));
  video.release();
  std::vector<float> luminance;
  {
    const auto regular = open_image_sequence(name, white);
    ASSERT_TRUE(regular->read(luminance));
    EXPECT_EQ(regular->time_us(), std::nullopt) << "at the video's rate";
  }
  set_times(name, times_ms);
  const auto sequence = open_image_sequence(name, white);
  EXPECT_EQ(sequence->info().count, std::ssize(times_ms));
  for (const std::int16_t time_ms : times_ms) {
    ASSERT_TRUE(sequence->read(luminance));
    EXPECT_EQ(sequence->time_us(), 1000 * time_ms);
  }
  EXPECT_FALSE(sequence->read(luminance));
}

TEST_F(Images, NamedImagesComeInTheOrderOfTheNames) {
  for (const int k : {1, 2, 3}) save("shots/" + std::to_string(k) + ".png", CV_8U, 85.0 * k);
  const ImageTime named[] = {
      {0, "3.png", "t.txt:1"}, {5, "1.png", "t.txt:2"}, {9, "../shots/2.png", "t.txt:3"}};
  const std::vector<float> sorted = values("shots");
  EXPECT_THAT(values("shots", named), ElementsAre(sorted[2], sorted[0], sorted[1]));
  const ImageTime missing[] = {{0, "3.png", "t.txt:1"}, {5, "4.png", "t.txt:2"}};
  EXPECT_EQ(complaint([&] { static_cast<void>(values("shots", missing)); }),
            "t.txt:2: found 4.png, expected the name of a file in " + path("shots"));
  folder_.write("a.npy", npy_header("<f4", "1, 1, 1") + std::string(4, '\0'));
  EXPECT_EQ(complaint([&] { static_cast<void>(values("a.npy", named)); }),
            "t.txt:1: found the name 3.png, expected times alone, for " + path("a.npy") + " is no folder");
}

std::vector<std::int64_t> times_of(const std::vector<ImageTime>& times) {
  std::vector<std::int64_t> t_us;
  for (const ImageTime& time : times) t_us.push_back(time.t_us);
  return t_us;
}

TEST_F(Images, TimesAreMicrosecondsOrSecondsWithAPoint) {
  folder_.write("us.txt", "# t\n-5\n0\n\n  7 \r\n1500000000000000\n");
  EXPECT_THAT(times_of(read_image_times(path("us.txt"))), ElementsAre(-5, 0, 7, 1500000000000000));
  folder_.write("s.txt", "0 a.png\n0.0000014,b c.png\n");
  EXPECT_THAT(
      complaint([&] { static_cast<void>(read_image_times(path("s.txt"))); }),
      HasSubstr("s.txt:2: found 0.0000014,b c.png, expected a time, or a time and the name of a file"));
  folder_.write("s.txt", "0 a.png\n0.0000014,b.png\n.5 c.png\n1500000000.123456\td.png");
  const std::vector<ImageTime> times = read_image_times(path("s.txt"));
  EXPECT_THAT(times_of(times), ElementsAre(0, 1, 500000, 1500000000123456));
  EXPECT_EQ(times[3].name, "d.png");
  EXPECT_EQ(times[3].place, path("s.txt") + ":4");
}

TEST_F(Images, TimesHaveTheUnitOfTheFirstLineOrOfTheOption) {
  const auto times = [&](const char* text, std::optional<TimeUnit> unit = {}) {
    folder_.write("t.csv", text);
    return times_of(read_image_times(path("t.csv"), unit));
  };
  EXPECT_THAT(times("#timestamp [ns],filename\n0,a.png\n1000000,b.png\n"), ElementsAre(0, 1000));
  EXPECT_THAT(times("\xEF\xBB\xBFt_ms\n0\n2.5\n"), ElementsAre(0, 2500));
  EXPECT_THAT(times("# timestamp filename\n0.5 a.png\n1.5 b.png\n"), ElementsAre(500000, 1500000));
  EXPECT_THAT(times("1600000000000000000\n1600000000000050000\n", TimeUnit::ns),
              ElementsAre(1600000000000000, 1600000000000050));
  EXPECT_THAT(times("0\n1\n", TimeUnit::s), ElementsAre(0, 1000000));
}

TEST_F(Images, TimesWithoutAUnitThatCanHardlyBeUsOrSAreRefusedWithTheOption) {
  for (const char* text : {"0\n1000000\n2000000\n", "0.0\n1000.0\n2000.0\n", "1600000000000000000\n"}) {
    folder_.write("t.txt", text);
    EXPECT_THAT(complaint([&] { static_cast<void>(read_image_times(path("t.txt"))); }),
                AllOf(HasSubstr(path("t.txt")), HasSubstr("--time-unit")));
  }
}

TEST_F(Images, InvalidTimesAreAnErrorWithFileAndLine) {
  const std::pair<const char*, const char*> cases[] = {
      {"1\n2\n2\n", ":3: found 2, expected a time after 2 us"},
      {"1\n# x\n0\n", ":3: found 0, expected a time after 1 us"},
      {"1\nx\n", ":2: found x, expected a time in us, or in seconds with a decimal point"},
      {"1e3\n", ":1: found 1e3, expected a time in us"},
      {"nan.\n", ":1: found nan., expected a time in us"},
      {"5000000000.0\n", ":1: found 5000000000.0, expected a time in us"},
      {"99999999999999999999\n", ":1: found 99999999999999999999, expected a time in us"},
      {"1\n2.5\n", ":2: found 2.5, expected us, as before"},
      {"0.5\n2\n", ":2: found 2, expected seconds with a decimal point, as before"},
      {"1 a.png\n2\n", ":2: found 2, expected a time and the name of a file, as before"},
      {"1\n2 a.png\n", ":2: found 2 a.png, expected a time alone, as before"},
      {"# none\n\n", ": found no times, expected a time per image, one a line"}};
  for (const auto& [text, says] : cases) {
    folder_.write("t.txt", text);
    EXPECT_THAT(complaint([&] { static_cast<void>(read_image_times(path("t.txt"))); }),
                HasSubstr(path("t.txt") + says));
  }
  EXPECT_THAT(complaint([&] { static_cast<void>(read_image_times(path("none.txt"))); }),
              HasSubstr("none.txt: found no such file, expected a file of times, one a line"));
}

}  // namespace
}  // namespace saccade
