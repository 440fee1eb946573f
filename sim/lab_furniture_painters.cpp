#include <algorithm>

#include "sim/lab_painters.h"

namespace saccade::lab {
namespace {

/// Lines of blocks that look like printed words.
void text_lines(Canvas& canvas, RandomGenerator& random, double x, double y, double width, double height,
                double pitch_m, Reflectance ink) {
  for (double at = y; at + 0.5 * pitch_m < y + height; at += pitch_m) {
    const double end = random.chance(0.2) ? random.real(0.3, 0.8) : 1.0;
    double word = x;
    while (word < x + end * width) {
      const double length = std::min(pitch_m * random.real(0.8, 3.5), x + end * width - word);
      canvas.rectangle(word, at, length, 0.5 * pitch_m, ink);
      word += length + 0.6 * pitch_m;
    }
  }
}

}  // namespace

void paint_poster(Canvas& canvas, RandomGenerator& random) {
  const double w = canvas.width();
  const double h = canvas.height();
  const Reflectance paper = any_colour(random, 0.55, 0.75);
  const Reflectance ink = any_colour(random, 0.12, 0.2);
  canvas.fill(grey(0.16));  // the frame
  canvas.rectangle(0.02, 0.02, w - 0.04, h - 0.04, paper);
  canvas.rectangle(0.04, 0.04, w - 0.08, 0.12 * h, any_colour(random, 0.15, 0.35));
  text_lines(canvas, random, 0.06, 0.04 + 0.04 * h, w - 0.14, 0.05 * h, 0.05 * h, grey(0.75));
  const int across = w > 0.5 ? 3 : 2;
  const double cell_w = (w - 0.06) / across;
  const double cell_h = 0.27 * h;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < across; ++column) {
      const double x = 0.045 + column * cell_w;
      const double y = 0.2 * h + row * cell_h;
      const double cw = cell_w - 0.03;
      const double ch = cell_h - 0.02;
      switch (random.index(4)) {
        case 0:  // a bar chart
          canvas.rectangle(x, y, cw, ch, grey(0.7));
          for (double bar = 0.05; bar < 0.9; bar += 0.17) {
            const double tall = random.real(0.2, 0.85) * ch;
            canvas.rectangle(x + bar * cw, y + ch - tall, 0.11 * cw, tall, any_colour(random, 0.15, 0.4));
          }
          break;
        case 1:  // a block diagram
          canvas.rectangle(x, y, cw, ch, any_colour(random, 0.2, 0.5));
          for (int k = 0; k < 4; ++k) {
            const double block_x = x + random.real(0.02, 0.6) * cw;
            const double block_y = y + random.real(0.02, 0.7) * ch;
            canvas.rectangle(block_x, block_y, 0.3 * cw, 0.22 * ch, any_colour(random, 0.15, 0.7));
          }
          break;
        default:
          text_lines(canvas, random, x, y, cw, ch, 0.024, ink);
      }
    }
  }
}

void paint_window(Canvas& canvas, RandomGenerator& random) {
  const double w = canvas.width();
  const double h = canvas.height();
  canvas.each([&](double, double y, Reflectance) {
    return (0.86 - 0.2 * y / h) * Reflectance{0.9, 0.97, 1.1};
  });
  for (double x = -0.1; x < w; x += random.real(0.12, 0.3)) {  // houses across the street
    const double wide = random.real(0.12, 0.35);
    const double top = random.real(0.3, 0.75) * h;
    const Reflectance wall = any_colour(random, 0.25, 0.5);
    canvas.rectangle(x, top, wide, h - top, wall);
    for (double y = top + 0.05; y < h; y += 0.1) {
      for (double k = 0.03; k + 0.05 < wide; k += 0.08) canvas.rectangle(x + k, y, 0.045, 0.06, 0.4 * wall);
    }
  }
  const Reflectance frame = random.chance(0.5) ? grey(0.35) : Reflectance{0.22, 0.17, 0.12};
  const int columns = 2 + random.index(3);
  const int rows = 2 + random.index(3);
  for (int i = 0; i <= columns; ++i) {
    const double thick = i == 0 || i == columns ? 0.07 : 0.03;
    canvas.rectangle(i * (w - thick) / columns, 0.0, thick, h, frame);
  }
  for (int i = 0; i <= rows; ++i) {
    const double thick = i == 0 || i == rows ? 0.07 : 0.03;
    canvas.rectangle(0.0, i * (h - thick) / rows, w, thick, frame);
  }
}

void paint_books(Canvas& canvas, RandomGenerator& random, int rows) {
  canvas.fill(grey(0.13));
  const double pitch = canvas.height() / rows;
  const double h = pitch - 0.03;
  const Reflectance board = random.real(0.4, 0.6) * Reflectance{1.1, 0.95, 0.8};
  for (int row = 0; row < rows; ++row) {
    const double foot = row * pitch + h;
    canvas.rectangle(0.0, foot, canvas.width(), 0.03, board);
    for (double x = 0.0; x < canvas.width();) {
      if (random.chance(0.06)) {
        x += random.real(0.03, 0.12);
        continue;
      }
      const bool binder = random.chance(0.3);
      const double thick = binder ? random.real(0.055, 0.08) : random.real(0.02, 0.05);
      const double tall = (binder ? 0.92 : random.real(0.55, 0.9)) * h;
      const Reflectance cover = any_colour(random, 0.12, 0.62);
      const double top = foot - tall;
      canvas.rectangle(x, top, thick - 0.004, tall, cover);
      const Reflectance label = cover.g > 0.35 ? any_colour(random, 0.12, 0.2) : grey(0.7);
      if (binder) {
        canvas.rectangle(x + 0.01, top + 0.15 * tall, thick - 0.024, 0.35 * tall, label);
        canvas.rectangle(x + 0.3 * thick, top + 0.75 * tall, 0.3 * thick, 0.08 * tall, grey(0.12));
      } else if (random.chance(0.7)) {
        const double band = random.real(0.05, 0.25) * tall;
        canvas.rectangle(x, top + random.real(0.1, 0.3) * tall, thick - 0.004, band, label);
      }
      x += thick;
    }
  }
}

