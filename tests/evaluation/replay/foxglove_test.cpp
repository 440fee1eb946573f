// MCAP files of runs for Foxglove: what they hold is what the folder holds. tests/python/foxglove_test.py reads them with other
// projects' readers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <zstd.h>

#include <csignal>
#include <cstring>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/error.h"
#include "evaluation/replay/foxglove_file.h"
#include "evaluation/replay/foxglove_scene.h"
#include "evaluation/replay/foxglove_schemas.h"
#include "evaluation/replay/foxglove_track.h"
#include "evaluation/replay/foxglove_writer.h"
#include "recording/array_file.h"
#include "recording/byte_order.h"
#include "recording/event_file.h"
#include "recording/format_registry.h"
#include "recording/mcap_codec.h"
#include "recording/mcap_file.h"
#include "recording/output_file.h"
#include "tests/evaluation/report/synthetic_run.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

std::string plain_bytes(const std::string& base64_text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : base64_text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count);
  }
  return bytes;
}

/// The messages of an MCAP file in their order, read as mcap.dev/spec has it.
struct ReadMcap {
  struct Message {
    std::string topic;
    std::uint64_t log_ns = 0;
    json content;
  };
  struct Topic {
    std::string schema;
    std::string encoding;
    json schema_content;
  };
  std::vector<Message> messages;
  std::map<std::string, Topic> topics;

  explicit ReadMcap(const std::filesystem::path& file) {
    const std::string bytes = bytes_of(file);
    EXPECT_EQ(bytes.substr(0, mcap_mark.size()), mcap_mark);
    EXPECT_EQ(bytes.substr(bytes.size() - mcap_mark.size()), mcap_mark);
    read(std::string_view(bytes).substr(mcap_mark.size(), bytes.size() - 2 * mcap_mark.size()));
  }
  [[nodiscard]] std::vector<const Message*> of(const std::string& topic) const {
    std::vector<const Message*> found;
    for (const Message& message : messages) {
      if (message.topic == topic) found.push_back(&message);
    }
    return found;
  }
  [[nodiscard]] std::set<std::string> names() const {
    std::set<std::string> names;
    for (const auto& [name, topic] : topics) names.insert(name);
    return names;
  }

 private:
  struct Fields {
    std::string_view bytes;
    template <class T>
    T number() {
      const T value = load_little<T>(bytes.data());
      bytes.remove_prefix(sizeof(T));
      return value;
    }
    std::string text() {
      const auto count = number<std::uint32_t>();
      std::string text(bytes.substr(0, count));
      bytes.remove_prefix(count);
      return text;
    }
  };

  void read(std::string_view bytes) {
    while (!bytes.empty()) {
      const auto op = static_cast<McapOp>(bytes[0]);
      const auto count = load_little<std::uint64_t>(bytes.data() + 1);
      record(op, {bytes.substr(9, count)});
      bytes.remove_prefix(9 + count);
    }
  }
  void record(McapOp op, Fields fields) {
    if (op == McapOp::schema) {
      const auto id = fields.number<std::uint16_t>();
      Topic& schema = schemas_[id];
      schema.schema = fields.text();
      EXPECT_EQ(fields.text(), "jsonschema");
      schema.schema_content = json::parse(fields.text());
    } else if (op == McapOp::channel) {
      const auto id = fields.number<std::uint16_t>();
      Topic topic = schemas_.at(fields.number<std::uint16_t>());
      channels_[id] = fields.text();
      topic.encoding = fields.text();
      topics[channels_[id]] = topic;
    } else if (op == McapOp::message) {
      Message message;
      message.topic = channels_.at(fields.number<std::uint16_t>());
      fields.bytes.remove_prefix(4);
      message.log_ns = fields.number<std::uint64_t>();
      EXPECT_EQ(fields.number<std::uint64_t>(), message.log_ns);
      message.content = json::parse(fields.bytes);
      messages.push_back(std::move(message));
    } else if (op == McapOp::chunk) {
      fields.bytes.remove_prefix(16);
      std::string plain(fields.number<std::uint64_t>(), '\0');
      fields.bytes.remove_prefix(4);
      EXPECT_EQ(fields.text(), "zstd");
      const auto stored = fields.number<std::uint64_t>();
      EXPECT_EQ(ZSTD_decompress(plain.data(), plain.size(), fields.bytes.data(), stored), plain.size());
      read(plain);
    }
  }

