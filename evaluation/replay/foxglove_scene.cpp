#include "evaluation/replay/foxglove_scene.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/error.h"
#include "evaluation/replay/foxglove_writer.h"
#include "evaluation/replay/scene_file.h"

namespace saccade {
namespace {

using Json = nlohmann::ordered_json;

/// Position and unit quaternion w, x, y, z, from the place `at` on.
Eigen::Isometry3d pose_at(const Json& values, std::size_t at) {
  const auto value = [&](std::size_t i) { return values.at(at + i).get<double>(); };
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = Eigen::Vector3d(value(0), value(1), value(2));
  pose.linear() = Eigen::Quaterniond(value(3), value(4), value(5), value(6)).normalized().toRotationMatrix();
  return pose;
}

Json sized(const Eigen::Isometry3d& pose, const Eigen::Vector3d& size_m, const Json& colour) {
  return {{"pose", foxglove_pose(pose)}, {"size", foxglove_vector(size_m)}, {"color", colour}};
}

Json cylinder(const Eigen::Isometry3d& pose, double radius_m, double half_m, const Json& colour) {
  Json primitive = sized(pose, 2.0 * Eigen::Vector3d(radius_m, radius_m, half_m), colour);
  primitive["bottom_scale"] = 1.0;
  primitive["top_scale"] = 1.0;
  return primitive;
}

Json triangles(const Eigen::Isometry3d& pose, const Json& mesh, const Json& colour) {
  const auto vertices = mesh.at("vertices").get<std::vector<double>>();
  const auto indices = mesh.at("triangles").get<std::vector<std::size_t>>();
  Json points = Json::array();
  for (std::size_t i = 0; i + 2 < vertices.size(); i += 3)
    points.push_back(foxglove_vector({vertices[i], vertices[i + 1], vertices[i + 2]}));
  for (const std::size_t index : indices) (void)points.at(index);  // throws for an index of no vertex
  return {{"pose", foxglove_pose(pose)},
          {"points", std::move(points)},
          {"color", colour},
          {"colors", Json::array()},
          {"indices", indices}};
}

/// Names of lists of an entity and what goes into them. Sizes are MuJoCo's (docs/run_folder.md).
std::vector<std::pair<std::string, Json>> primitives_of(const Json& geom, const Json& meshes) {
  const auto shape = geom.at("shape").get<std::string>();
  const auto size = geom.at("size").get<std::array<double, 3>>();
  const auto rgba = geom.at("rgba").get<std::array<double, 4>>();
  const Json colour = {{"r", rgba[0]}, {"g", rgba[1]}, {"b", rgba[2]}, {"a", rgba[3]}};
  const Eigen::Isometry3d pose = pose_at(geom.at("pose"), 0);
  if (shape == "sphere") return {{"spheres", sized(pose, Eigen::Vector3d::Constant(2.0 * size[0]), colour)}};
  if (shape == "ellipsoid")
    return {{"spheres", sized(pose, 2.0 * Eigen::Vector3d(size[0], size[1], size[2]), colour)}};
  if (shape == "box")
    return {{"cubes", sized(pose, 2.0 * Eigen::Vector3d(size[0], size[1], size[2]), colour)}};
  if (shape == "cylinder") return {{"cylinders", cylinder(pose, size[0], size[1], colour)}};
  if (shape == "capsule") {
    std::vector<std::pair<std::string, Json>> parts = {
        {"cylinders", cylinder(pose, size[0], size[1], colour)}};
    for (const double end_m : {-size[1], size[1]}) {
      parts.emplace_back("spheres", sized(pose * Eigen::Translation3d(0.0, 0.0, end_m),
                                          Eigen::Vector3d::Constant(2.0 * size[0]), colour));
    }
    return parts;
  }
  if (shape == "plane") {
    constexpr double endless_m = 20.0;
    constexpr double thin_m = 1e-3;
    const auto length = [](double half_m) { return half_m > 0.0 ? 2.0 * half_m : endless_m; };
    return {{"cubes", sized(pose, {length(size[0]), length(size[1]), thin_m}, colour)}};
  }
  if (shape == "mesh")
    return {{"triangles", triangles(pose, meshes.at(geom.at("mesh").get<std::size_t>()), colour)}};
  return {};
}

}  // namespace

FoxgloveScene::FoxgloveScene(const std::filesystem::path& file) {
  const std::string text = scene_text(file);
  if (text.empty()) return;
  try {
    read(text);
  } catch (const Json::exception& error) {
    throw InputError(file.string(), error.what(), "the scene of a run");
  }
}

void FoxgloveScene::read(const std::string& text) {
  const Json scene = Json::parse(text);
  for (const Json& entry : scene.at("bodies")) {
    Body& body = bodies_.emplace_back();
    body.name = entry.at("name").get<std::string>();
    if (body.name.empty()) body.name = "body_" + std::to_string(bodies_.size() - 1);
    for (const Json& pose : entry.at("poses")) {
      body.poses.push_back({pose.at(0).get<std::int64_t>(), pose_at(pose, 1)});
      times_.push_back(body.poses.back().t_us);
    }
    (void)entry.at("poses").at(0);  // throws where there is none
  }
  std::ranges::sort(times_);
  times_.erase(std::unique(times_.begin(), times_.end()), times_.end());
  for (const Json& geom : scene.at("geoms")) {
    const auto body = geom.at("body").get<std::size_t>();
    (void)scene.at("bodies").at(body);
    const bool is_room = body == 0 && geom.at("shape") == "mesh";
    for (const auto& [list, primitive] : primitives_of(geom, scene.at("meshes")))
      bodies_[body].shapes.push_back({list, is_room, primitive.dump()});
  }
}

std::string FoxgloveScene::root() const {
  const bool has_root = std::ranges::any_of(bodies_, [](const Body& body) { return body.name == "root"; });
  return empty() || has_root ? "root" : bodies_.front().name;
}

Json FoxgloveScene::transform(std::int64_t t_us, const Body& body) const {
  auto after = std::ranges::upper_bound(body.poses, t_us, {}, &Pose::t_us);
  if (after != body.poses.begin()) --after;
  const Eigen::Isometry3d& pose = after->world_from_body;
  return {{"timestamp", foxglove_time(t_us)},
          {"parent_frame_id", bodies_.front().name},
          {"child_frame_id", body.name},
          {"translation", foxglove_vector(pose.translation())},
          {"rotation", foxglove_quaternion(Eigen::Quaterniond(pose.linear()))}};
}

Json FoxgloveScene::still_transforms(std::int64_t t_us) const {
  Json list = Json::array();
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    if (bodies_[i].poses.size() == 1) list.push_back(transform(t_us, bodies_[i]));
  }
  return list;
}

Json FoxgloveScene::transforms(std::int64_t t_us) const {
  Json list = Json::array();
  for (std::size_t i = 1; i < bodies_.size(); ++i) {
    if (bodies_[i].poses.size() > 1) list.push_back(transform(t_us, bodies_[i]));
  }
  return list;
}

Json FoxgloveScene::update(std::int64_t t_us, bool room) const {
  Json entities = Json::array();
  for (const Body& body : bodies_) {
    Json entity = foxglove_entity(t_us, body.name, body.name);
    bool has_shapes = false;
    for (const Shape& shape : body.shapes) {
      if (shape.is_room != room) continue;
      entity[shape.list].push_back(Json::parse(shape.primitive));
      has_shapes = true;
    }
    if (has_shapes) entities.push_back(std::move(entity));
  }
  return {{"deletions", Json::array()}, {"entities", std::move(entities)}};
}

Json FoxgloveScene::room(std::int64_t t_us) const { return update(t_us, true); }

Json FoxgloveScene::shapes(std::int64_t t_us) const { return update(t_us, false); }

}  // namespace saccade
