#include "recording/helper_server.h"

#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "recording/helper_protocol.h"

namespace saccade {
namespace {

void send_bytes(int pipe, const void* data, std::size_t bytes) {
  const char* at = static_cast<const char*>(data);
  while (bytes > 0) {
    const ssize_t n = ::write(pipe, at, bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) ::_exit(1);
    at += n;
    bytes -= static_cast<std::size_t>(n);
  }
}

void send(int pipe, HelperMessageKind kind, std::string_view payload) {
  const HelperMessage message{kind, static_cast<std::uint32_t>(payload.size())};
  send_bytes(pipe, &message, sizeof message);
  send_bytes(pipe, payload.data(), payload.size());
}

void send_events(int pipe, std::span<const Event> events) {
  std::array<HelperEvent, helper_block_events> sent;
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Event& e = events[i];
    sent[i] = {e.t_us, e.x, e.y, static_cast<std::uint8_t>(e.on ? 1 : 0), e.camera, 0};
  }
  send(pipe, HelperMessageKind::events,
       {reinterpret_cast<const char*>(sent.data()), events.size() * sizeof(HelperEvent)});
}

void send_recording(int pipe, const std::function<std::unique_ptr<EventReader>()>& open, unsigned limit_s) {
  ::alarm(limit_s);
  const std::unique_ptr<EventReader> reader = open();
  const ImageSize size = reader->image_size().value_or(ImageSize{0, 0});
  const HelperImageSize sent{size.width, size.height};
  send(pipe, HelperMessageKind::opened,
       std::string(reinterpret_cast<const char*>(&sent), sizeof sent).append(reader->format()));
  std::vector<Event> block;
  for (;;) {
    block.clear();
    ::alarm(limit_s);
    const std::size_t count = reader->read(block, helper_block_events);
    ::alarm(0);  // sending waits for the process that reads the pipe
    if (count == 0) break;
    send_events(pipe, block);
  }
  send(pipe, HelperMessageKind::end, {});
}

void send_array(int pipe, const std::function<std::unique_ptr<ArrayRows>()>& open, unsigned limit_s) {
  ::alarm(limit_s);
  const std::unique_ptr<ArrayRows> array = open();
  if (!array) {
    send(pipe, HelperMessageKind::end, {});
    return;
  }
  const std::vector<std::uint64_t> lengths(array->shape().begin(), array->shape().end());
  const HelperArray sent{static_cast<std::uint32_t>(array->type()),
                         static_cast<std::uint32_t>(lengths.size())};
  send(pipe, HelperMessageKind::opened,
       std::string(reinterpret_cast<const char*>(&sent), sizeof sent)
           .append(reinterpret_cast<const char*>(lengths.data()), lengths.size() * sizeof(std::uint64_t)));
  std::string row;
  for (;;) {
    ::alarm(limit_s);
    const bool is_row = array->next(row);
    ::alarm(0);
    if (!is_row) break;
    for (std::size_t at = 0; at < row.size(); at += helper_most_bytes)
      send(pipe, HelperMessageKind::rows, std::string_view(row).substr(at, helper_most_bytes));
  }
  send(pipe, HelperMessageKind::end, {});
}

template <class Send>
[[noreturn]] void serve(int pipe, const Send& send_all) {
  // A sanitizer's handlers would turn signals into exit statuses.
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) std::signal(signal, SIG_DFL);
  std::signal(SIGINT, SIG_IGN);  // the process that reads the pipe decides when to stop
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  try {
    send_all();
  } catch (const InputError& error) {
    const Problem& problem = error.problems().front();
    send(pipe, HelperMessageKind::bad_input,
         problem.place + '\0' + problem.value + '\0' + problem.expectation);
  } catch (const std::exception& error) {
    send(pipe, HelperMessageKind::failure, error.what());
  }
  ::_exit(0);
}

}  // namespace

void serve_events(int pipe, const std::function<std::unique_ptr<EventReader>()>& open, unsigned limit_s) {
  serve(pipe, [&] { send_recording(pipe, open, limit_s); });
}

void serve_array(int pipe, const std::function<std::unique_ptr<ArrayRows>()>& open, unsigned limit_s) {
  serve(pipe, [&] { send_array(pipe, open, limit_s); });
}

}  // namespace saccade
