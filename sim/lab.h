#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/config.h"
#include "sim/flicker.h"
#include "sim/model_parts.h"
#include "sim/panorama.h"

namespace saccade {

class Canvas;
struct Reflectance;

/// Kind of a lab's surfaces and furniture.
enum class Clutter {
  textured,     ///< brick, curtain, foliage, patterned cloth, pinned photographs, plants
  rectilinear,  ///< shelves with books, posters, window frames, a monitor, boxes, a door
  natural,      ///< rock with the spectrum of natural scenes, the amplitude falling with 1/f
  foliage,      ///< leaves and bushes
  blinds,       ///< slats from side to side or from top to bottom
  shelves,      ///< walls of books and cartons
  bare,         ///< walls of one colour, nearly empty
};
constexpr auto words_of(Clutter) {
  return std::to_array<Word<Clutter>>({{Clutter::textured, "textured"},
                                       {Clutter::rectilinear, "rectilinear"},
                                       {Clutter::natural, "natural"},
                                       {Clutter::foliage, "foliage"},
                                       {Clutter::blinds, "blinds"},
                                       {Clutter::shelves, "shelves"},
                                       {Clutter::bare, "bare"}});
}

/// What the room is made of.
enum class Room {
  furnished,  ///< walls and furniture after the other keys
  mjcf,       ///< a model of a file
  panorama,   ///< a photograph of everything around
};
constexpr auto words_of(Room) {
  return std::to_array<Word<Room>>(
      {{Room::furnished, "furnished"}, {Room::mjcf, "mjcf"}, {Room::panorama, "panorama"}});
}

/// Numbers of round things that stand still in the lab, at random places in front of the robot.
struct RoundThings {
  std::int64_t discs = 0;   ///< printed, on the wall
  std::int64_t clocks = 0;  ///< on the wall
  std::int64_t wheels = 0;  ///< on the wall
  std::int64_t cups = 0;    ///< on boards
  std::int64_t balls = 0;   ///< on boards
};

/// Keys: discs, clocks, wheels, cups, balls.
void describe(FieldVisitor& v, RoundThings& round);

/// The room in front of the robot. Root frame: x backward, y right, z up, the waist at the origin; the
/// floor is at z = -0.62 m and the robot looks along -x at the back wall.
struct LabConfig {
  Clutter clutter = Clutter::textured;
  double density = 1.0;          ///< number of objects, relative to a normally furnished lab
  double contrast = 1.0;         ///< exponent of the painted reflectances; 0 is flat grey, 1 natural
  double brightness = 1.0;       ///< of the light; at 1 a white wall is just below saturation
  double wall_distance_m = 2.2;  ///< from the waist to the wall in front
  RoundThings round = {};
  std::int64_t shapes = 0;  ///< printed shapes that are no discs, on the wall in front
  Room room = Room::furnished;
  std::string mjcf = {};  ///< path of the MJCF file of a room
  PanoramaConfig panorama = {};
  std::optional<FlickerConfig> flicker = {};  ///< none: the light is steady
};

/// Keys: room, mjcf, those of panorama, clutter, density, contrast, brightness, wall_distance_m, round, shapes, flicker; those that
/// do not belong to the room are not visited.
void describe(FieldVisitor& v, LabConfig& config);

/// A directional light of the lab: the luminance of a white matt surface is ambient, plus diffuse times the cosine of the
/// angle of incidence.
struct LabLight {
  const char* name;
  Eigen::Vector3d direction;  ///< in which the light goes, root frame, of any length
  double ambient;
  double diffuse;
};
[[nodiscard]] std::array<LabLight, 2> lab_lights(const LabConfig& config);

namespace lab {
class Layout;
}

/// A lab with furniture at random places: its geometry for the model, and its texture. The same config and seed give
/// the same bytes.
class Lab {
 public:
  /// Throws InputError for a config out of range, and for a file that is wrong: read_model_file(), panorama_parts().
  Lab(const LabConfig& config, std::uint64_t seed);
  ~Lab();
  Lab(Lab&&) noexcept;
  Lab& operator=(Lab&&) noexcept;

  /// The lab as MJCF elements for World: <asset> and <worldbody>. A furnished one has two lights and one mesh, "lab", of
  /// group 1, that collides with nothing. Of a file the geoms and lights are those of the file; a room without lights of its own gets
  /// the two. (One mesh with one texture, because in software each further geom costs 7 us per
  /// image.) Its texture has one colour until paint().
  [[nodiscard]] std::string mjcf() const;

  /// Paints the texture of a compiled model that holds mjcf(). Colours are linear reflectances between 0.09 and 0.92.
  /// Call before a renderer uploads the texture. Throws RunError when the model holds no lab or another one.
  void paint(mjModel& model) const;

  /// Of a furnished room.
  [[nodiscard]] const lab::Layout& layout() const { return *layout_; }
  /// A patch of the layout as its painter paints it.
  [[nodiscard]] Canvas painted(std::size_t patch) const;
  /// A painted colour as it is in the texture, up to rounding: with the lab's contrast.
  [[nodiscard]] Reflectance with_contrast(const Reflectance& painted) const;

 private:
  void paint_patch(std::size_t index, mjtByte* rgb) const;
  [[nodiscard]] std::string lights_mjcf() const;

  LabConfig config_;
  std::uint64_t seed_;
  std::unique_ptr<const lab::Layout> layout_;  ///< null for a room of a file
  ModelParts parts_;                           ///< of a file
};

}  // namespace saccade