  std::map<std::uint16_t, Topic> schemas_;
  std::map<std::uint16_t, std::string> channels_;
};

std::int64_t time_ns(const json& stamp) {
  return stamp.at("sec").get<std::int64_t>() * 1'000'000'000 + stamp.at("nsec").get<std::int64_t>();
}

/// Whether a value is as a JSON schema demands it: types, required members, lengths of lists.
void expect_valid(const json& value, const json& schema, const std::string& place) {
  const std::string type = schema.at("type");
  const bool is_type = type == "object"    ? value.is_object()
                       : type == "array"   ? value.is_array()
                       : type == "string"  ? value.is_string()
                       : type == "boolean" ? value.is_boolean()
                       : type == "integer" ? value.is_number_integer()
                                           : value.is_number();
  ASSERT_TRUE(is_type) << place << " is no " << type << ": " << value;
  if (type == "object") {
    for (const json& name : schema.value("required", json::array()))
      EXPECT_TRUE(value.contains(name)) << place << "." << name;
    for (const auto& [name, member] : value.items()) {
      ASSERT_TRUE(schema.at("properties").contains(name)) << place << "." << name;
      expect_valid(member, schema.at("properties").at(name), std::string(place).append(".").append(name));
    }
  } else if (type == "array") {
    EXPECT_GE(value.size(), schema.value("minItems", 0U)) << place;
    for (const json& item : value) expect_valid(item, schema.at("items"), place + "[]");
  }
}

std::vector<Event> events_of(const std::filesystem::path& file) {
  std::vector<Event> events;
  const auto reader = open_event_file(file);
  while (reader->read(events, 10'000) > 0) {
  }
  return events;
}

TEST(McapFile, HoldsTheMessagesOfItsChannelsInChunks) {
  const TempFolder folder;
  {
    OutputFile out(folder / "a.mcap");
    McapFile file(out, "");
    const std::uint16_t first = file.add_schema("one", "jsonschema", R"({"type":"object"})");
    const std::uint16_t second = file.add_schema("two", "jsonschema", R"({"type":"array"})");
    const std::uint16_t a = file.add_channel(second, "/a", "json");
    const std::uint16_t b = file.add_channel(first, "/b", "json");
    const std::string long_text = "[\"" + std::string(600'000, 'x') + "\"]";
    for (std::uint64_t i = 0; i < 5; ++i)
      file.write({.channel = a, .log_ns = 10 * i, .publish_ns = 10 * i}, long_text);
    file.write({.channel = b, .log_ns = 50, .publish_ns = 50}, "{}");
    file.finish();
    out.commit();
  }
  const ReadMcap read(folder / "a.mcap");
  EXPECT_EQ(read.of("/a").size(), 5U);
  ASSERT_EQ(read.of("/b").size(), 1U);
  EXPECT_EQ(read.of("/b")[0]->log_ns, 50U);
  EXPECT_EQ(read.topics.at("/a").schema, "two");
  EXPECT_EQ(read.topics.at("/b").schema, "one");
  EXPECT_LT(std::filesystem::file_size(folder / "a.mcap"), 100'000U) << "compressed";
}

TEST(FoxgloveWriter, RefusesTimesThatMcapDoesNotHave) {
  const TempFolder folder;
  OutputFile out(folder / "a.mcap");
  FoxgloveWriter writer(out);
  const std::size_t topic = writer.add_plain("/a", "a", {{"x"}, {"v", PlainMember::Kind::vector}});
  writer.write(topic, 1'234'567'891, {{"timestamp", foxglove_time(1'234'567'891)}, {"x", 1.5}});
  EXPECT_THAT([&] { writer.write(topic, -1, {}); },
              ThrowsMessage<InputError>(HasSubstr("found a time of -1 us, expected times from 0")));
  writer.finish();
  out.commit();
  const ReadMcap read(folder / "a.mcap");
  ASSERT_EQ(read.messages.size(), 1U);
  EXPECT_EQ(read.messages[0].log_ns, 1'234'567'891'000U);
  EXPECT_EQ(time_ns(read.messages[0].content.at("timestamp")), 1'234'567'891'000);
}

