#include "recording/file_lock.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "recording/output_file.h"

namespace saccade {
namespace {

struct flock whole_file(short kind) {
  struct flock lock = {};
  lock.l_type = kind;
  lock.l_whence = SEEK_SET;
  return lock;
}

}  // namespace

FileLock::FileLock(const std::filesystem::path& path)
    : path_(path), file_(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666)) {
  if (file_ < 0) {
    const int cause = errno;
    const std::string message =
        path.string() + ": cannot be created: " + std::generic_category().message(cause);
    if (cause == ENOSPC || cause == EDQUOT) throw DiskFull(message);
    throw RunError(message);
  }
  struct flock hold = whole_file(F_WRLCK);
  held_ = ::fcntl(file_, F_OFD_SETLK, &hold) == 0;
}

FileLock::~FileLock() { ::close(file_); }

bool FileLock::has_its_name() const {
  struct stat locked = {};
  struct stat named = {};
  return ::fstat(file_, &locked) == 0 && ::stat(path_.c_str(), &named) == 0 &&
         locked.st_ino == named.st_ino && locked.st_dev == named.st_dev;
}

bool is_locked(const std::filesystem::path& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (file < 0) return false;
  struct flock hold = whole_file(F_WRLCK);
  const bool locked = ::fcntl(file, F_OFD_GETLK, &hold) == 0 && hold.l_type != F_UNLCK;
  ::close(file);
  return locked;
}

}  // namespace saccade
