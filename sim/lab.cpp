#include "sim/lab.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "core/error.h"
#include "sim/canvas.h"
#include "sim/file_keys.h"
#include "sim/lab_furniture.h"
#include "sim/model_file.h"
#include "sim/mujoco_compat.h"

namespace saccade {
namespace {

/// printf into a string.
template <class... Values>
std::string print(const char* format, Values... values) {
  std::array<char, 512> text{};
  const int length = std::snprintf(text.data(), text.size(), format, values...);
  SACCADE_CHECK(length >= 0 && length < static_cast<int>(text.size()));
  return text.data();
}

}  // namespace

void describe(FieldVisitor& v, RoundThings& round) {
  constexpr Range several{0.0, 12.0};
  v.integer("discs", round.discs, several, "printed discs on the wall in front");
  v.integer("clocks", round.clocks, several, "clocks on the wall in front");
  v.integer("wheels", round.wheels, several, "wheels at rest on the wall in front");
  v.integer("cups", round.cups, several, "cups on boards before the wall");
  v.integer("balls", round.balls, several, "balls at rest on boards before the wall");
}

void describe(FieldVisitor& v, LabConfig& config) {
  if (config.room == Room::furnished && gives(v, "mjcf")) config.room = Room::mjcf;
  if (config.room == Room::furnished && gives(v, "panorama")) config.room = Room::panorama;
  v.choice("room", config.room,
           "what the room is made of; with the key mjcf or panorama it is that by default");
  v.when(config.room == Room::mjcf, "room: mjcf", [&] {
    v.path("mjcf", config.mjcf, "MJCF file of a room, in the root frame; relative to the scenario");
    v.require(!config.mjcf.empty(), "mjcf", "no such key", "the path of an MJCF file");
  });
  v.when(config.room == Room::panorama, "room: panorama", [&] { describe(v, config.panorama); });
  v.when(config.room == Room::furnished, "room: furnished", [&] {
    v.choice("clutter", config.clutter, "kind of surfaces and furniture");
    v.real("density", config.density, {0.0, 2.0}, "number of objects in the lab; 1: normally furnished");
    v.real("contrast", config.contrast, {0.0, 1.5},
           "contrast of everything painted; 0: flat grey, 1: natural");
  });
  v.real("brightness", config.brightness, {0.3, 1.2},
         "brightness of the light; a room of a file with lights of its own keeps those");
  v.when(config.room == Room::furnished, "room: furnished", [&] {
    v.real("wall_distance_m", config.wall_distance_m, {1.8, 4.0}, "from the waist to the wall in front");
    v.section("round", config.round, "round things that stand still");
    v.integer(
        "shapes", config.shapes, {0.0, 12.0},
        "printed shapes that are no discs, on the wall in front: polygons, stars, ellipses, parts of discs");
  });
  v.optional_section("flicker", config.flicker, "light that varies with time");
}

std::array<LabLight, 2> lab_lights(const LabConfig& config) {
  const double b = config.brightness;
  return {{{"lamp", {-0.55, -0.35, -0.76}, 0.4 * b, 0.5 * b}, {"sky", {-0.35, 0.9, -0.25}, 0.0, 0.35 * b}}};
}

Lab::Lab(const LabConfig& config, std::uint64_t seed) : config_(check_config("lab", config)), seed_(seed) {
  if (config.room == Room::furnished) {
    layout_ = std::make_unique<const lab::Layout>(lab::furnished(config_, seed));
  } else {
    parts_ = config.room == Room::mjcf ? read_model_file(config.mjcf, "lab", ModelUse::lab)
                                       : panorama_parts(config.panorama, "lab");
  }
}

Lab::~Lab() = default;
Lab::Lab(Lab&&) noexcept = default;
Lab& Lab::operator=(Lab&&) noexcept = default;

std::string Lab::lights_mjcf() const {
  std::string bodies;
  for (const LabLight& light : lab_lights(config_)) {
    bodies += print(
        "  <light name=\"lab_%s\" directional=\"true\" dir=\"%.2f %.2f %.2f\" pos=\"%s\" ambient=\"%.4f %.4f "
        "%.4f\" "
        "diffuse=\"%.4f %.4f %.4f\" specular=\"0 0 0\" castshadow=\"false\"/>\n",
        light.name, light.direction.x(), light.direction.y(), light.direction.z(), "0.6 0.4 1.8",
        light.ambient, light.ambient, light.ambient, light.diffuse, light.diffuse, light.diffuse);
  }
  return bodies;
}

std::string Lab::mjcf() const {
  if (!layout_) {
    return "<asset>\n" + parts_.assets + "</asset>\n<worldbody>\n" +
           (parts_.lights.empty() ? lights_mjcf() : parts_.lights) + parts_.geoms + "</worldbody>\n";
  }
  std::string points;
  std::string normals;
  std::string texels;
  std::string faces;
  int count = 0;
  for (const lab::Triangle& triangle : layout_->triangles()) {
    const lab::Patch& patch = layout_->patches()[triangle.patch];
    for (const lab::Corner& c : triangle.corners) {
      points += print("%.4f %.4f %.4f ", c.point_m.x(), c.point_m.y(), c.point_m.z());
      normals += print("%.4f %.4f %.4f ", c.normal.x(), c.normal.y(), c.normal.z());
      texels += print("%.6f %.6f ", (patch.left + c.u * patch.columns) / lab::Layout::texture_columns,
                      (patch.top + c.v * patch.rows) / layout_->texture_rows());
    }
    faces += print("%d %d %d ", count, count + 1, count + 2);
    count += 3;
  }
  return print(
             "<asset>\n"
             "  <texture name=\"lab\" type=\"2d\" builtin=\"flat\" width=\"%d\" height=\"%d\" rgb1=\"0.33 "
             "0.33 0.33\"/>\n"
             "  <material name=\"lab\" texture=\"lab\" specular=\"0\" shininess=\"0\"/>\n",
             lab::Layout::texture_columns, layout_->texture_rows()) +
         "  <mesh name=\"lab\" vertex=\"" + points + "\" normal=\"" + normals + "\" texcoord=\"" + texels +
         "\" face=\"" + faces + "\"/>\n</asset>\n<worldbody>\n" + lights_mjcf() +
         "  <geom name=\"lab\" type=\"mesh\" mesh=\"lab\" material=\"lab\" group=\"1\" contype=\"0\" "
         "conaffinity=\"0\"/>\n"
         "</worldbody>\n";
}

void Lab::paint(mjModel& model) const {
  if (!layout_) {
    paint_textures(parts_, model);
    return;
  }
  const int id = mj_name2id(&model, mjOBJ_TEXTURE, "lab");
  if (id < 0 || model.tex_width[id] != lab::Layout::texture_columns ||
      model.tex_height[id] != layout_->texture_rows()) {
    throw RunError("the model does not hold this lab");
  }
  mjtByte* const rgb = texture_rgb(model, id);
  for (std::size_t i = 0; i < layout_->patches().size(); ++i) paint_patch(i, rgb);
}

Canvas Lab::painted(std::size_t index) const {
  const lab::Patch& patch = layout_->patches()[index];
  Canvas canvas(patch.width_m, patch.height_m, patch.columns, patch.rows);
  RandomGenerator random(seed_ * 1000003U + index, "lab picture");
  patch.paint(canvas, random);
  return canvas;
}

Reflectance Lab::with_contrast(const Reflectance& painted) const {
  const auto of_channel = [this](double value) {
    constexpr double middle = 0.33;
    const double ratio = std::max(value, 1e-3) / middle;
    const double drawn =
        config_.contrast == 1.0 ? ratio : std::pow(ratio, config_.contrast);  // the same, sooner
    return std::clamp(middle * drawn, 0.09, 0.92);
  };
  const double r = of_channel(painted.r);
  const double g = painted.g == painted.r ? r : of_channel(painted.g);
  return {r, g, painted.b == painted.g ? g : of_channel(painted.b)};
}

void Lab::paint_patch(std::size_t index, mjtByte* rgb) const {
  using lab::Layout;
  const lab::Patch& patch = layout_->patches()[index];
  Canvas canvas = painted(index);
  canvas.each([&](double, double, const Reflectance& c) { return with_contrast(c); });
  const auto byte_of = [](double reflectance) {
    return static_cast<mjtByte>(std::lround(255.0 * reflectance));
  };
  // The rim repeats the outermost texels, because interpolation reads half a texel beyond them.
  for (int row = -Layout::rim; row < patch.rows + Layout::rim; ++row) {
    for (int column = -Layout::rim; column < patch.columns + Layout::rim; ++column) {
      const Reflectance& c =
          canvas.texel(std::clamp(column, 0, patch.columns - 1), std::clamp(row, 0, patch.rows - 1));
      mjtByte* texel = rgb + 3 * ((patch.top + row) * static_cast<std::ptrdiff_t>(Layout::texture_columns) +
                                  patch.left + column);
      texel[0] = byte_of(c.r);
      texel[1] = byte_of(c.g);
      texel[2] = byte_of(c.b);
    }
  }
}

}  // namespace saccade