TEST(TableCursor, FindsTheNewestRowThatIsNotTooOld) {
  const TempFolder folder;
  folder.write("truth.csv", "t_us,x_px,y_px,r_px\n1000,1,1,1\n2000,2,2,2\n9000,9,9,9\n");
  TableCursor<TruthRow> rows(folder / "truth.csv");
  EXPECT_EQ(rows.newest(999, 5000), nullptr);
  EXPECT_EQ(rows.newest(2500, 5000)->circle.x_px, 2.0);
  EXPECT_EQ(rows.newest(8000, 5000), nullptr) << "6 ms old";
  EXPECT_EQ(rows.next_us(), 9000);
  EXPECT_EQ(rows.take().circle.x_px, 9.0);
  EXPECT_EQ(rows.next_us(), std::nullopt);
  TableCursor<TruthRow> none(folder / "none.csv");
  EXPECT_EQ(none.newest(1000, 1000), nullptr);
}

class FoxgloveFile : public testing::Test {
 protected:
  void SetUp() override { metrics_ = write_synthetic_run(run(), false, 1, 400); }

  [[nodiscard]] std::filesystem::path run() const { return folder_ / "run"; }
  [[nodiscard]] std::filesystem::path file() const { return folder_ / "run.mcap"; }
  FoxgloveSummary write(double images_hz = foxglove_images_hz) const {
    return write_foxglove(run(), built_in_formats(), images_hz, file());
  }
  void expect_refused(const std::string& message) const {
    EXPECT_THAT([&] { write(); }, ThrowsMessage<InputError>(HasSubstr(message)));
    EXPECT_FALSE(std::filesystem::exists(file()));
    EXPECT_FALSE(std::filesystem::exists(file().string() + ".part"));
  }

  TempFolder folder_;
  Metrics metrics_;
};

TEST_F(FoxgloveFile, HasAMessageForEveryRowThatItsSchemaPermits) {
  const FoxgloveSummary summary = write();
  const ReadMcap read(file());
  EXPECT_THAT(read.names(),
              ElementsAre("/gaze", "/gaze/scene", "/joints", "/left/calibration", "/left/circles",
                          "/left/detections/paper_directed", "/left/detections/paper_full",
                          "/left/event_counts", "/left/events", "/left/truth", "/tf"));
  EXPECT_EQ(read.topics.at("/left/events").schema, "foxglove.CompressedImage");
  EXPECT_EQ(read.topics.at("/left/circles").schema, "foxglove.ImageAnnotations");
  EXPECT_EQ(read.topics.at("/left/calibration").schema, "foxglove.CameraCalibration");
  EXPECT_EQ(read.topics.at("/tf").schema, "foxglove.FrameTransforms");
  EXPECT_EQ(read.topics.at("/gaze/scene").schema, "foxglove.SceneUpdate");
  std::uint64_t last_ns = 0;
  for (const auto& message : read.messages) {
    ASSERT_GE(message.log_ns, last_ns) << message.topic;
    last_ns = message.log_ns;
    const auto& topic = read.topics.at(message.topic);
    ASSERT_EQ(topic.encoding, "json");
    expect_valid(message.content, topic.schema_content, message.topic);
    if (message.content.contains("timestamp")) {
      ASSERT_EQ(time_ns(message.content.at("timestamp")), static_cast<std::int64_t>(message.log_ns));
    }
  }
  EXPECT_EQ(last_ns, 400'000'000U);
  EXPECT_EQ(read.of("/left/events").size(), 12U);
  EXPECT_EQ(read.of("/left/circles").size(), 12U);
  EXPECT_EQ(read.of("/left/event_counts").size(), 400U);
  EXPECT_EQ(read.of("/left/truth").size(), 400U);
  EXPECT_EQ(read.of("/gaze").size(), 400U);
  EXPECT_EQ(read.of("/tf").size(), 40U);
  EXPECT_EQ(read.of("/left/detections/paper_full").size() + read.of("/left/detections/paper_directed").size(),
            read_table<DetectionRow>(run() / "detections.csv").size());
  EXPECT_EQ(summary.messages, static_cast<std::int64_t>(read.messages.size()));
  EXPECT_EQ(summary.events, metrics_.event_count);
  EXPECT_EQ(summary.late_events, 0);
  // The gaze error is the angle that the tables give.
  const auto eye = read_table<EyeRow>(run() / "eye.csv")[299];
  const auto ball = read_table<TruthRow>(run() / "truth.csv")[299];
  const Eigen::Vector3d direction = (ball.position_m - eye.position_m).normalized();
  const double cosine = eye.root_from_left_cam().linear().col(2).dot(direction);
  EXPECT_NEAR(read.of("/gaze")[299]->content.at("error_deg").get<double>(),
              std::acos(cosine) * 180.0 / std::numbers::pi, 1e-6);
}

