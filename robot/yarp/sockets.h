#pragma once

#include <netinet/in.h>
#include <sys/stat.h>
#include <unistd.h>

#include <utility>

namespace saccade {

/// A file that is closed at the end of its scope.
class File {
 public:
  explicit File(int number = -1) : number_(number) {}
  File(File&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  File& operator=(File&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }
  ~File() {
    if (number_ >= 0) ::close(number_);
  }
  [[nodiscard]] int get() const { return number_; }
  [[nodiscard]] bool is_open() const { return number_ >= 0; }
  int release() { return std::exchange(number_, -1); }

 private:
  int number_;
};

[[nodiscard]] bool same_socket(const sockaddr_in& a, const sockaddr_in& b);
/// Of the two ends of a connection; without an IPv4 address where the file is no such socket.
[[nodiscard]] sockaddr_in local_of(int socket);
[[nodiscard]] sockaddr_in remote_of(int socket);
void set_blocking(int socket, bool blocking);
/// Sends small messages at once.
void without_delay(int socket);
[[nodiscard]] bool listens(int socket);
/// Tells a file from a later one with the same number; 0 for none.
[[nodiscard]] ino_t inode_of(int file);

}  // namespace saccade
