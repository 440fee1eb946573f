#include "apps/sweep/sweep_folder.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "recording/output_file.h"

namespace saccade::inline v0_1 {

namespace fs = std::filesystem;

namespace {

struct flock whole_file(short kind) {
  struct flock lock = {};
  lock.l_type = kind;
  lock.l_whence = SEEK_SET;
  return lock;
}

}  // namespace

bool SweepFolder::has_result(const std::string& id) const { return finished(id).has_value(); }

std::optional<fs::file_time_type> SweepFolder::finished(const std::string& id) const {
  for (const char* name : {"metrics.json", "failure.txt"}) {
    std::error_code error;
    const fs::file_time_type time = fs::last_write_time(run(id) / name, error);
    if (!error) return time;
  }
  return std::nullopt;
}

bool SweepFolder::is_running(const std::string& id) const { return is_locked(run(id) / "log.txt"); }

FileLock::FileLock(const fs::path& path)
    : file_(::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666)) {
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

bool is_locked(const fs::path& path) {
  const int file = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (file < 0) return false;
  struct flock hold = whole_file(F_WRLCK);
  const bool locked = ::fcntl(file, F_OFD_GETLK, &hold) == 0 && hold.l_type != F_UNLCK;
  ::close(file);
  return locked;
}

}  // namespace saccade::inline v0_1
