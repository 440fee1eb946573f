// The command `saccade emulate`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "core/event.h"
#include "core/random.h"
#include "tests/images/npy.h"
#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

Outcome saccade(const std::string& arguments) { return run_shell("'" SACCADE_BINARY "' " + arguments); }

/// The ramp of the emulator's reference tests: +2.05 in ln within a second, from 20.
double ramp_at(double t_s) { return 20.0 * std::exp(2.05 * t_s); }
constexpr double step_us = 1e6 * 0.2 / 2.05;  ///< between its crossings

class Emulate : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }

  void write_npy(const std::string& name, ImageSize size, int images,
                 const std::function<double(std::size_t pixel, int image)>& luminance) const {
    std::vector<float> numbers;
    for (int k = 0; k < images; ++k) {
      for (std::size_t i = 0; i < static_cast<std::size_t>(size.pixels()); ++i)
        numbers.push_back(static_cast<float>(luminance(i, k)));
    }
    const std::string shape =
        std::to_string(images) + ", " + std::to_string(size.height) + ", " + std::to_string(size.width);
    folder_.write(name, npy_header("<f4", shape) + raw_bytes(numbers));
  }
  /// The ramp in images of 4 x 3 at a rate, over a second.
  void write_ramp(const std::string& name, double rate) const {
    write_npy(name, {4, 3}, static_cast<int>(rate) + 1,
              [&](std::size_t, int k) { return ramp_at(k / rate); });
  }
  /// Noise that changes every pixel.
  void write_noise(const std::string& name, ImageSize size, int images) const {
    const RandomStream random(3, "noise");
    write_npy(name, size, images, [&](std::size_t i, int k) {
      return random.uniform(5.0, 250.0, i, static_cast<std::uint64_t>(k / 4));
    });
  }

  [[nodiscard]] std::vector<Event> events_of(const std::string& name) const {
    std::vector<Event> events;
    std::istringstream lines(bytes_of(folder_ / name));
    std::string line;
    EXPECT_TRUE(std::getline(lines, line) && line == "t_us,x,y,p") << line;
    while (std::getline(lines, line)) {
      std::ranges::replace(line, ',', ' ');
      std::istringstream fields(line);
      Event e;
      int on = 0;
      fields >> e.t_us >> e.x >> e.y >> on;
      EXPECT_FALSE(fields.fail()) << line;
      e.on = on == 1;
      events.push_back(e);
    }
    return events;
  }
  /// Runs the command, which must succeed, and reads its events.
  [[nodiscard]] std::vector<Event> emulate(const std::string& images_and_options) const {
    const Outcome outcome = saccade("emulate " + images_and_options + " --force --out " + path("e.csv"));
    EXPECT_EQ(outcome.status, 0) << outcome.text;
    return events_of("e.csv");
  }
  /// Checks 10 ON events at every pixel of 4 x 3; returns the largest time error.
  [[nodiscard]] static double worst_crossing_us(const std::vector<Event>& events) {
    EXPECT_EQ(events.size(), 120U);
    std::map<std::pair<int, int>, int> count;
    double worst = 0.0;
    for (const Event& e : events) {
      EXPECT_TRUE(e.on);
      worst = std::max(worst, std::abs(static_cast<double>(e.t_us) - ++count[{e.x, e.y}] * step_us));
    }
    EXPECT_EQ(count.size(), 12U);
    for (const auto& [pixel, n] : count) EXPECT_EQ(n, 10) << pixel.first << ", " << pixel.second;
    return worst;
  }
  /// Status 2, the one message, and no file that was not there before.
  void expect_refused(const std::string& arguments, const std::string& message) const {
    const auto listing = [&] {
      std::vector<std::string> names;
      for (const auto& entry : fs::directory_iterator(folder_ / ".")) names.push_back(entry.path());
      std::ranges::sort(names);
      return names;
    };
    const auto before = listing();
    const Outcome outcome =
        saccade("emulate " + arguments + " --labels " + path("new_labels.csv") + " --out " + path("new.csv"));
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    EXPECT_THAT(outcome.text, HasSubstr("saccade: " + message + "\n"));
    EXPECT_EQ(listing(), before) << arguments;
  }

  TempFolder folder_;
};

