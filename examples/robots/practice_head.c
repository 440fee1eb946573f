/* A head of two joints that sees a ball: practice_head.py in C; docs/external_robots.md has the protocol. For little-endian machines.
 * usage: practice_head SOCKET    path of a Unix socket; scenarios/robots/external.yaml goes with it (external.address) */
#define _DEFAULT_SOURCE
#include <math.h>
#include <poll.h>
#include <stdint.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>
enum { size = 128, most = 8, hello = 1, events = 2, reading = 3, client = 16, activate, reference, stop, let_go, heartbeat };
static const double focal = 99.0, lag_s = 0.03, watchdog_s = 0.06, limits[2] = {1.5708, 1.0472}, speed = 4.3;
static struct { int fd; size_t held; uint8_t bytes[4096]; } clients[most]; /* what came from each */
static int owner = -1;                                                     /* index of who moves the head */
static uint64_t number; /* of the activation */
static double position[2], wanted[2], heard_s;
static uint8_t out[1 << 19], seen[size][size];
static size_t length;
static double now_s(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
static void put(const void* bytes, size_t count) { memcpy(out + length, bytes, count), length += count; }
static void put_i64(int64_t value) { put(&value, 8); }
static void release(void) { owner = -1, number = 0, memcpy(wanted, position, sizeof wanted); }
static void drop(int c) {
  if (c == owner) release();
  close(clients[c].fd), clients[c].fd = -1;
}
static void put_hello(int64_t t_us) {
  const uint32_t before[6] = {hello, 8 + 16 + 8 + 12 + 2 * 56, 1, size, size, (uint32_t)(1e3 * watchdog_s)}, after[3] = {0, 0, 2};
  length = 0, put(before, 8), put("saccade", 8), put(before + 2, 16), put_i64(t_us), put(after, 12);
  for (int j = 0; j < 2; ++j) put((char[32]){"pan"}, 32), put((double[]){-limits[j], limits[j], speed}, 24);
  memcpy(out + length - 56, "tilt", 4);
}
static void take(int c, uint32_t kind, const uint8_t* payload) {
  uint64_t of = 0;
  double to[2] = {0, 0};
  if (kind != client) memcpy(&of, payload, 8);
  if (kind == reference) memcpy(to, payload + 8, 16);
  if (kind == activate && (owner < 0 || owner == c)) release(), owner = c, number = of;
  if (c == owner) heard_s = now_s();
  if (c == owner && kind == reference && of == number && fabs(to[0]) <= limits[0] && fabs(to[1]) <= limits[1]) memcpy(wanted, to, 16);
  if (c == owner && kind == stop) memcpy(wanted, position, sizeof wanted);
  if (kind == let_go) release();
}
static void receive(int c) {
  const ssize_t got = read(clients[c].fd, clients[c].bytes + clients[c].held, sizeof clients[c].bytes - clients[c].held);
  if (got <= 0) { drop(c); return; }
  clients[c].held += (size_t)got;
  for (uint32_t head[2]; clients[c].held >= 8;) {
    memcpy(head, clients[c].bytes, 8);
    const uint32_t due = head[0] == reference ? 24 : 8;
    if (head[0] < client || head[0] > heartbeat || head[1] != due) { drop(c); return; } /* not the protocol */
    if (clients[c].held < 8 + due) return;
    take(c, head[0], clients[c].bytes + 8);
    memmove(clients[c].bytes, clients[c].bytes + 8 + due, clients[c].held -= 8 + due);
  }
}
static void put_events(int64_t t_us) { /* of the pixels that the ball's disc covers or leaves */
  const double turn = 6.2831853 * 1e-6 * (double)t_us / 4, x0 = 0.04 * cos(turn), y0 = 0.04 * sin(turn), z0 = 0.45;
  const double x = x0 * cos(position[0]) - z0 * sin(position[0]), z1 = x0 * sin(position[0]) + z0 * cos(position[0]);
  const double y = y0 * cos(position[1]) - z1 * sin(position[1]), z = y0 * sin(position[1]) + z1 * cos(position[1]);
  length = 0, put((uint32_t[]){events, 0}, 8), put_i64(t_us);
  for (uint16_t v = 0; v < size; ++v)
    for (uint16_t u = 0; u < size; ++u) {
      const uint8_t on = hypot(u - (0.5 * size + focal * x / z), v - (0.5 * size - focal * y / z)) <= focal * 0.0475 / z;
      if (on != seen[v][u]) put_i64(t_us), put(&u, 2), put(&v, 2), put((uint8_t[]){on, 0, 0, 0}, 4);
      seen[v][u] = on;
    }
  memcpy(out + 4, &(uint32_t){(uint32_t)length - 8}, 4);
}
int main(int argc, char** argv) {
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  if (argc != 2 || strlen(argv[1]) >= sizeof address.sun_path) return 2;
  unlink(strcpy(address.sun_path, argv[1]));
  struct pollfd ready[most + 1] = {{socket(AF_UNIX, SOCK_STREAM, 0), POLLIN, 0}};
  if (bind(ready[0].fd, (struct sockaddr*)&address, sizeof address) != 0 || listen(ready[0].fd, most) != 0) return 1;
  for (int c = 0; c < most; ++c) clients[c].fd = -1;
  for (double then = now_s();; usleep(1000)) {
    for (int c = 0; c < most; ++c) ready[c + 1] = (struct pollfd){clients[c].fd, POLLIN, 0};
    poll(ready, most + 1, 0);
    const double now = now_s(), dt = now - then, was[2] = {position[0], position[1]};
    for (int c = 0; c < most; ++c) {
      if (ready[c + 1].revents) receive(c);
      if (!ready[0].revents || clients[c].fd >= 0) continue;
      clients[c].fd = accept(ready[0].fd, NULL, NULL), clients[c].held = 0, ready[0].revents = 0, put_hello((int64_t)(1e6 * now));
      if (send(clients[c].fd, out, length, MSG_NOSIGNAL) < 0) drop(c);
    }
    if (owner >= 0 && now - heard_s > watchdog_s) release();
    for (int j = 0; j < 2; ++j) position[j] += (1 - exp(-dt / lag_s)) * (wanted[j] - position[j]);
    then = now, put_events((int64_t)(1e6 * now)), put((uint32_t[]){reading, 16 + 2 * 24}, 8);
    put_i64((int64_t)(1e6 * now)), put_i64((int64_t)number);
    for (int j = 0; j < 2; ++j) put(&position[j], 8), put(&(double){(position[j] - was[j]) / dt}, 8), put_i64(owner >= 0 ? 1 : 2);
    for (int c = 0; c < most; ++c) /* one that does not read is dropped */
      if (clients[c].fd >= 0 && send(clients[c].fd, out, length, MSG_NOSIGNAL | MSG_DONTWAIT) != (ssize_t)length) drop(c);
  }
}