TEST_F(FoxgloveFile, EachImageShowsTheEventsSinceTheOneBefore) {
  write(40.0);
  const ReadMcap read(file());
  const std::vector<Event> events = events_of(run() / metrics_.events_file);
  const auto images = read.of("/left/events");
  ASSERT_EQ(images.size(), 16U);
  const cv::Vec3b on(on_colour.blue, on_colour.green, on_colour.red);
  const cv::Vec3b off(off_colour.blue, off_colour.green, off_colour.red);
  std::int64_t last_us = metrics_.start_us;
  for (const auto* const message : images) {
    const auto t_us = static_cast<std::int64_t>(message->log_ns / 1000);
    EXPECT_EQ(t_us, last_us + 25'000);
    EXPECT_EQ(message->content.at("format"), "png");
    const std::string png = plain_bytes(message->content.at("data"));
    const cv::Mat image = cv::imdecode(std::vector<char>(png.begin(), png.end()), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(image.size(), cv::Size(128, 128));
    ASSERT_EQ(image.type(), CV_8UC3);
    cv::Mat expected(128, 128, CV_8UC3, cv::Scalar::all(0));
    int shown = 0;
    for (const Event& event : events) {
      if (event.t_us > last_us && event.t_us <= t_us)
        expected.at<cv::Vec3b>(event.y, event.x) = event.on ? on : off;
    }
    for (int y = 0; y < 128; ++y) {
      for (int x = 0; x < 128; ++x) {
        const cv::Vec3b& found = image.at<cv::Vec3b>(y, x);
        const cv::Vec3b& wanted = expected.at<cv::Vec3b>(y, x);
        const bool has_event = wanted != cv::Vec3b(0, 0, 0);
        shown += has_event ? 1 : 0;
        ASSERT_EQ(has_event ? found == wanted : found != on && found != off, true) << x << " " << y;
      }
    }
    EXPECT_GT(shown, 200);
    last_us = t_us;
  }
  // The counts of the milliseconds are those of the file.
  std::int64_t on_count = 0;
  std::int64_t count = 0;
  for (const auto* const message : read.of("/left/event_counts")) {
    on_count += message->content.at("on_per_ms").get<std::int64_t>();
    count += message->content.at("off_per_ms").get<std::int64_t>();
  }
  count += on_count;
  EXPECT_EQ(count, std::ssize(events));
  EXPECT_EQ(on_count, std::ranges::count(events, true, &Event::on));
  const auto third = [](const Event& e) { return e.t_us > 2000 && e.t_us <= 3000 && e.on; };
  EXPECT_EQ(read.of("/left/event_counts")[2]->content.at("on_per_ms"), std::ranges::count_if(events, third));
}

TEST_F(FoxgloveFile, CirclesAreThoseOfTheTablesInTheColoursOfTheReports) {
  write();
  const ReadMcap read(file());
  const auto truth = read_table<TruthRow>(run() / "truth.csv");
  const auto detections = read_table<DetectionRow>(run() / "detections.csv");
  std::map<std::string, int> found;
  for (const auto* const message : read.of("/left/circles")) {
    const auto t_us = static_cast<std::int64_t>(message->log_ns / 1000);
    std::vector<std::pair<Circle, Colour>> expected;
    for (const TruthRow& row : truth) {
      if (row.t_us == t_us) expected.emplace_back(row.circle, truth_colour);
    }
    for (const auto& [name, score] : metrics_.detectors) {
      const DetectionRow* newest = nullptr;
      for (const DetectionRow& row : detections) {
        if (row.detector == name && row.t_us <= t_us && row.t_us >= t_us - 10'000) newest = &row;
      }
      if (newest == nullptr || newest->score < score.threshold) continue;
      expected.emplace_back(newest->circle, detector_colour(name));
      ++found[name];
    }
    const json& circles = message->content.at("circles");
    ASSERT_EQ(circles.size(), expected.size()) << t_us;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      const auto& [circle, colour] = expected[i];
      // Foxglove counts from the corner of the first pixel, saccade from its centre.
      EXPECT_DOUBLE_EQ(circles[i].at("position").at("x").get<double>(), circle.x_px + 0.5);
      EXPECT_DOUBLE_EQ(circles[i].at("position").at("y").get<double>(), circle.y_px + 0.5);
      EXPECT_DOUBLE_EQ(circles[i].at("diameter").get<double>(), 2.0 * circle.r_px);
      EXPECT_NEAR(circles[i].at("outline_color").at("g").get<double>(), colour.green / 255.0, 1e-12);
      EXPECT_EQ(circles[i].at("fill_color").at("a"), 0.0);
    }
  }
  EXPECT_GT(found["paper_directed"], 5);
  EXPECT_GT(found["paper_full"], 0);
}

constexpr const char* small_scene = R"({"schema":1,
"bodies":[{"name":"world","poses":[[0,0,0,0,1,0,0,0]]},
  {"name":"root","poses":[[0,1,2,3,1,0,0,0]]},
  {"name":"ball_hand","poses":[[0,0,0,0.5,1,0,0,0],[10000,0,0,0.6,1,0,0,0],[50000,0,0,0.9,0.5,0.5,0.5,0.5]]}],
"geoms":[{"body":0,"shape":"mesh","size":[1,1,1],"pose":[0,0,0,1,0,0,0],"rgba":[1,1,1,1],"mesh":0},
  {"body":0,"shape":"plane","size":[0,0,1],"pose":[0,0,0,1,0,0,0],"rgba":[1,1,1,1]},
  {"body":1,"shape":"capsule","size":[0.1,0.3,0],"pose":[0,0,1,1,0,0,0],"rgba":[0.1,0.2,0.3,1]},
  {"body":1,"shape":"cylinder","size":[0.1,0.3,0],"pose":[0,0,0,1,0,0,0],"rgba":[1,1,1,1]},
  {"body":1,"shape":"ellipsoid","size":[0.1,0.2,0.3],"pose":[0,0,0,1,0,0,0],"rgba":[1,1,1,1]},
  {"body":1,"shape":"box","size":[0.1,0.2,0.3],"pose":[0,0,0,1,0,0,0],"rgba":[1,1,1,1]},
  {"body":2,"shape":"sphere","size":[0.05,0,0],"pose":[0,0,0,1,0,0,0],"rgba":[1,0,0,1]}],
"meshes":[{"vertices":[0,0,0,1,0,0,0,1,0],"triangles":[0,1,2],"texels":[]}],"textures":[]})";

