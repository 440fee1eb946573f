#include "robot/yarp/yarp_config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "core/error.h"

namespace saccade {
namespace {

using testing::HasSubstr;

std::string problem_of(const std::function<void(YarpConfig&)>& change) {
  YarpConfig config;
  change(config);
  try {
    check_config("yarp", config);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(YarpConfig, TheDefaultsAreValid) {
  EXPECT_EQ(problem_of([](YarpConfig&) {}), "");
  const EventTimelineConfig timeline = timeline_config(YarpCameraConfig{});
  EXPECT_EQ(timeline.image_size, (ImageSize{128, 128}));
  EXPECT_EQ(timeline.codec, AddressCodec::ev2);
  EXPECT_EQ(timeline.format, PacketFormat::packet);
}

TEST(YarpConfig, ANameIsAPathWithoutSpacesAndOnlyOptionalOnesCanBeMissing) {
  EXPECT_THAT(problem_of([](YarpConfig& c) { c.camera.port = "AE:o"; }), HasSubstr("yarp.camera.port"));
  EXPECT_THAT(problem_of([](YarpConfig& c) { c.camera.port = ""; }), HasSubstr("yarp.camera.port"));
  EXPECT_THAT(problem_of([](YarpConfig& c) { c.local = "/my robot"; }), HasSubstr("yarp.local"));
  EXPECT_THAT(problem_of([](YarpConfig& c) { c.head.part = "/icub/head/"; }), HasSubstr("yarp.head.part"));
  EXPECT_EQ(problem_of([](YarpConfig& c) { c.head.torso_part = ""; }), "");
}

TEST(YarpConfig, ACodecNeedsEnoughBitsForTheImage) {
  const auto size = [](int width, int height, const char* codec, bool swapped) {
    return problem_of([=](YarpConfig& c) {
      c.camera.width_px = width;
      c.camera.height_px = height;
      c.camera.codec = codec;
      c.camera.swap_xy = swapped;
    });
  };
  EXPECT_EQ(size(304, 240, "atis_20", false), "");
  EXPECT_THAT(size(304, 240, "atis_20", true), HasSubstr("room for the image's pixels"));
  EXPECT_THAT(size(304, 240, "dvs_128", false), HasSubstr("found dvs_128"));
  EXPECT_EQ(size(1280, 720, "ev2", false), "");
}

TEST(YarpConfig, TheEventReaderUsesTheConfiguredFormat) {
  YarpCameraConfig camera;
  camera.format = "vbottle";
  camera.codec = "dvs_128";
  camera.stamp_bits = 24;
  camera.swap_xy = camera.flip_y = true;
  const EventTimelineConfig timeline = timeline_config(camera);
  EXPECT_EQ(timeline.format, PacketFormat::vbottle);
  EXPECT_EQ(timeline.codec, AddressCodec::dvs_128);
  EXPECT_EQ(timeline.stamp_bits, 24);
  EXPECT_TRUE(timeline.swap_xy && timeline.flip_y && !timeline.flip_x);
}

}  // namespace
}  // namespace saccade
