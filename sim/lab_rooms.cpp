#include "sim/lab_rooms.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace saccade::lab {
namespace {

using Eigen::Vector3d;

/// Fills a layout with one of the rooms.
class RoomOfWalls {
 public:
  RoomOfWalls(const LabConfig& config, std::uint64_t seed)
      : config_(config), random_(seed, "lab room"), layout_(-config.wall_distance_m) {}

  Layout furnish() {
    switch (config_.clutter) {
      case Clutter::natural:
        natural();
        break;
      case Clutter::foliage:
        foliage();
        break;
      case Clutter::blinds:
        blinds();
        break;
      case Clutter::shelves:
        shelves();
        break;
      default:
        bare();
    }
    return std::move(layout_);
  }

 private:
  int several(double at_density_1) const {
    return static_cast<int>(std::lround(at_density_1 * config_.density));
  }

  void walls(const Painter& paint, const Painter& floor) {
    layout_.add_room(paint, paint, paint, paint, floor,
                     [](Canvas& c, RandomGenerator& r) { paint_ceiling(c, r, 0.1); });
  }

  /// Boulders on the floor before walls of the same matter.
  void natural() {
    for (int i = 0; i < several(4); ++i) {
      const double size_m = random_.real(0.15, 0.45);
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      const Vector3d half =
          size_m * Vector3d(random_.real(0.6, 1.0), random_.real(0.8, 1.4), random_.real(0.5, 1.0));
      const double x = layout_.back_m() + random_.real(0.4, 0.8);
      layout_.add_lump({x, side * random_.real(0.2, 1.3), floor_m + 0.8 * half.z() + random_.real(0.0, 0.5)},
                       half, 0.15, layout_.add_patch(1.2, 0.6, 180.0, paint_natural), random_);
    }
    walls(paint_natural, paint_natural);
  }

  void foliage() {
    for (int i = 0; i < several(3); ++i) {  // bushes
      const double size_m = random_.real(0.3, 0.5);
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      const Vector3d half = size_m * Vector3d(0.8, random_.real(0.8, 1.3), random_.real(0.8, 1.4));
      const double x = layout_.back_m() + random_.real(0.45, 0.7);
      layout_.add_lump({x, side * random_.real(0.4, 1.4), floor_m + random_.real(0.6, 1.1)}, half, 0.3,
                       layout_.add_patch(1.6, 0.8, 170.0, paint_foliage), random_);
    }
    walls(paint_foliage, paint_carpet);
  }

  void blinds() {
    const bool upright = random_.chance(0.4);
    const double slat_m = random_.real(0.03, 0.12);
    const Painter slats = [=](Canvas& c, RandomGenerator& r) { paint_blinds(c, r, slat_m, upright); };
    for (int i = 0; i < several(2); ++i) {
      const double width_m = random_.real(0.5, 1.0);
      const Spot spot{random_.real(-1.2, 1.2), random_.real(0.2, 1.1), 0.0};
      layout_.add_panel(i % 2 == 0 ? Facing::left_wall : Facing::right_wall, spot, width_m,
                        width_m * random_.real(0.8, 1.3), 150.0, paint_window);
    }
    walls(slats, paint_floor_tiles);
  }

  void shelves() {
    const int rows = 5 + random_.index(4);
    const Painter books = [rows](Canvas& c, RandomGenerator& r) { paint_books(c, r, rows); };
    const std::size_t board = layout_.add_patch(0.3, 0.3, 128.0, paint_wood);
    for (int i = 0; i < several(3); ++i) {  // posts between the shelves
      layout_.add_box(Facing::back_wall, {random_.real(-1.4, 1.4), 0.65, 0.0}, 0.04, 2.5, 0.08 + 0.01 * i,
                      board);
    }
    for (int i = 0; i < several(3); ++i) {  // cartons on the floor
      const double size_m = random_.real(0.25, 0.45);
      const double side = i % 2 == 0 ? 1.0 : -1.0;
      layout_.add_solid(
          {layout_.back_m() + random_.real(0.35, 0.6), side * random_.real(0.2, 1.4), floor_m + 0.5 * size_m},
          {0.5 * size_m, 0.5 * size_m, 0.5 * size_m}, layout_.add_patch(size_m, size_m, 150.0, paint_carton));
    }
    walls(books, paint_floor_tiles);
  }

  /// Hardly anything to see: a wall of one colour, now and then a socket or a poster far to the side.
  void bare() {
    const double tone = random_.real(0.3, 0.6);
    const Painter plaster = [tone](Canvas& c, RandomGenerator& r) {
      c.fill(tone * Reflectance{1.0, r.real(0.95, 1.02), r.real(0.88, 1.0)});
      roughen(c, r, 0.5, 0.04, 4);
      c.darken_edges(0.25, 0.25);
    };
    for (int i = 0; i < several(1.4); ++i) {
      const Spot spot{(i % 2 == 0 ? 1.0 : -1.0) * random_.real(0.6, 1.4), random_.real(-0.1, 1.2), 0.0};
      if (random_.chance(0.5)) {
        const double width_m = random_.real(0.3, 0.5);
        layout_.add_panel(Facing::back_wall, spot, width_m, 1.3 * width_m, 170.0, paint_poster);
      } else {
        layout_.add_panel(Facing::back_wall, spot, 0.08, 0.08, 170.0, paint_screen);
      }
    }
    const Painter floor = [](Canvas& c, RandomGenerator& r) {
      c.fill(any_colour(r, 0.2, 0.4));
      roughen(c, r, 0.3, 0.08, 4);
      c.darken_edges(0.3, 0.3);
    };
    layout_.add_room(plaster, plaster, plaster, plaster, floor, plaster);
  }

  const LabConfig& config_;
  RandomGenerator random_;
  Layout layout_;
};

}  // namespace

Layout room_of_walls(const LabConfig& config, std::uint64_t seed) {
  return RoomOfWalls(config, seed).furnish();
}

}  // namespace saccade::lab
