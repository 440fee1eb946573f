#include "sim/lab_furniture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sim/lab_rooms.h"
#include "sim/lab_round.h"
#include "sim/lab_shapes.h"

namespace saccade::lab {
namespace {

using Eigen::Vector3d;

/// Places furniture at random into a layout.
class Furnisher {
 public:
  Furnisher(const LabConfig& config, std::uint64_t seed)
      : config_(config), random_(seed, "lab layout"), layout_(-config.wall_distance_m) {}

  Layout furnish() {
    if (config_.clutter == Clutter::rectilinear) {
      furnish_rectilinear();
    } else {
      furnish_textured();
    }
    return std::move(layout_);
  }

 private:
  int several(double at_density_1) const {
    return static_cast<int>(std::lround(at_density_1 * config_.density));
  }

  void poster(Facing wall, Spot spot) {
    const double width_m = random_.real(0.42, 0.56);
    layout_.add_panel(wall, spot, width_m, width_m * random_.real(1.2, 1.35), 170.0, paint_poster);
  }

  /// A table between the robot's reach and the wall. Returns the height of its top.
  double table(Painter top, Painter front) {
    constexpr double depth = 0.6;
    const double width = random_.real(1.5, 1.9);
    const double height = random_.real(-0.12, -0.02);
    table_x_ = layout_.back_m() + random_.real(0.75, 0.95);
    table_width_ = width;
    layout_.add_solid({table_x_, 0.0, height - 0.02}, {0.5 * width, 0.5 * depth, 0.02},
                      layout_.add_patch(width, depth, 150.0, std::move(top)), Facing::up);
    const double drop = height - 0.04 - floor_m;
    layout_.add_solid({table_x_ + 0.5 * depth - 0.03, 0.0, floor_m + 0.5 * drop},
                      {0.5 * width - 0.02, 0.5 * drop, 0.02},
                      layout_.add_patch(width, drop, 120.0, std::move(front)));
    return height;
  }

  void bookcase(Facing wall, double along_m, double width_m, double foot_m, int rows) {
    const double height_m = 0.36 * rows;
    const double middle = foot_m + 0.5 * height_m;
    layout_.add_box(wall, {along_m, middle, 0.0}, width_m, height_m, 0.2,
                    layout_.add_patch(width_m, height_m, 150.0,
                                      [rows](Canvas& c, RandomGenerator& r) { paint_books(c, r, rows); }));
    const std::size_t board = layout_.add_patch(0.25, 0.25, 128.0, paint_wood);
    layout_.add_box(wall, {along_m, foot_m + height_m + 0.015, 0.0}, width_m + 0.06, 0.03, 0.26, board);
    for (const double side : {-0.5, 0.5}) {
      layout_.add_box(wall, {along_m + side * (width_m + 0.03), middle, 0.0}, 0.03, height_m, 0.26, board);
    }
  }

