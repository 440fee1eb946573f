/* A detector of one's own in C: a ring that mean shift moves onto the newest events (docs/external_detectors.md).
   cc -O2 -o ring_mean_shift ring_mean_shift.c -lm */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EVENTS = 500, SECTORS = 24 };
static const double r_min = 4, r_max = 25, ring_width = 2.0, threshold = 0.5, pi = 3.14159265358979323846;

typedef struct { double x, y, r, score; } Circle;

static double xs[EVENTS], ys[EVENTS]; /* the newest events, a ring buffer */
static long seen;
static int width, height;

static double clamp(double v, double low, double high) { return v < low ? low : v > high ? high : v; }

static Circle moved(Circle c) {
  const double widths[4] = {3 * ring_width, 2 * ring_width, ring_width, ring_width};
  for (int k = 0; k < 4; ++k) {
    double sum = 1e-9, dx = 0, dy = 0, dr = 0;
    for (int i = 0; i < EVENTS; ++i) {
      const double ox = xs[i] - c.x, oy = ys[i] - c.y, d = hypot(ox, oy) + 1e-9, error = d - c.r;
      const double weight = exp(-0.5 * error * error / (widths[k] * widths[k]));
      sum += weight;
      dx += weight * error * ox / d;
      dy += weight * error * oy / d;
      dr += weight * error;
    }
    /* Half of the directions of a ring lie along an axis, hence twice the mean. */
    c.x = clamp(c.x + 2 * dx / sum, 0, width - 1);
    c.y = clamp(c.y + 2 * dy / sum, 0, height - 1);
    c.r = clamp(c.r + dr / sum, r_min, r_max);
  }
  return c;
}

/* Share of the outline with events on it, times the share of events on the outline of those on and inside. */
static double score_of(Circle c) {
  int on = 0, inside = 0, covered = 0, hit[SECTORS] = {0};
  for (int i = 0; i < EVENTS; ++i) {
    const double ox = xs[i] - c.x, oy = ys[i] - c.y, error = hypot(ox, oy) - c.r;
    if (error < -ring_width) ++inside;
    if (fabs(error) > ring_width) continue;
    ++on;
    hit[(int)((atan2(oy, ox) / (2 * pi) + 0.5) * SECTORS) % SECTORS] = 1;
  }
  for (int s = 0; s < SECTORS; ++s) covered += hit[s];
  return (double)covered / SECTORS * on / (on + inside > 0 ? on + inside : 1);
}

static int ascending(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

static double median(const double* values) {
  double sorted[EVENTS];
  memcpy(sorted, values, sizeof sorted);
  qsort(sorted, EVENTS, sizeof *sorted, ascending);
  return 0.5 * (sorted[(EVENTS - 1) / 2] + sorted[EVENTS / 2]);
}

int main(void) {
  char line[4096];
  Circle last = {0};
  if (!fgets(line, sizeof line, stdin)) return 1; /* saccade-detector 1 */
  if (!fgets(line, sizeof line, stdin) || sscanf(line, "camera %d %d", &width, &height) != 2) return 1;
  printf("ready %.17g\n", threshold);
  fflush(stdout);
  long long now_us, t_us;
  long count;
  while (fgets(line, sizeof line, stdin) && sscanf(line, "tick %lld %ld", &now_us, &count) == 2) {
    for (long i = 0; i < count; ++i) {
      int x, y, on;
      if (!fgets(line, sizeof line, stdin) || sscanf(line, "%lld %d %d %d", &t_us, &x, &y, &on) != 4) return 1;
      xs[seen % EVENTS] = x;
      ys[seen++ % EVENTS] = y;
    }
    Circle best = {0, 0, 0, -1};
    if (seen >= EVENTS) {
      const double shares[3] = {0.2, 0.5, 0.8}; /* of the radii, around the median; or the last circle while it is good */
      const int starts = last.score >= threshold ? 1 : 3;
      for (int k = 0; k < starts; ++k) {
        Circle start = last;
        if (starts == 3) start = (Circle){median(xs), median(ys), r_min + shares[k] * (r_max - r_min), 0};
        Circle c = moved(start);
        c.score = score_of(c);
        if (c.score > best.score) best = c;
      }
      last = best;
    }
    if (seen < EVENTS) printf("none\n");
    else printf("circle %.17g %.17g %.17g %.17g\n", best.x, best.y, best.r, best.score);
    fflush(stdout);
  }
  return 0;
}
