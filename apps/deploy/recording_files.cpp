#include "apps/deploy/recording_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <charconv>

#include "core/error.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t check_us = 1'000'000;

/// The number after the largest one of a pair of files in the folder, finished or not.
int next_number(const fs::path& folder) {
  int largest = 0;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    for (const std::string_view kind : {"events", "joints"}) {
      if (!name.starts_with(kind)) continue;
      int number = 1;
      if (name[kind.size()] == '_')
        std::from_chars(name.data() + kind.size() + 1, name.data() + name.size(), number);
      largest = std::max(largest, number);
    }
  }
  return largest + 1;
}

/// Puts the names of files in the folder on the disk.
void sync_folder(const fs::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  (void)::fsync(descriptor);
  ::close(descriptor);
}

}  // namespace

std::int64_t free_bytes(const fs::path& folder) {
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  return error ? INT64_MAX : static_cast<std::int64_t>(std::min<std::uintmax_t>(space.available, INT64_MAX));
}

RecordingFiles::RecordingFiles(fs::path folder, const FormatRegistry& formats, ImageSize image,
                               const RecordingFilesConfig& config)
    : folder_(std::move(folder)),
      formats_(formats),
      image_(image),
      config_(config),
      number_(next_number(folder_)) {
  if (free_bytes(folder_) < config_.least_free_bytes) {
    throw RunError(fmt::format("{}: {} MB free, --record needs output.least_free_mb: {}", folder_.string(),
                               free_bytes(folder_) / 1'000'000, config_.least_free_bytes / 1'000'000));
  }
  open(0);
  first_file_ = path("events", config_.format).filename().string();
}

fs::path RecordingFiles::path(const char* name, const std::string& ending) const {
  return folder_ /
         (number_ == 1 ? fmt::format("{}.{}", name, ending) : fmt::format("{}_{}.{}", name, number_, ending));
}

void RecordingFiles::open(std::int64_t t_us) {
  events_ = create_event_file(formats_, path("events", config_.format), image_);
  joints_.emplace(path("joints", "csv"), config_.head);
  sync_folder(folder_);
  opened_us_ = t_us;
  ++count_;
}

void RecordingFiles::write(std::int64_t t_us, std::span<const Event> events,
                           const std::optional<JointsRow>& joints) {
  if (!events_) return;
  if (opened_us_ == 0) opened_us_ = t_us;
  try {
    if (t_us - checked_us_ >= check_us) check(t_us);
    if (!events_) return;
    events_->write(events);
    if (joints) joints_->write(*joints);
  } catch (const RunError& error) {
    ended_ = std::string(error.what()) + ": the recording ended";
    events_.reset();
    joints_.reset();
  }
}

void RecordingFiles::check(std::int64_t t_us) {
  checked_us_ = t_us;
  if (free_bytes(folder_) < config_.least_free_bytes) {
    commit();
    ended_ =
        fmt::format("less than {} MB are free: the recording ended", config_.least_free_bytes / 1'000'000);
    return;
  }
  events_->sync();  // before its size is asked for
  joints_->sync();
  const fs::path part = path("events", config_.format).string() + ".part";
  std::error_code error;
  const std::uintmax_t size = fs::file_size(part, error);
  if (t_us - opened_us_ >= config_.rotate_us ||
      (!error && static_cast<std::int64_t>(size) >= config_.rotate_bytes)) {
    commit();
    ++number_;
    open(t_us);
  }
}

void RecordingFiles::commit() {
  if (!events_) return;
  events_->commit();
  joints_->commit();
  events_.reset();
  joints_.reset();
  sync_folder(folder_);
}

}  // namespace saccade
