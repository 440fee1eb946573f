#pragma once

#include <functional>

#include "sim/canvas.h"
#include "sim/random_generator.h"

// Painters of the lab's surfaces: each fills a canvas of any size with a randomly varied pattern of the surface's
// natural scale.
namespace saccade::lab {

/// Fills a canvas; the same random sequence gives the same colours.
using Painter = std::function<void(Canvas&, RandomGenerator&)>;

/// A colour whose brightness lies in [low, high), of any hue.
Reflectance any_colour(RandomGenerator& random, double low, double high);
/// Multiplies by exp(strength * noise), because reflectance varies by ratios. Features are feature_m wide and
/// `stretch` times as high.
void roughen(Canvas& canvas, RandomGenerator& random, double feature_m, double strength, int octaves,
             double falloff = 0.6, double stretch = 1.0);
/// Leaves that cover each other, from the largest to the smallest; `tone` is the spread of their log brightness.
void scatter_leaves(Canvas& canvas, RandomGenerator& random, double per_m2, double small_m, double large_m,
                    Reflectance colour, double tone);
/// Photographs pinned to the surface, tilted.
void pin_photographs(Canvas& canvas, RandomGenerator& random, double per_m2);

// Walls, floors, ceilings (lab_surfaces.cpp).
void paint_wall_panels(Canvas& canvas, RandomGenerator& random);
void paint_brick(Canvas& canvas, RandomGenerator& random);
void paint_foliage(Canvas& canvas, RandomGenerator& random);
/// A flowered cloth; with fold_m > 0 it hangs as a curtain with folds of that width.
void paint_cloth(Canvas& canvas, RandomGenerator& random, double fold_m);
/// Rock or bark with a spectrum as of natural scenes, the amplitude falling with 1/f.
void paint_natural(Canvas& canvas, RandomGenerator& random);
/// Slats of a blind across the whole canvas.
void paint_blinds(Canvas& canvas, RandomGenerator& random, double slat_m, bool upright);
void paint_floor_tiles(Canvas& canvas, RandomGenerator& random);
void paint_carpet(Canvas& canvas, RandomGenerator& random);
void paint_ceiling(Canvas& canvas, RandomGenerator& random, double roughness);

// Furniture and objects (lab_furniture_painters.cpp).
void paint_poster(Canvas& canvas, RandomGenerator& random);
void paint_window(Canvas& canvas, RandomGenerator& random);
/// Rows of shelves with the spines of books and binders.
void paint_books(Canvas& canvas, RandomGenerator& random, int rows);
void paint_door(Canvas& canvas, RandomGenerator& random);
void paint_whiteboard(Canvas& canvas, RandomGenerator& random);
void paint_drawers(Canvas& canvas, RandomGenerator& random);
void paint_carton(Canvas& canvas, RandomGenerator& random);
void paint_screen(Canvas& canvas, RandomGenerator& random);
void paint_desk(Canvas& canvas, RandomGenerator& random);
void paint_wood(Canvas& canvas, RandomGenerator& random);
/// A small object with a rough surface: a pot, a stone, a cushion.
void paint_rough(Canvas& canvas, RandomGenerator& random);

}  // namespace saccade::lab
