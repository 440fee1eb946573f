#include "apps/deploy/shared_memory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "core/error.h"

namespace saccade::inline v0_1 {

SharedMemory::SharedMemory(const std::string& name, std::size_t size) : size_(size) {
  std::string file = "/saccade-" + name;
  std::replace(file.begin() + 1, file.end(), '/', '_');
  const auto fail = [&] {
    const std::string reason = std::generic_category().message(errno);
    if (file_ >= 0) ::close(file_);
    throw RunError("/dev/shm" + file + ": " + reason);
  };
  file_ = ::shm_open(file.c_str(), O_RDWR | O_CREAT, 0666);
  if (file_ < 0) fail();
  (void)::fchmod(file_, 0666);  // whoever runs the other process; not ours if another user created it
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

}  // namespace saccade::inline v0_1