TEST_F(FoxgloveFile, HasTheShapesOfTheSceneAndThePosesOfItsBodies) {
  write_file(run() / "scene.json", small_scene);
  write();
  const ReadMcap read(file());
  for (const auto& message : read.messages)
    expect_valid(message.content, read.topics.at(message.topic).schema_content, message.topic);
  const json& still = read.of("/tf_static").at(0)->content.at("transforms");
  ASSERT_EQ(still.size(), 1U);
  EXPECT_EQ(still[0].at("parent_frame_id"), "world");
  EXPECT_EQ(still[0].at("child_frame_id"), "root");
  EXPECT_EQ(still[0].at("translation").at("y"), 2.0);
  const auto moving = read.of("/tf");
  ASSERT_EQ(moving.size(), 3U);
  EXPECT_EQ(moving[1]->log_ns, 10'000'000U);
  const json& ball = moving[2]->content.at("transforms").at(0);
  EXPECT_EQ(ball.at("child_frame_id"), "ball_hand");
  EXPECT_NEAR(ball.at("translation").at("z").get<double>(), 0.9, 1e-12);
  EXPECT_NEAR(ball.at("rotation").at("x").get<double>(), 0.5, 1e-12);
  // The camera is where eye.csv has it, in the root frame.
  const json& camera = moving[2]->content.at("transforms").at(1);
  const EyeRow eye = read_table<EyeRow>(run() / "eye.csv")[49];
  EXPECT_EQ(camera.at("parent_frame_id"), "root");
  EXPECT_EQ(camera.at("child_frame_id"), "left_camera");
  EXPECT_DOUBLE_EQ(camera.at("translation").at("x").get<double>(), eye.position_m.x());
  EXPECT_NEAR(std::abs(camera.at("rotation").at("w").get<double>()), std::abs(eye.turn_wxyz[0]), 1e-9);

  const json& entities = read.of("/scene").at(0)->content.at("entities");
  ASSERT_EQ(entities.size(), 3U);
  EXPECT_EQ(entities[0].at("cubes").at(0).at("size").at("x"), 20.0) << "a plane without an end";
  const json& root = entities[1];
  EXPECT_EQ(root.at("frame_id"), "root");
  EXPECT_EQ(root.at("frame_locked"), true);
  ASSERT_EQ(root.at("cylinders").size(), 2U) << "of the capsule and the cylinder";
  ASSERT_EQ(root.at("spheres").size(), 3U) << "the capsule's ends and the ellipsoid";
  EXPECT_NEAR(root.at("cylinders")[0].at("size").at("z").get<double>(), 0.6, 1e-12);
  EXPECT_NEAR(root.at("spheres")[0].at("pose").at("position").at("z").get<double>(), 0.7, 1e-12);
  EXPECT_NEAR(root.at("spheres")[1].at("pose").at("position").at("z").get<double>(), 1.3, 1e-12);
  EXPECT_NEAR(root.at("spheres")[2].at("size").at("y").get<double>(), 0.4, 1e-12);
  EXPECT_NEAR(root.at("cubes")[0].at("size").at("z").get<double>(), 0.6, 1e-12);
  EXPECT_EQ(root.at("cylinders")[0].at("color").at("b"), 0.3);
  EXPECT_EQ(entities[2].at("id"), "ball_hand");
  EXPECT_NEAR(entities[2].at("spheres").at(0).at("size").at("x").get<double>(), 0.1, 1e-12);
  const json& room = read.of("/room").at(0)->content.at("entities");
  ASSERT_EQ(room.size(), 1U);
  EXPECT_EQ(room[0].at("triangles").at(0).at("points").size(), 3U);
  const FoxgloveScene scene(run() / "scene.json");
  EXPECT_THAT(scene.times(), ElementsAre(0, 10'000, 50'000));
}

