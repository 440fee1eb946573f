#include "apps/deploy/shared_memory.h"

#include <fcntl.h>
#include <pwd.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <system_error>
#include <thread>

#include "core/error.h"

namespace saccade {

namespace {

constexpr int most_attempts = 50;  // of a process that races with another one for the creation of the file

/// Opens an existing file, or creates it. Never O_CREAT on an existing file: in a folder like /dev/shm, with
/// fs.protected_regular = 2, Linux denies that for the file of another user, to root too. -1 and errno on failure.
int open_or_create(const std::string& file) {
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    int found = ::shm_open(file.c_str(), O_RDWR, 0);
    if (found >= 0) return found;
    if (errno == ENOENT) {
      found = ::shm_open(file.c_str(), O_RDWR | O_CREAT | O_EXCL, 0666);
      if (found >= 0) {
        (void)::fchmod(found, 0666);  // whatever the umask: another user may run the other process
        return found;
      }
      if (errno != EEXIST) return -1;  // another process has just created it
    } else if (errno != EACCES) {
      return -1;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));  // its creator is about to permit others
  }
  return -1;
}

std::string user_name(uid_t user) {
  std::array<char, 1024> text{};
  passwd entry{};
  passwd* found = nullptr;
  if (::getpwuid_r(user, &entry, text.data(), text.size(), &found) == 0 && found != nullptr)
    return found->pw_name;
  return "number " + std::to_string(user);
}

/// Whose the file is and what to do, if another user may not write it.
std::string owner_hint(const std::string& file) {
  struct stat found {};
  if (::lstat(file.c_str(), &found) != 0 || found.st_uid == ::geteuid()) return {};
  return ": it belongs to the user " + user_name(found.st_uid) +
         ", who does not permit others to write it; run as that user, or remove it: sudo rm " + file;
}

}  // namespace

SharedMemory::SharedMemory(const std::string& name, std::size_t size) : size_(size) {
  std::string file = "/saccade-" + name;
  std::replace(file.begin() + 1, file.end(), '/', '_');
  const auto fail = [&] {
    const int error = errno;
    if (file_ >= 0) ::close(file_);
    const std::string path = "/dev/shm" + file;
    throw RunError(path + ": " + std::generic_category().message(error) +
                   (error == EACCES || error == EPERM ? owner_hint(path) : std::string()));
  };
  file_ = open_or_create(file);
  if (file_ < 0) fail();
  struct stat found {};
  if (::fstat(file_, &found) != 0) fail();
  if (static_cast<std::size_t>(found.st_size) < size && ::ftruncate(file_, static_cast<off_t>(size)) != 0)
    fail();
  data_ = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, file_, 0);
  if (data_ == MAP_FAILED) fail();
}

SharedMemory::~SharedMemory() {
  ::munmap(data_, size_);
  ::close(file_);
}

bool SharedMemory::lock() { return ::flock(file_, LOCK_EX | LOCK_NB) == 0; }

std::int64_t machine_ns() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{1'000'000'000} * now.tv_sec + now.tv_nsec;
}

}  // namespace saccade