TEST_F(Emulate, ARampGivesTheExactNumberOfEventsAtTheExactTimesWhateverTheImageRate) {
  for (const int rate : {50, 200, 1000}) {
    write_ramp("ramp.npy", rate);
    const double worst =
        worst_crossing_us(emulate(path("ramp.npy") + " --preset ideal --fps " + std::to_string(rate)));
    std::printf("%d images/s: 10 ON per pixel, worst time error %.2f us\n", rate, worst);
    EXPECT_LE(worst, 1.0);
  }
}

TEST_F(Emulate, SrgbPngImagesGiveTheEventsOfTheirLinearLight) {
  // The time error of half a grey level, at the image where a level is the largest step in ln.
  constexpr double rate = 50.0;
  fs::create_directory(path("png"));
  double bound_us = 0.0;
  for (int k = 0; k <= 50; ++k) {
    const double light = ramp_at(k / rate) / 255.0;
    const double srgb = 1.055 * std::pow(light, 1.0 / 2.4) - 0.055;  // all of the ramp is above 0.0031308
    cv::imwrite(path("png/" + std::to_string(k) + ".png"),
                cv::Mat(3, 4, CV_16U, cv::Scalar(std::round(65535 * srgb))));
    const double light_per_level = 2.4 / 1.055 * std::pow((srgb + 0.055) / 1.055, 1.4) / 65535.0;
    bound_us = std::max(bound_us, 0.5 * light_per_level / light / 2.05 * 1e6);
  }
  const double worst = worst_crossing_us(emulate(path("png") + " --preset ideal --fps 50"));
  std::printf("16-bit sRGB: worst time error %.2f us, half a grey level is %.2f us\n", worst, bound_us);
  EXPECT_LE(worst, bound_us + 1.0);
  EXPECT_LT(bound_us, 50.0);
}

TEST_F(Emulate, FloatImagesGiveTheSameBytesAsTheArray) {
  write_noise("noise.npy", {24, 16}, 40);
  const std::string numbers = bytes_of(folder_ / "noise.npy").substr(npy_header("<f4", "40, 16, 24").size());
  setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
  fs::create_directory(path("exr"));
  fs::create_directory(path("tiff"));
  for (std::size_t k = 0; k < 40; ++k) {
    std::vector<float> pixels(24 * 16);
    std::memcpy(pixels.data(), numbers.data() + k * 24 * 16 * 4, pixels.size() * 4);
    const cv::Mat image(16, 24, CV_32F, pixels.data());
    cv::imwrite(path("exr/" + std::to_string(k) + ".exr"), image);
    cv::imwrite(path("tiff/" + std::to_string(k) + ".tiff"), image);
  }
  const std::vector<Event> events = emulate(path("noise.npy") + " --fps 500");
  EXPECT_GT(events.size(), 1000U);
  EXPECT_EQ(emulate(path("exr") + " --fps 500"), events);
  EXPECT_EQ(emulate(path("tiff") + " --fps 500"), events);
  std::printf("%zu events, the same from .npy, EXR and TIFF\n", events.size());
}

TEST_F(Emulate, AVideoGivesTheEventsOfItsImagesAtItsRate) {
  cv::VideoWriter video(path("v.avi"), cv::CAP_FFMPEG, cv::VideoWriter::fourcc('F', 'F', 'V', '1'), 200.0,
                        {16, 8});
  ASSERT_TRUE(video.isOpened());
  fs::create_directory(path("png"));
  for (int k = 0; k < 60; ++k) {
    cv::Mat image(8, 16, CV_8UC3);
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 16; ++x)
        image.at<cv::Vec3b>(y, x) =
            cv::Vec3b::all(static_cast<unsigned char>(40 + (3 * k + 5 * x + 7 * y) % 180));
    }
    video.write(image);
    cv::imwrite(path("png/" + std::to_string(k) + ".png"), image);
  }
  video.release();
  const std::vector<Event> events = emulate(path("png") + " --fps 200");
  EXPECT_GT(events.size(), 500U);
  EXPECT_EQ(emulate(path("v.avi")), events);
  EXPECT_NE(emulate(path("v.avi") + " --fps 100"), events);
}

