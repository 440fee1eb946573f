#include "session/scene_recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <string>

#include "evaluation/image_codecs/image_codecs.h"
#include "evaluation/report/html.h"
#include "recording/output_file.h"
#include "recording/run_file_names.h"

namespace saccade {
namespace {

constexpr double still = 2e-5;  // m, and parts of a unit quaternion

std::array<double, 7> values_of(const Eigen::Isometry3d& pose) {
  const Eigen::Vector3d p = pose.translation();
  const Eigen::Quaterniond q(pose.linear());
  return {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()};
}

bool is_same(const std::array<double, 7>& a, const std::array<double, 7>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::abs(a[i] - b[i]) > still) return false;
  }
  return true;
}

/// "[1,2,3]" with five digits after the point at most.
template <class Values>
std::string json_list(const Values& values) {
  std::string text = "[";
  for (const auto value : values) {
    std::string number = fmt::format("{:.5f}", static_cast<double>(value));
    number.erase(number.find_last_not_of('0') + 1);
    if (number.back() == '.') number.pop_back();
    text += (text.size() > 1 ? "," : "") + (number == "-0" ? "0" : number);
  }
  return text + "]";
}

template <class Items, class Text>
std::string json_lines(const Items& items, Text text_of) {
  std::string text;
  for (const auto& item : items) text += (text.empty() ? "" : ",\n") + text_of(item);
  return text;
}

std::string texture_json(const SceneOutline::Texture& texture) {
  cv::Mat image(texture.height, texture.width, CV_8UC3);
  const std::size_t texels = texture.rgb.size() / 3;
  for (std::size_t i = 0; i < texels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) image.data[3 * i + c] = texture.rgb[3 * i + 2 - c];  // OpenCV: BGR
  }
  return "\"" + base64(encoded_image("jpeg", image)) + "\"";
}

std::string geom_json(const SceneOutline::Geom& geom) {
  std::string text =
      fmt::format("{{\"body\":{},\"shape\":\"{}\",\"size\":{},\"pose\":{},\"rgba\":{}", geom.body, geom.shape,
                  json_list(geom.size_m), json_list(values_of(geom.body_from_geom)), json_list(geom.rgba));
  if (geom.mesh >= 0) text += fmt::format(",\"mesh\":{}", geom.mesh);
  if (geom.texture >= 0) text += fmt::format(",\"texture\":{}", geom.texture);
  return text + "}";
}

/// Names of bodies are the model's: letters, digits and signs of any kind.
std::string json_string(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) {
    if (c == '"' || c == '\\') text += '\\';
    if (static_cast<unsigned char>(c) >= 0x20) text += c;
  }
  return text + "\"";
}

}  // namespace

SceneRecorder::SceneRecorder(std::filesystem::path folder, const SimRobot& robot)
    : folder_(std::move(folder)),
      robot_(robot),
      scene_(scene_outline(robot.world())),
      bodies_(scene_.bodies.size()) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    bodies_[i].newest = {robot_.now_us(), values_of(world_from_body(robot_.world(), i))};
    bodies_[i].poses.push_back(bodies_[i].newest);
  }
}

void SceneRecorder::take(std::int64_t t_us, std::size_t index) {
  Body& body = bodies_[index];
  const Pose pose{t_us, values_of(world_from_body(robot_.world(), index))};
  const bool moved = !is_same(pose.values, body.poses.back().values);
  if (moved) {
    // It stood still until the last look.
    if (body.newest.t_us > body.poses.back().t_us) body.poses.push_back(body.newest);
    body.poses.push_back(pose);
  }
  body.newest = pose;
}

void SceneRecorder::on_tick(const Tick& tick) {
  if (tick.t_us < next_us_) return;
  next_us_ = tick.t_us + step_us_;
  bool full = false;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    take(tick.t_us, i);
    full = full || bodies_[i].poses.size() > most_poses;
  }
  if (!full) return;
  step_us_ *= 2;
  for (Body& body : bodies_) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < body.poses.size(); i += 2) body.poses[kept++] = body.poses[i];
    if (body.poses.size() % 2 == 0) body.poses[kept++] = body.poses.back();
    body.poses.resize(kept);
  }
}

void SceneRecorder::commit() {
  for (Body& body : bodies_) {
    if (body.newest.t_us > body.poses.back().t_us && body.poses.size() > 1) body.poses.push_back(body.newest);
  }
  std::size_t index = 0;
  std::string text = "{\"schema\":1,\n\"bodies\":[\n";
  text += json_lines(bodies_, [&](const Body& body) {
    return fmt::format("{{\"name\":{},\"poses\":[", json_string(scene_.bodies[index++])) +
           json_lines(body.poses,
                      [](const Pose& pose) {
                        return fmt::format("[{},", pose.t_us) + json_list(pose.values).substr(1);
                      }) +
           "]}";
  });
  text += "],\n\"geoms\":[\n" + json_lines(scene_.geoms, geom_json);
  text += "],\n\"meshes\":[\n" + json_lines(scene_.meshes, [](const SceneOutline::Mesh& mesh) {
            return "{\"vertices\":" + json_list(mesh.vertices_m) +
                   ",\"triangles\":" + json_list(mesh.triangles) + ",\"texels\":" + json_list(mesh.texels) +
                   "}";
          });
  text += "],\n\"textures\":[\n" + json_lines(scene_.textures, texture_json) + "]}\n";
  write_file(folder_ / run_file::scene, text);
}

}  // namespace saccade