  void furnish_rectilinear() {
    const double z = table(paint_desk, paint_drawers);
    for (int i = 0; i < several(4); ++i) {  // on the table
      const double width = random_.real(0.12, 0.3);
      const double tall = random_.real(0.12, 0.32);
      const double y = table_width_ * (random_.real(-0.12, 0.12) + 0.78 * ((i + 0.5) / several(4) - 0.5));
      layout_.add_solid({table_x_ - random_.real(0.0, 0.12), y, z + 0.5 * tall},
                        {0.5 * width, 0.5 * tall, 0.5 * width},
                        layout_.add_patch(width, width, 200.0, paint_carton));
    }
    const double y = random_.real(-0.35, 0.35);
    layout_.add_solid({table_x_ - 0.1, y, z + 0.3}, {0.29, 0.18, 0.02},
                      layout_.add_patch(0.58, 0.36, 180.0, paint_screen));
    layout_.add_solid({table_x_ - 0.13, y, z + 0.08}, {0.05, 0.08, 0.02},
                      layout_.add_patch(0.1, 0.16, 120.0, paint_rough));

    const double side = random_.chance(0.5) ? 1.0 : -1.0;
    const double case_at = side * random_.real(1.0, 1.2);
    bookcase(Facing::back_wall, case_at, random_.real(0.9, 1.2), floor_m + 0.25, 5);
    const double window_width = random_.real(1.0, 1.3);
    const double window_at = -side * random_.real(0.75, 1.0);
    layout_.add_panel(Facing::back_wall, {window_at, 0.95, 0.0}, window_width, random_.real(0.95, 1.25),
                      150.0, paint_window);
    const std::array<Spot, 4> back_spots{
        {{side * 0.12, 0.55, 0.0}, {side * 0.1, 1.3, 0.0}, {-side * 1.6, 0.5, 0.0}, {window_at, 0.12, 0.0}}};
    for (int i = 0; i < std::min(several(3), 4); ++i) {
      Spot spot = back_spots[static_cast<std::size_t>(i)];
      spot.along_m += random_.real(-0.06, 0.06);
      poster(Facing::back_wall, spot);
    }
    // Side walls: one has the window, the other the door.
    const bool door_left = random_.chance(0.5);
    const Facing door_wall = door_left ? Facing::left_wall : Facing::right_wall;
    const Facing window_wall = door_left ? Facing::right_wall : Facing::left_wall;
    const double ahead = door_left ? 1.0 : -1.0;  // `along` towards the back wall on the door's side
    layout_.add_panel(door_wall, {ahead * 1.2, floor_m + 1.0, 0.0}, 0.95, 2.0, 100.0, paint_door);
    layout_.add_panel(door_wall, {ahead * 0.05, 0.6, 0.0}, 1.1, 0.85, 130.0, paint_whiteboard);
    layout_.add_panel(window_wall, {-ahead * 0.75, 0.85, 0.0}, random_.real(1.2, 1.5), 1.2, 130.0,
                      paint_window);
    if (several(1) > 0) bookcase(window_wall, ahead * 0.6, 0.9, floor_m + 0.03, 3);
    for (int i = 0; i < std::min(several(2), 4); ++i) {
      poster(i % 2 == 0 ? door_wall : window_wall,
             {ahead * (i % 2 == 0 ? -0.9 : 0.4), i < 2 ? 0.75 : 1.4, 0.0});
    }
    for (int i = 0; i < several(3); ++i) {  // cartons on the floor
      const double size = random_.real(0.3, 0.5);
      const double at = (i % 2 == 0 ? 1.0 : -1.0) * random_.real(1.1, 1.5);
      const std::size_t carton =
          layout_.add_patch(size, size, 150.0, random_.chance(0.4) ? paint_drawers : paint_carton);
      layout_.add_solid({layout_.back_m() + random_.real(0.9, 1.5), at, floor_m + 0.5 * size},
                        {0.5 * size, 0.5 * size, 0.5 * size}, carton);
    }
    layout_.add_room(paint_wall_panels, paint_wall_panels, paint_wall_panels, paint_wall_panels,
                     paint_floor_tiles, [](Canvas& c, RandomGenerator& r) { paint_ceiling(c, r, 0.05); });
  }

  void plant(double x, double y, double foot_m, double size_m) {
    const double pot_height = 0.45 * size_m;
    layout_.add_solid({x, y, foot_m + 0.5 * pot_height}, {0.2 * size_m, 0.5 * pot_height, 0.2 * size_m},
                      layout_.add_patch(0.3, 0.3, 150.0, paint_rough));
    const std::size_t leaves = layout_.add_patch(2.4 * size_m, 1.2 * size_m, 150.0, paint_foliage);
    for (int i = 0; i < 2; ++i) {
      const Vector3d off{random_.real(-0.15, 0.15), random_.real(-0.25, 0.25),
                         0.3 + 0.5 * i + random_.real(-0.1, 0.1)};
      const Vector3d half{random_.real(0.35, 0.55), random_.real(0.35, 0.55), random_.real(0.4, 0.55)};
      layout_.add_lump(Vector3d(x, y, foot_m + pot_height) + size_m * off, size_m * half, 0.32, leaves,
                       random_);
    }
  }