TEST_F(Emulate, TheSameSeedGivesTheSameBytesWhateverTheNumberOfThreads) {
  write_noise("noise.npy", {40, 30}, 60);
  const auto bytes = [&](const std::string& options) {
    const Outcome outcome =
        saccade("emulate " + path("noise.npy") + " --preset noisy --fps 300 --force --labels " +
                path("l.csv") + " --out " + path("e.aedat") + " " + options);
    EXPECT_EQ(outcome.status, 0) << outcome.text;
    return bytes_of(folder_ / "e.aedat") + bytes_of(folder_ / "l.csv");
  };
  const std::string first = bytes("--seed 5 --threads 1");
  EXPECT_GT(first.size(), 10000U);
  EXPECT_TRUE(bytes("--seed 5 --threads 1") == first);
  EXPECT_TRUE(bytes("--seed 5 --threads 2") == first);
  EXPECT_TRUE(bytes("--seed 5 --threads 3") == first);
  EXPECT_FALSE(bytes("--seed 6") == first);
  EXPECT_TRUE(bytes("") == bytes("--seed 1"));
}

TEST_F(Emulate, ImagesAtIrregularTimesGiveTheSameCrossings) {
  const std::int64_t times_us[] = {0, 1, 3000, 90000, 90002, 400123, 777777, 1000000};
  write_npy("ramp.npy", {4, 3}, 8,
            [&](std::size_t, int k) { return ramp_at(static_cast<double>(times_us[k]) * 1e-6); });
  std::string us = "# t_us\n";
  std::string seconds;
  for (const std::int64_t t : times_us) {
    us += std::to_string(t) + "\n";
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6f\n", static_cast<double>(t) * 1e-6);
    seconds += text.data();
  }
  folder_.write("us.txt", us);
  folder_.write("s.txt", seconds);
  const std::vector<Event> events =
      emulate(path("ramp.npy") + " --preset ideal --timestamps " + path("us.txt"));
  const double worst = worst_crossing_us(events);
  std::printf("irregular times: worst error %.2f us\n", worst);
  EXPECT_LE(worst, 1.0);
  EXPECT_EQ(emulate(path("ramp.npy") + " --preset ideal --timestamps " + path("s.txt")), events);
}

TEST_F(Emulate, TimesWithNamesChooseTheImages) {
  fs::create_directories(path("set/images"));
  for (int k = 0; k < 5; ++k)
    cv::imwrite(path("set/images/" + std::to_string(9 - k) + ".png"),
                cv::Mat(3, 4, CV_8U, cv::Scalar(40.0 * (k + 1))));
  folder_.write("set/images.txt",
                "0.0 images/9.png\n0.01 images/8.png\n0.02 images/7.png\n0.03 images/6.png\n");
  const std::vector<Event> events =
      emulate(path("set") + " --preset ideal --timestamps " + path("set/images.txt"));
  EXPECT_GT(events.size(), 12U * 10);
  EXPECT_TRUE(std::ranges::all_of(events, &Event::on));  // in the order of the names the images get darker
  EXPECT_LE(events.back().t_us, 30000);
}