/// Ground truth of 2 x 3 pixels at two instants.
void write_ground_truth(const std::filesystem::path& path, std::size_t depth_rows = 2) {
  const auto out = create_array_file(path);
  const std::vector<std::size_t> shape = {2, 3};
  const std::vector<std::int64_t> times = {100'000, 200'000};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> depth = {1, 2, 3, 4, 5, nan, 7, 8, 9, 10, 11, 12};
  const std::vector<float> luminance = {0, 1, 2.4F, 2.6F, 254, 300, 0, 0, 0, 0, 0, 0};
  std::vector<float> flow(24, 0.0F);
  flow[2] = 3.0F;
  flow[3] = -4.0F;
  const std::vector<std::uint8_t> numbers = {0, 1, 2, 1, 1, 1, 0, 0, 0, 0, 0, 0};
  out->append(out->add("t_us", ArrayType::i64, {}), std::span<const std::int64_t>(times));
  out->append(out->add("left/image", ArrayType::f32, shape), std::span<const float>(luminance));
  out->append(out->add("left/depth_m", ArrayType::f32, shape),
              std::span<const float>(depth).first(6 * depth_rows));
  out->append(out->add("left/flow_px_s", ArrayType::f32, {2, 3, 2}), std::span<const float>(flow));
  out->append(out->add("left/segmentation", ArrayType::u8, shape), std::span<const std::uint8_t>(numbers));
  out->put("objects", {"nothing", "room", "ball"});
  out->commit();
}

cv::Mat decoded(const json& message) {
  const std::string png = plain_bytes(message.at("data"));
  return cv::imdecode(std::vector<char>(png.begin(), png.end()), cv::IMREAD_UNCHANGED);
}