void paint_door(Canvas& canvas, RandomGenerator& random) {
  const double w = canvas.width();
  const double h = canvas.height();
  const Reflectance wood = any_colour(random, 0.25, 0.5);
  canvas.fill(grey(0.7));
  canvas.rectangle(0.06, 0.06, w - 0.12, h, wood);
  for (const double y : {0.12, 0.5}) {
    canvas.rectangle(0.16, y * h, w - 0.32, 0.34 * h, 0.6 * wood);
    canvas.rectangle(0.18, y * h + 0.02, w - 0.36, 0.34 * h - 0.04, 1.15 * wood);
  }
  canvas.rectangle(w - 0.15, 0.5 * h, 0.06, 0.12, grey(0.75));
}

void paint_whiteboard(Canvas& canvas, RandomGenerator& random) {
  const double w = canvas.width();
  const double h = canvas.height();
  canvas.fill(grey(0.3));
  canvas.rectangle(0.025, 0.025, w - 0.05, h - 0.05, grey(0.72));
  for (int i = 0; i < 9; ++i) {
    const double x = random.real(0.05, 0.8) * w;
    const double y = random.real(0.06, 0.75) * h;
    const Reflectance pen = any_colour(random, 0.1, 0.2);
    if (random.chance(0.5)) {
      text_lines(canvas, random, x, y, 0.2 * w, 0.2 * h, 0.04, pen);
    } else {
      const double bw = random.real(0.1, 0.2) * w;
      const double bh = random.real(0.1, 0.2) * h;
      canvas.rectangle(x, y, bw, bh, pen);
      canvas.rectangle(x + 0.012, y + 0.012, bw - 0.024, bh - 0.024, grey(0.7));
      canvas.rectangle(x + bw, y + 0.5 * bh, 0.12 * w, 0.012, pen);
    }
  }
}

void paint_drawers(Canvas& canvas, RandomGenerator& random) {
  const Reflectance body = any_colour(random, 0.3, 0.55);
  const int rows = 2 + random.index(4);
  const double h = canvas.height() / rows;
  canvas.fill(0.35 * body);
  for (int i = 0; i < rows; ++i) {
    canvas.rectangle(0.012, i * h + 0.012, canvas.width() - 0.024, h - 0.018, body);
    canvas.rectangle(0.35 * canvas.width(), i * h + 0.25 * h, 0.3 * canvas.width(), 0.1 * h, grey(0.16));
  }
}

void paint_carton(Canvas& canvas, RandomGenerator& random) {
  const Reflectance card = random.real(0.7, 1.3) * Reflectance{0.38, 0.29, 0.2};
  const double w = canvas.width();
  const double h = canvas.height();
  canvas.fill(0.6 * card);
  canvas.rectangle(0.012, 0.012, w - 0.024, h - 0.024, card);
  canvas.rectangle(0.42 * w, 0.0, 0.16 * w, h, grey(0.55));
  canvas.rectangle(0.08 * w, 0.45 * h, 0.3 * w, 0.3 * h, grey(0.68));
  text_lines(canvas, random, 0.1 * w, 0.5 * h, 0.25 * w, 0.2 * h, 0.03, grey(0.12));
}

void paint_screen(Canvas& canvas, RandomGenerator& random) {
  const double w = canvas.width();
  const double h = canvas.height();
  canvas.fill(grey(0.12));
  canvas.rectangle(0.02, 0.02, w - 0.04, h - 0.05, {0.16, 0.24, 0.36});
  for (int i = 0; i < 3; ++i) {
    const double x = random.real(0.05, 0.4) * w;
    const double y = random.real(0.08, 0.35) * h;
    const double ww = random.real(0.35, 0.5) * w;
    const double hh = random.real(0.35, 0.5) * h;
    const bool dark = random.chance(0.4);
    canvas.rectangle(x, y, ww, hh, grey(dark ? 0.13 : 0.72));
    canvas.rectangle(x, y, ww, 0.02, any_colour(random, 0.3, 0.5));
    text_lines(canvas, random, x + 0.01, y + 0.035, ww - 0.03, hh - 0.05, 0.022, grey(dark ? 0.6 : 0.16));
  }
}

void paint_desk(Canvas& canvas, RandomGenerator& random) {
  canvas.fill({0.42, 0.33, 0.24});
  roughen(canvas, random, 0.03, 0.12, 3, 0.6, 25.0);
  for (int i = 0; i < 10; ++i) {
    const double x = random.real(0.0, 0.9) * canvas.width();
    const double y = random.real(0.0, 0.8) * canvas.height();
    canvas.rectangle(x, y, 0.21, 0.15, any_colour(random, 0.2, 0.7));
    text_lines(canvas, random, x + 0.02, y + 0.02, 0.16, 0.11, 0.022, grey(0.2));
  }
}

void paint_wood(Canvas& canvas, RandomGenerator& random) {
  canvas.fill(random.real(0.3, 0.5) * Reflectance{1.1, 0.95, 0.8});
  roughen(canvas, random, 0.1, 0.05, 3);
}

void paint_rough(Canvas& canvas, RandomGenerator& random) {
  canvas.fill(any_colour(random, 0.22, 0.5));
  roughen(canvas, random, 0.12, 0.4, 5, 0.75);
}

}  // namespace saccade::lab