TEST_F(Emulate, TheBusOfTheSensorSpreadsAJumpOfTheWholeImage) {
  write_npy("jump.npy", {128, 128}, 4, [](std::size_t, int k) { return k < 2 ? 50.0 : 64.3; });  // ln 0.2516
  folder_.write("t.txt", "0\n1000\n1001\n50000\n");
  const std::string run =
      path("jump.npy") + " --preset ideal --timestamps " + path("t.txt") + " --set readout_rate_hz=1e6";
  const std::vector<Event> events = emulate(run);
  ASSERT_EQ(events.size(), 16384U);
  std::printf("16384 events of one microsecond: the last one %lld us after the jump\n",
              static_cast<long long>(events.back().t_us - 1001));
  EXPECT_EQ(events.back().t_us, 1001 + 16384);
  EXPECT_EQ(std::ranges::adjacent_find(events, {}, &Event::t_us), events.end());

  const Outcome full =
      saccade("emulate " + run + " --set emulator.readout_queue_events=100 --out " + path("q.csv"));
  ASSERT_EQ(full.status, 0) << full.text;
  const auto figure = [&](const std::string& name) {
    const std::size_t at = full.text.find("\n" + name);
    return at == std::string::npos ? -1 : std::atoll(full.text.c_str() + at + 1 + name.size());
  };
  std::printf("a queue of 100: %lld events and %lld dropped\n", figure("events "), figure("dropped "));
  EXPECT_EQ(figure("events "), static_cast<long long>(events_of("q.csv").size()));
  EXPECT_EQ(figure("events ") + figure("dropped "), 16384);
  EXPECT_GT(figure("dropped "), 16000);
}

TEST_F(Emulate, EveryEventHasTheLabelOfItsCause) {
  write_ramp("ramp.npy", 200);
  const auto label_rows = [&](const std::string& options) {
    EXPECT_EQ(saccade("emulate " + path("ramp.npy") + " --fps 200 --force --labels " + path("l.csv") +
                      " --out " + path("e.csv") + " " + options)
                  .status,
              0);
    std::vector<std::string> rows;
    std::istringstream lines(bytes_of(folder_ / "l.csv"));
    for (std::string line; std::getline(lines, line);) rows.push_back(line);
    return rows;
  };
  const auto signal = label_rows("--preset ideal");
  ASSERT_EQ(signal.size(), 121U);
  EXPECT_EQ(signal[0], "t_us,x,y,p,cause");
  EXPECT_TRUE(std::all_of(signal.begin() + 1, signal.end(),
                          [](const std::string& row) { return row.ends_with(",signal"); }));
  // Without the labels' column the rows are those of the event file.
  const auto noisy = label_rows("--preset ideal --set hot_pixel_share=1 --set shot_noise_rate_hz=50");
  std::string events;
  std::map<std::string, int> causes;
  for (const std::string& row : noisy) {
    const std::size_t comma = row.rfind(',');
    events += row.substr(0, comma) + "\n";
    ++causes[row.substr(comma + 1)];
  }
  EXPECT_EQ(events, bytes_of(folder_ / "e.csv"));
  EXPECT_GT(causes["hot"], 500);  // 12 pixels, 100 per second each
  EXPECT_GT(causes["shot"], 50);
  std::printf("%d signal, %d shot, %d hot\n", causes["signal"], causes["shot"], causes["hot"]);
}

TEST_F(Emulate, TheSummaryListsInputAndOutput) {
  write_ramp("ramp.npy", 200);
  const Outcome outcome =
      saccade("emulate " + path("ramp.npy") + " --preset ideal --fps 200 --out " + path("e.aedat"));
  EXPECT_EQ(outcome.status, 0);
  EXPECT_THAT(outcome.text, HasSubstr("images         201, 4 x 3\n"
                                      "time           0 us to 1000000 us, 1.000000 s\n"
                                      "luminance      20 to 155.358\n"
                                      "events         120\n"
                                      "rate           120 events/s, 10 per second and pixel\n"
                                      "ON : OFF       120 : 0\n"
                                      "by cause       signal 120\n"
                                      "dropped        0\n" +
                                      path("e.aedat") + "\n"));
  // In a log: a line every tenth.
  EXPECT_THAT(outcome.text, HasSubstr("     1 of 201 images, "));
  EXPECT_THAT(outcome.text, HasSubstr("   101 of 201 images, "));
  EXPECT_EQ(std::ranges::count(outcome.text, '\n'), 11 + 9) << outcome.text;

  fs::create_directory(path("png"));
  for (const char* name : {"1.png", "2.png"})
    cv::imwrite(path(std::string("png/") + name), cv::Mat(3, 4, CV_8U, cv::Scalar(9)));
  folder_.write("png/notes.txt", "");
  EXPECT_THAT(saccade("emulate " + path("png") + " --fps 30 --out " + path("e.csv")).text,
              HasSubstr("skipped        1 that are no images\n"));
}

