#include "evaluation/image_codecs/ffmpeg_video.h"

#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

#include "core/error.h"
#include "recording/spawn_settings.h"

namespace saccade {
namespace {

class FfmpegVideo final : public VideoOutput {
 public:
  FfmpegVideo(std::string path, double images_hz, const cv::Size& size)
      : path_(std::move(path)), size_(size), messages_(std::tmpfile(), &std::fclose) {
    std::array<int, 2> ends{};
    // A socket, because a pipe whose reader has ended raises a signal.
    if (!messages_ || ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
      throw RunError(std::string("video: ffmpeg cannot be started: ") + std::strerror(errno));
    SpawnSettings settings;
    settings.use(ends[1], STDIN_FILENO);
    settings.use_nothing(STDOUT_FILENO);
    settings.use(fileno(messages_.get()), STDERR_FILENO);
    settings.own_process_group();
    const int error = settings.start(
        {"ffmpeg", "-hide_banner", "-loglevel", "error", "-y", "-f", "rawvideo", "-pixel_format", "bgr24",
         "-video_size", std::to_string(size.width) + "x" + std::to_string(size.height), "-framerate",
         std::to_string(images_hz), "-i", "pipe:0", "-an", "-pix_fmt", "yuv420p", "file:" + path_},
        child_);
    ::close(ends[1]);
    socket_ = ends[0];
    if (error == 0) return;
    child_ = -1;
    ::close(socket_);
    if (error == ENOENT)
      throw RunError(
          "video: the program ffmpeg is not installed; this installation of saccade has no video library of "
          "its own");
    throw RunError(std::string("video: ffmpeg cannot be started: ") + std::strerror(error));
  }
  FfmpegVideo(const FfmpegVideo&) = delete;
  FfmpegVideo& operator=(const FfmpegVideo&) = delete;
  ~FfmpegVideo() override {
    if (child_ < 0) return;
    ::kill(child_, SIGKILL);
    (void)exit_status();
  }

  void write(const cv::Mat& image) override {
    SACCADE_CHECK(child_ > 0 && image.type() == CV_8UC3 && image.size() == size_);
    const std::size_t row_bytes = image.elemSize() * static_cast<std::size_t>(image.cols);
    for (int y = 0; y < image.rows; ++y) send(image.ptr(y), row_bytes);
  }

  void close() override {
    SACCADE_CHECK(child_ > 0);
    if (exit_status() != 0) fail();
  }

 private:
  void send(const unsigned char* data, std::size_t bytes) {
    while (bytes > 0) {
      const ssize_t sent = ::send(socket_, data, bytes, MSG_NOSIGNAL);
      if (sent < 0 && errno == EINTR) continue;
      if (sent < 0) {
        (void)exit_status();
        fail();
      }
      data += sent;
      bytes -= static_cast<std::size_t>(sent);
    }
  }

  /// Ends the images, and waits until ffmpeg has written what it still has.
  int exit_status() {
    ::close(socket_);
    int status = 0;
    while (::waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
    child_ = -1;
    return status;
  }

  [[noreturn]] void fail() const {
    std::string text;
    std::rewind(messages_.get());
    for (int c = 0; (c = std::fgetc(messages_.get())) != EOF;) text.push_back(static_cast<char>(c));
    while (text.ends_with('\n')) text.pop_back();
    throw RunError("video: ffmpeg cannot write " + path_ + ": " + (text.empty() ? "no message" : text));
  }

  std::string path_;
  cv::Size size_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> messages_;  ///< ffmpeg's standard error
  pid_t child_ = -1;                                          ///< -1: it has ended
  int socket_ = -1;
};

}  // namespace

std::unique_ptr<VideoOutput> write_video_by_ffmpeg(const std::filesystem::path& path, double images_hz,
                                                   const cv::Size& size) {
  return std::make_unique<FfmpegVideo>(path.string(), images_hz, size);
}

}  // namespace saccade