std::vector<float> numbers_of(const json& message) {
  EXPECT_EQ(message.at("encoding"), "32FC1");
  EXPECT_EQ(message.at("step"), 4 * message.at("width").get<int>());
  const std::string bytes = plain_bytes(message.at("data"));
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

TEST_F(FoxgloveFile, HasTheImagesOfTheGroundTruth) {
  for (const char* const name : {"ground_truth.npz", "ground_truth.h5"}) {
    SCOPED_TRACE(name);
    write_ground_truth(run() / name);
    write();
    const ReadMcap read(file());
    const std::string prefix = "/left/ground_truth/";
    EXPECT_FALSE(read.topics.contains(prefix + "frame"));
    const auto depth = read.of(prefix + "depth_m");
    ASSERT_EQ(depth.size(), 2U);
    EXPECT_EQ(depth[0]->log_ns, 100'000'000U);
    EXPECT_EQ(depth[1]->log_ns, 200'000'000U);
    EXPECT_THAT(numbers_of(depth[0]->content), ElementsAre(1, 2, 3, 4, 5, testing::IsNan()));
    EXPECT_THAT(numbers_of(depth[1]->content), ElementsAre(7, 8, 9, 10, 11, 12));
    EXPECT_THAT(numbers_of(read.of(prefix + "flow_px_s").at(0)->content), ElementsAre(0, 5, 0, 0, 0, 0));
    const cv::Mat luminance = decoded(read.of(prefix + "luminance").at(0)->content);
    ASSERT_EQ(luminance.type(), CV_8UC1);
    EXPECT_THAT(std::vector<int>(luminance.begin<std::uint8_t>(), luminance.end<std::uint8_t>()),
                ElementsAre(0, 1, 2, 3, 254, 255));
    const cv::Mat objects = decoded(read.of(prefix + "segmentation").at(0)->content);
    ASSERT_EQ(objects.type(), CV_8UC3);
    EXPECT_EQ(objects.at<cv::Vec3b>(0, 0), cv::Vec3b(0, 0, 0));
    EXPECT_EQ(objects.at<cv::Vec3b>(0, 1), objects.at<cv::Vec3b>(1, 0));
    EXPECT_NE(objects.at<cv::Vec3b>(0, 1), objects.at<cv::Vec3b>(0, 2));
    for (const auto& message : read.messages)
      expect_valid(message.content, read.topics.at(message.topic).schema_content, message.topic);
    std::filesystem::remove(run() / name);
    std::filesystem::remove(file());
  }
}

TEST_F(FoxgloveFile, OfABrokenFolderIsOneMessageAndNoFile) {
  write_ground_truth(run() / "ground_truth.npz", 1);
  expect_refused("fewer rows in the array left/depth_m than in t_us");
  write_file(run() / "ground_truth.npz", "rubbish, and more of it");
  expect_refused("ground_truth.npz");
  std::filesystem::remove(run() / "ground_truth.npz");
  write_file(run() / "ground_truth.h5", "rubbish, and more of it");
  expect_refused("ground_truth.h5");
  std::filesystem::remove(run() / "ground_truth.h5");

  std::string scene = small_scene;
  scene.replace(scene.find("[0,1,2]"), 7, "[0,1,3]");
  for (const std::string& text : {std::string("{}"), scene}) {
    write_file(run() / "scene.json", text);
    expect_refused("scene.json");
  }
  std::filesystem::remove(run() / "scene.json");

  write_file(run() / "events.csv", "t_us,x,y,p\n9000000,1,1,1\n");
  expect_refused("no events in the time of the run");
  std::filesystem::remove(run() / "events.csv");
  expect_refused("events.csv");
  metrics_.events_file.clear();
  write_metrics(run() / "metrics.json", metrics_);
  expect_refused("a run without events");
}

TEST_F(FoxgloveFile, EventsThatComeMuchTooLateAreCounted) {
  // More than a block of the reader, so that the last event comes when the image of its time is written.
  constexpr int count = 70'000;
  std::string text = "t_us,x,y,p\n";
  for (int i = 1; i <= count; ++i) text += std::to_string(5 * i) + ",1,1,1\n";
  text += "310000,2,2,1\n";  // 40 ms before the newest
  write_file(run() / "events.csv", text);
  FoxgloveSummary summary = write();
  EXPECT_EQ(summary.events, count + 1);
  EXPECT_EQ(summary.late_events, 0);
  write_file(run() / "events.csv", text + "150000,3,3,1\n");
  summary = write();
  EXPECT_EQ(summary.events, count + 1);
  EXPECT_EQ(summary.late_events, 1);
}

TEST_F(FoxgloveFile, OnAFullDiskIsRefusedAndRemoved) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{4096, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  EXPECT_THROW(write(), DiskFull);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, ignored);
  EXPECT_FALSE(std::filesystem::exists(file()));
  EXPECT_FALSE(std::filesystem::exists(file().string() + ".part"));
}

}  // namespace
}  // namespace saccade