TEST_F(Emulate, ImagesInUnitsOfOneGetAHintToSetWhite) {
  write_npy("unit.npy", {4, 3}, 10, [](std::size_t, int k) { return 0.1 * k; });
  const std::string run = "emulate " + path("unit.npy") + " --fps 100 --force --out " + path("e.csv");
  const std::string hint =
      "luminance goes up to 0.9 and white is at 255; for images in 0..1 use white=1 and "
      "dark_current=0.04 (--set KEY=VALUE)\n";
  EXPECT_THAT(saccade(run).text, HasSubstr(hint));
  const Outcome followed = saccade(run + " --set white=1 --set dark_current=0.04");
  EXPECT_EQ(followed.status, 0);
  EXPECT_THAT(followed.text, Not(HasSubstr("white is at")));
  EXPECT_THAT(saccade(run + " --preset ideal").text, Not(HasSubstr("white is at")));  // no dark current
}

TEST_F(Emulate, TheCameraComesFromAFileWithItsKeysOrWithItsBlock) {
  write_ramp("ramp.npy", 200);
  folder_.write("keys.yaml", "preset: ideal\ncontrast_threshold_on: 0.5\n");
  folder_.write("block.yaml", "emulator:\n  preset: ideal\n  contrast_threshold_on: 0.5\n");
  const std::vector<Event> events =
      emulate(path("ramp.npy") + " --fps 200 --preset ideal --set contrast_threshold_on=0.5");
  EXPECT_EQ(events.size(), 12U * 4);
  for (const auto& [file, key] : {std::pair("keys.yaml", "emulator.contrast_threshold_on"),
                                  std::pair("block.yaml", "contrast_threshold_on")}) {
    const std::string run = path("ramp.npy") + " --fps 200 --config " + path(file);
    EXPECT_EQ(emulate(run), events);
    EXPECT_EQ(emulate(run + " --set " + key + "=0.2").size(), 120U);
  }
}

TEST_F(Emulate, ErrorsOfTheCameraNameFileLineAndKey) {
  write_ramp("ramp.npy", 4);
  const std::string run = path("ramp.npy") + " --fps 4 ";
  folder_.write("wrong.yaml", "preset: ideal\ncontrast_threshhold_on: 1\nlatency_us: many\n");
  expect_refused(run + "--config " + path("wrong.yaml"),
                 path("wrong.yaml") +
                     ":2: contrast_threshhold_on: found an unknown key, expected a known key; did you mean "
                     "contrast_threshold_on?\n" +
                     path("wrong.yaml") +
                     ":3: latency_us: found many, expected a whole number in [0, 1e+06]");
  folder_.write("wrong.yaml", "emulator:\n  leak_rate_hz: -1\n");
  expect_refused(
      run + "--config " + path("wrong.yaml"),
      path("wrong.yaml") + ":2: emulator.leak_rate_hz: found -1, expected a finite number in [0, 1000]");
  expect_refused(run + "--preset perfect",
                 "--set preset: found perfect, expected one of ideal, dvs128, noisy, davis346, atis, "
                 "few_events, asymmetric, davis240, gen3_vga, gen4_hd");
  expect_refused(run + "--set contrast_threshold_on=0",
                 "--set contrast_threshold_on: found 0, expected a finite number in [0.01, 5]");
}

