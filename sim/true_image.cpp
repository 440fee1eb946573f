#include "sim/true_image.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/error.h"
#include "emulator/event_label.h"
#include "sim/scene_drawer.h"

namespace saccade {
namespace {

constexpr std::int64_t samples_per_pixel = 2;  ///< in each direction

using RowMajor = Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>;

Eigen::Isometry3d body_pose(const mjData& data, int body) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Map<const RowMajor>(data.xmat + 9 * body);
  pose.translation() = Eigen::Map<const Eigen::Vector3d>(data.xpos + 3 * body);
  return pose;
}

std::string name_of(const mjModel& model, mjtObj type, int id) {
  const char* const name = mj_id2name(&model, type, id);
  return name != nullptr ? name : "";
}

}  // namespace

TrueImageRenderer::TrueImageRenderer(const mjModel& model, GlContext& gl, const Camera& camera,
                                     const EyeRenderConfig& config)
    : model_(&model),
      camera_(camera),
      config_(check_config("render", config)),
      lens_(camera, samples_per_pixel),
      drawer_(std::make_unique<detail::SceneDrawer>(model, gl, ImageSize{lens_.columns(), lens_.rows()},
                                                    detail::SceneDrawer::Quality::fast)),
      rgba_(lens_.is_inside().size()),
      depth_(rgba_.size()) {
  for (int y = 0; y < camera.size.height; ++y) {
    for (int x = 0; x < camera.size.width; ++x) rays_.push_back(camera.ray(x, y));
  }
}

TrueImageRenderer::~TrueImageRenderer() = default;

void TrueImageRenderer::render(mjData& data, int camera_id, TrueImage& image) {
  const int columns = lens_.columns();
  const int rows = lens_.rows();
  const mjrRect whole{0, 0, columns, rows};
  drawer_->draw_geoms(data, eye_view(data, camera_id, lens_, config_), whole);
  drawer_->read_rgba(whole, rgba_.data());
  drawer_->read_depth(whole, depth_.data());

  const double span = config_.far_m - config_.near_m;
  const auto inverse_depth = [&](std::size_t sample) {  // 1/m; linear along a plane in the image
    return (config_.far_m - static_cast<double>(depth_[sample]) * span) / (config_.near_m * config_.far_m);
  };
  const auto geom_at = [&](std::size_t sample) {
    return static_cast<std::int32_t>(rgba_[sample] & 0xffffffU) - 1;
  };
  const auto sample_at = [&](int column, int row) {  // from the top left; the bottom row comes first
    return static_cast<std::size_t>(rows - 1 - std::clamp(row, 0, rows - 1)) *
               static_cast<std::size_t>(columns) +
           static_cast<std::size_t>(std::clamp(column, 0, columns - 1));
  };
  image.depth_m.resize(rays_.size());
  image.geom.resize(rays_.size());
  for (std::size_t i = 0; i < rays_.size(); ++i) {
    const double u =
        lens_.focal() * rays_[i].x() + lens_.centre_x() - 0.5;  // in samples, centres at whole numbers
    const double v = lens_.focal() * rays_[i].y() + lens_.centre_y() - 0.5;
    const std::size_t nearest = sample_at(static_cast<int>(std::lround(u)), static_cast<int>(std::lround(v)));
    const std::int32_t geom = geom_at(nearest);
    image.geom[i] = geom;
    if (geom < 0) {
      image.depth_m[i] = std::numeric_limits<float>::quiet_NaN();
      continue;
    }
    const int left = static_cast<int>(std::floor(u));
    const int top = static_cast<int>(std::floor(v));
    const std::array<std::size_t, 4> around = {sample_at(left, top), sample_at(left + 1, top),
                                               sample_at(left, top + 1), sample_at(left + 1, top + 1)};
    double depth_m = 1.0 / inverse_depth(nearest);
    if (std::ranges::all_of(around, [&](std::size_t sample) { return geom_at(sample) == geom; })) {
      const double a = u - left;
      const double b = v - top;
      depth_m = 1.0 / ((1.0 - b) * ((1.0 - a) * inverse_depth(around[0]) + a * inverse_depth(around[1])) +
                       b * ((1.0 - a) * inverse_depth(around[2]) + a * inverse_depth(around[3])));
    }
    if (model_->geom_type[geom] == mjGEOM_SPHERE) {
      const double exact_m = sphere_depth(data, camera_id, geom, rays_[i]);
      if (exact_m > 0.0) depth_m = exact_m;
    }
    image.depth_m[i] = static_cast<float>(depth_m);
  }
}

