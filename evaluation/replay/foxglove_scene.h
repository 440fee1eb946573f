#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace saccade {

/// The scene of a run (scene.json) in Foxglove's terms: frames, and shapes that are fixed to them.
class FoxgloveScene {
 public:
  using Json = nlohmann::ordered_json;

  /// Empty where the file does not exist. Throws InputError for a broken one.
  explicit FoxgloveScene(const std::filesystem::path& file);

  [[nodiscard]] bool empty() const { return bodies_.empty(); }
  /// The frame in which gaze, ball and cameras are known.
  [[nodiscard]] std::string root() const;
  /// When a body has a pose, in order, each once.
  [[nodiscard]] const std::vector<std::int64_t>& times() const { return times_; }
  /// A list of FrameTransform: of bodies that never move, or the newest pose of the others.
  [[nodiscard]] Json still_transforms(std::int64_t t_us) const;
  [[nodiscard]] Json transforms(std::int64_t t_us) const;
  /// A SceneUpdate: the meshes of the world, which are the room, or all other shapes.
  [[nodiscard]] Json room(std::int64_t t_us) const;
  [[nodiscard]] Json shapes(std::int64_t t_us) const;

 private:
  struct Pose {
    std::int64_t t_us = 0;
    Eigen::Isometry3d world_from_body = Eigen::Isometry3d::Identity();
  };
  struct Shape {
    std::string list;  ///< of an entity: spheres
    bool is_room = false;
    std::string primitive;  ///< JSON
  };
  struct Body {
    std::string name;
    std::vector<Pose> poses;  ///< at least one
    std::vector<Shape> shapes;
  };

  void read(const std::string& text);
  [[nodiscard]] Json transform(std::int64_t t_us, const Body& body) const;
  [[nodiscard]] Json update(std::int64_t t_us, bool room) const;

  std::vector<Body> bodies_;
  std::vector<std::int64_t> times_;
};

}  // namespace saccade