TEST_F(Emulate, UnusableImagesAreRejectedAndNothingIsWritten) {
  const auto save = [&](const std::string& name, int columns) {
    fs::create_directories(fs::path(path(name)).parent_path());
    cv::imwrite(path(name), cv::Mat(3, columns, CV_8U, cv::Scalar(100)));
  };
  save("sizes/a1.png", 4);
  save("sizes/a2.png", 4);
  save("sizes/a3.png", 5);
  expect_refused(path("sizes") + " --fps 30",
                 path("sizes/a3.png") + ", image 2: found an image of 5x3, expected 4x3, as the first one");
  save("one/a1.png", 4);
  expect_refused(path("one") + " --fps 30", path("one") + ": found one image, expected at least two");
  fs::create_directory(path("empty"));
  expect_refused(
      path("empty") + " --fps 30",
      path("empty") +
          ": found an empty folder, expected images: .bmp .exr .jpeg .jpg .pgm .png .ppm .tif .tiff");
  save("broken/a1.png", 4);
  folder_.write("broken/a2.png", "no image");
  expect_refused(
      path("broken") + " --fps 30",
      path("broken/a2.png") + ", image 1: found a file that cannot be decoded, expected a whole image");
  expect_refused(
      path("nowhere"),
      path("nowhere") +
          ": found no such file or folder, expected a folder of images, a NumPy array (.npy) or a video");

  for (const auto& [value, text] : {std::pair(std::nan(""), "nan"), {-1.5, "-1.5"}, {HUGE_VAL, "inf"}}) {
    write_npy("bad.npy", {4, 3}, 5,
              [value = value](std::size_t i, int k) { return k == 3 && i == 6 ? value : 10.0 * (k + 1); });
    expect_refused(path("bad.npy") + " --fps 100 --preset ideal",
                   path("bad.npy") + ", image 3: image at 30000 us, pixel (2, 1): found " + text +
                       ", expected a finite luminance of at least 0");
  }
}

TEST_F(Emulate, TimesThatDoNotFitTheImagesAreRejected) {
  write_ramp("ramp.npy", 4);
  const std::string images = path("ramp.npy") + " ";
  expect_refused(images,
                 path("ramp.npy") + ": found images without times, expected --fps RATE or --timestamps FILE");
  expect_refused(images + "--fps 0", "--fps: found 0, expected a finite number in [0.001, 1e+06]");
  expect_refused(images + "--fps nan", "--fps: found nan, expected a finite number in [0.001, 1e+06]");
  expect_refused(images + "--fps 30 --seed -1", "--seed: found -1, expected a whole number in [0, 9e+15]");
  const auto with_times = [&](const std::string& text) {
    folder_.write("t.txt", text);
    return images + "--timestamps " + path("t.txt");
  };
  expect_refused(with_times("0\n1\n2\n3\n"),
                 path("t.txt") + ": found 4 times, expected 5, as many as there are images");
  expect_refused(with_times("0\n1\n2\n3\n4\n5\n"),
                 path("t.txt") + ": found 6 times, expected 5, as many as there are images");
  expect_refused(with_times("0\n1\n# pause\n0\n3\n4\n"),
                 path("t.txt") + ":4: found 0, expected a time after 1 us");
  EXPECT_EQ(
      saccade("emulate " + images + "--fps 30 --timestamps " + path("t.txt") + " --out " + path("e.csv"))
          .status,
      2);
}

TEST_F(Emulate, AnEarlierResultIsReplacedOnlyByACompleteOne) {
  write_ramp("ramp.npy", 50);
  const std::string run = "emulate " + path("ramp.npy") + " --preset ideal --fps 50 ";
  const std::string outputs = " --force --labels " + path("l.csv") + " --out " + path("e.csv");
  ASSERT_EQ(saccade(run + outputs).status, 0);
  const std::string events = bytes_of(folder_ / "e.csv");
  const std::string labels = bytes_of(folder_ / "l.csv");

  write_npy("bad.npy", {4, 3}, 9, [](std::size_t, int k) { return k < 8 ? 10.0 * (k + 1) : -1.0; });
  EXPECT_EQ(saccade("emulate " + path("bad.npy") + " --fps 50" + outputs).status, 2);
  EXPECT_EQ(bytes_of(folder_ / "e.csv"), events);
  EXPECT_EQ(bytes_of(folder_ / "l.csv"), labels);
  EXPECT_FALSE(fs::exists(path("e.csv.part")) || fs::exists(path("l.csv.part")));

  ASSERT_EQ(saccade(run + "--set contrast_threshold_on=0.5" + outputs).status, 0);
  EXPECT_EQ(events_of("e.csv").size(), 48U);
  EXPECT_NE(bytes_of(folder_ / "l.csv"), labels);
}