  void furnish_textured() {
    const auto cloth = [](Canvas& c, RandomGenerator& r) { paint_cloth(c, r, 0.0); };
    const double fold_m = random_.real(0.14, 0.24);
    const Painter curtain = [fold_m](Canvas& c, RandomGenerator& r) { paint_cloth(c, r, fold_m); };
    const double z = table(cloth, curtain);
    for (int i = 0; i < several(3); ++i) {  // stones, cushions, pots on the table
      const double y = table_width_ * (random_.real(-0.1, 0.1) + 0.8 * ((i + 0.5) / several(3) - 0.5));
      const Vector3d half{random_.real(0.07, 0.12), random_.real(0.09, 0.17), random_.real(0.06, 0.13)};
      const std::size_t coat =
          layout_.add_patch(0.8, 0.4, 190.0, random_.chance(0.5) ? Painter(paint_rough) : Painter(cloth));
      layout_.add_lump({table_x_ - random_.real(0.0, 0.12), y, z + 0.85 * half.z()}, half, 0.12, coat,
                       random_);
    }
    if (several(1) > 0) plant(table_x_ - 0.1, random_.real(-0.6, 0.6), z, 0.3);
    for (int i = 0; i < several(2); ++i) {
      const double x = layout_.back_m() + random_.real(0.5, 0.9);
      const double y = (i % 2 == 0 ? 1.0 : -1.0) * random_.real(1.2, 1.5);
      plant(x, y, floor_m, random_.real(0.6, 0.85));
    }
    for (int i = 0; i < several(2); ++i) {
      const Facing wall = i % 2 == 0 ? Facing::left_wall : Facing::right_wall;
      const Spot spot{random_.real(-0.9, 0.9), random_.real(0.3, 1.0), 0.0};
      const double width_m = random_.real(0.5, 0.9);
      layout_.add_panel(wall, spot, width_m, width_m * random_.real(0.7, 1.3), 150.0,
                        [](Canvas& c, RandomGenerator& r) {
                          paint_cloth(c, r, 0.0);
                          pin_photographs(c, r, 6.0);
                        });
    }
    const double photographs = 2.4 * config_.density;
    const Painter brick = [photographs](Canvas& c, RandomGenerator& r) {
      paint_brick(c, r);
      pin_photographs(c, r, photographs);
      c.darken_edges(0.25, 0.25);
    };
    const Painter plaster = [photographs](Canvas& c, RandomGenerator& r) {
      c.fill({0.43, 0.39, 0.34});
      roughen(c, r, 0.35, 0.3, 6, 0.72);
      scatter_leaves(c, r, 70.0, 0.05, 0.16, {0.26, 0.34, 0.18}, 0.4);
      pin_photographs(c, r, photographs);
      c.darken_edges(0.25, 0.25);
    };
    const Painter ivy = [](Canvas& c, RandomGenerator& r) {
      paint_foliage(c, r);
      c.darken_edges(0.25, 0.25);
    };
    std::array<Painter, 4> walls{brick, plaster, curtain, ivy};
    // The wall in front is brick or plaster; the others follow in a random order.
    if (random_.chance(0.5)) std::swap(walls[0], walls[1]);
    for (std::size_t i = 3; i > 1; --i)
      std::swap(walls[i], walls[1 + static_cast<std::size_t>(random_.index(static_cast<int>(i)))]);
    layout_.add_room(walls[0], walls[1], walls[2], walls[3], paint_carpet,
                     [](Canvas& c, RandomGenerator& r) { paint_ceiling(c, r, 0.25); });
  }

  const LabConfig& config_;
  RandomGenerator random_;
  Layout layout_;
  double table_x_ = 0.0;
  double table_width_ = 0.0;
};

}  // namespace

Layout furnished(const LabConfig& config, std::uint64_t seed) {
  const bool has_furniture = config.clutter == Clutter::textured || config.clutter == Clutter::rectilinear;
  Layout layout = has_furniture ? Furnisher(config, seed).furnish() : room_of_walls(config, seed);
  add_round_things(layout, config.round, seed);
  add_printed_shapes(layout, config.shapes, seed);
  layout.pack();
  return layout;
}

}  // namespace saccade::lab