/// 0 where the ray misses the sphere.
double TrueImageRenderer::sphere_depth(const mjData& data, int camera_id, int geom,
                                       const Eigen::Vector3d& ray) const {
  const Eigen::Vector3d centre_m =
      World::root_from_camera(data, camera_id).inverse() *
      Eigen::Vector3d(Eigen::Map<const Eigen::Vector3d>(data.geom_xpos + 3 * geom));
  const double radius_m = model_->geom_size[3 * geom];
  const double along = centre_m.dot(ray);
  const double ray2 = ray.squaredNorm();
  const double root2 = along * along - ray2 * (centre_m.squaredNorm() - radius_m * radius_m);
  return root2 >= 0.0 ? (along - std::sqrt(root2)) / ray2 : 0.0;
}

WorldPoses poses_of(const World& world) {
  WorldPoses poses;
  poses.t_us = world.now_us();
  for (int body = 0; body < world.model().nbody; ++body)
    poses.root_from_body.push_back(body_pose(world.data(), body));
  poses.root_from_camera = {world.root_from_left_cam(), world.root_from_right_cam()};
  return poses;
}

void optical_flow(const Camera& camera, const TrueImage& image, const mjModel& model, std::size_t eye,
                  const WorldPoses& before, const WorldPoses& now, const WorldPoses& after,
                  std::span<float> flow, std::span<float> camera_flow) {
  const double per_s = 1e6 / static_cast<double>(after.t_us - before.t_us);
  const Eigen::Isometry3d before_from_root = before.root_from_camera[eye].inverse();
  const Eigen::Isometry3d after_from_root = after.root_from_camera[eye].inverse();
  // Of each body: its motion in the root frame from now to the two other instants.
  std::vector<std::array<Eigen::Isometry3d, 2>> moved;
  for (std::size_t body = 0; body < now.root_from_body.size(); ++body) {
    const Eigen::Isometry3d body_from_root = now.root_from_body[body].inverse();
    moved.push_back({before_from_root * (before.root_from_body[body] * body_from_root),
                     after_from_root * (after.root_from_body[body] * body_from_root)});
  }
  const auto difference = [&](const Eigen::Vector3d& first_m,
                              const Eigen::Vector3d& last_m) -> Eigen::Vector2d {
    if (!(first_m.z() > 0.0) || !(last_m.z() > 0.0))
      return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    const auto first_px = camera.project(first_m);
    const auto last_px = camera.project(last_m);
    if (!first_px || !last_px) return Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    return (*last_px - *first_px) * per_s;
  };
  const int width = camera.size.width;
  for (std::size_t i = 0; i < image.geom.size(); ++i) {
    Eigen::Vector2d whole_px_s = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    Eigen::Vector2d of_camera_px_s = whole_px_s;
    if (image.geom[i] >= 0) {
      const int x = static_cast<int>(i) % width;
      const int y = static_cast<int>(i) / width;
      const Eigen::Vector3d point_m =
          now.root_from_camera[eye] *
          Eigen::Vector3d(camera.ray(x, y) * static_cast<double>(image.depth_m[i]));
      const auto& [to_before, to_after] = moved[static_cast<std::size_t>(model.geom_bodyid[image.geom[i]])];
      whole_px_s = difference(to_before * point_m, to_after * point_m);
      of_camera_px_s = difference(before_from_root * point_m, after_from_root * point_m);
    }
    for (const Eigen::Index axis : {0, 1}) {
      flow[2 * i + static_cast<std::size_t>(axis)] = static_cast<float>(whole_px_s[axis]);
      camera_flow[2 * i + static_cast<std::size_t>(axis)] = static_cast<float>(of_camera_px_s[axis]);
    }
  }
}

ObjectTable object_table(const World& world) {
  const mjModel& model = world.model();
  ObjectTable table;
  table.names = {"nothing", "room"};
  std::map<std::string, std::uint8_t> numbers = {{"room", 1}};
  for (int body = 0; body < model.nbody; ++body) table.body_names.push_back(name_of(model, mjOBJ_BODY, body));
  const std::vector<std::uint8_t> kinds = world.scene_objects();
  constexpr std::size_t most = 254;
  for (int geom = 0; geom < model.ngeom; ++geom) {
    const int body = model.geom_bodyid[geom];
    const std::uint8_t kind = kinds[static_cast<std::size_t>(geom)];
    const std::string& of_body = table.body_names[static_cast<std::size_t>(body)];
    std::string name = of_body;
    if (body == 0) name = "room";
    if (kind == static_cast<std::uint8_t>(SceneObject::ball) && world.target_radius_m()) name = "ball";
    if (body == 0 && kind == static_cast<std::uint8_t>(SceneObject::distractor))
      name = name_of(model, mjOBJ_GEOM, geom);
    if (name.empty()) name = "body " + std::to_string(body);
    const auto [at, is_new] = numbers.try_emplace(name, static_cast<std::uint8_t>(table.names.size()));
    if (is_new) {
      table.names.push_back(name);
      if (table.names.size() > most + 1)
        throw RunError("output.ground_truth: found more than " + std::to_string(most) +
                       " objects in the world, expected at most that many");
    }
    table.number_of_geom.push_back(at->second);
  }
  return table;
}

}  // namespace saccade