TEST_F(Emulate, AFileThatExistsIsReplacedWithForceOnly) {
  write_ramp("ramp.npy", 50);
  const std::string run = "emulate " + path("ramp.npy") + " --preset ideal --fps 50 ";
  ASSERT_EQ(saccade(run + "--out " + path("e.csv")).status, 0);
  const std::string events = bytes_of(folder_ / "e.csv");
  folder_.write("notes.txt", "years of work\n");
  for (const std::string& outputs : {"--out " + path("e.csv"), "--out " + path("notes.txt"),
                                     "--out " + path("new.csv") + " --labels " + path("notes.txt")}) {
    const Outcome refused = saccade(run + outputs + " --set contrast_threshold_on=0.5");
    EXPECT_EQ(refused.status, 2) << outputs;
    EXPECT_THAT(refused.text, HasSubstr("found a file that exists, expected another name, or --force"))
        << outputs;
  }
  EXPECT_EQ(bytes_of(folder_ / "e.csv"), events);
  EXPECT_EQ(bytes_of(folder_ / "notes.txt"), "years of work\n");
  EXPECT_FALSE(fs::exists(path("new.csv")));
  EXPECT_EQ(saccade(run + "--force --out " + path("notes.txt")).status, 0);
  EXPECT_EQ(events_of("notes.txt").size(), 120U);
}

TEST_F(Emulate, TheFileOfTimesIsNeverAnOutput) {
  write_ramp("ramp.npy", 1);
  folder_.write("times.txt", "0\n1000000\n");
  const Outcome refused = saccade("emulate " + path("ramp.npy") + " --preset ideal --force --timestamps " +
                                  path("times.txt") + " --out " + path("times.txt"));
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.text, HasSubstr("found the file that is read"));
  EXPECT_EQ(bytes_of(folder_ / "times.txt"), "0\n1000000\n");
}

TEST_F(Emulate, AnImpossibleOutputIsRejected) {
  write_ramp("ramp.npy", 50);
  const std::string run = "emulate " + path("ramp.npy") + " --preset ideal --fps 50 ";
  EXPECT_THAT(saccade(run + "--out " + path("e.csv") + " --labels " + path("e.csv")).text,
              HasSubstr("expected another file than the events'"));
  EXPECT_THAT(saccade(run + "--out " + path("e.mp4")).text,
              HasSubstr(path("e.mp4") +
                        ": found the extension .mp4, expected one of .aedat, .aedat4, .bag, .csv, .db3, "
                        ".h5, .hdf5, .log, .mcap, .npy, .npz, .raw, .txt\n"));
  EXPECT_EQ(saccade(run + "--out " + path("no/such/e.csv")).status, 1);
}

TEST_F(Emulate, AnInterruptEndsItAndNothingIsWritten) {
  // A sparse file of 13 GB of black images, so that the command does not reach its end.
  folder_.write("long.npy", npy_header("<f4", "200000, 128, 128"));
  fs::resize_file(path("long.npy"), fs::file_size(path("long.npy")) + std::uintmax_t{200000} * 128 * 128 * 4);
  const std::string part = path("e.csv.part");
  const Outcome outcome =
      run_shell("'" SACCADE_BINARY "' emulate " + path("long.npy") + " --fps 1000 --out " + path("e.csv") +
                " & pid=$!; while ! test -e " + part +
                " && kill -0 $pid; do sleep 0.01; done; kill -INT $pid; wait $pid");
  EXPECT_EQ(outcome.status, 1) << outcome.text;
  EXPECT_THAT(outcome.text, HasSubstr("saccade: interrupted; nothing was written\n"));
  EXPECT_FALSE(fs::exists(path("e.csv")) || fs::exists(part));
}

}  // namespace
}  // namespace saccade
