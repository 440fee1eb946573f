#include "session/run_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <vector>

#include "core/error.h"
#include "evaluation/report/report.h"
#include "recording/output_file.h"
#include "recording/run_file_names.h"
#include "session/interrupt.h"
#include "session/summary.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

/// Whether the folder holds no other file than the lock of a run.
bool is_unused(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().filename() != run_file::lock) return false;
  }
  return true;
}

/// Throws InputError for a folder that must not be used.
void check_run_folder(const fs::path& folder, bool force, const std::vector<std::string>& names_of_a_run) {
  std::error_code error;
  if (!fs::exists(folder, error)) return;
  if (!fs::is_directory(folder, error)) throw InputError(folder.string(), "a file", "a folder for the run");
  if (is_unused(folder)) return;
  if (is_locked(folder / run_file::lock))
    throw InputError(folder.string(), "a run at work in it", "another folder, or wait for its end");
  if (!force) throw InputError(folder.string(), "a folder that is not empty", "a new one, or --force");
  const auto is_of_a_run = [&](const fs::path& path) {
    return path.extension() == ".part" || std::ranges::count(names_of_a_run, path.filename().string()) > 0;
  };
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (is_of_a_run(entry.path())) return;
  }
  throw InputError(folder.string(), "a folder with other files in it", "a new folder, or that of a run");
}

}  // namespace

RunFolderLock::RunFolderLock(fs::path folder) : file_(folder / run_file::lock) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw RunError(folder.string() + ": cannot make the folder: " + error.message());
  constexpr int most_tries = 10;  // a run that ends removes the file that this one has opened
  for (int i = 0; i < most_tries && (lock_ == nullptr || !lock_->has_its_name()); ++i) {
    lock_ = std::make_unique<FileLock>(file_);
    if (!lock_->held())
      throw InputError(folder.string(), "a run at work in it", "another folder, or wait for its end");
  }
}

RunFolderLock::~RunFolderLock() {
  std::error_code ignored;
  fs::remove(file_, ignored);  // before the lock ends: nobody else can hold it
}

std::unique_ptr<RunFolderLock> prepare_run_folder(const fs::path& folder, bool force,
                                                  const FormatRegistry& formats) {
  const std::vector<std::string> names_of_a_run = run_file_names(formats);
  check_run_folder(folder, force, names_of_a_run);
  auto lock = std::make_unique<RunFolderLock>(folder);
  std::error_code error;
  if (is_unused(folder)) return lock;
  // Another run may have made its files since the check.
  if (!force) throw InputError(folder.string(), "a folder that is not empty", "a new one, or --force");
  for (const std::string& name : names_of_a_run) {
    fs::remove_all(folder / name, error);
    fs::remove(folder / (name + ".part"), error);
  }
  return lock;
}

std::unique_ptr<RunFolderLock> start_run_folder(const fs::path& folder, bool force,
                                                const FormatRegistry& formats, const std::string& name,
                                                const std::string& text) {
  auto lock = prepare_run_folder(folder, force, formats);
  write_file(folder / name, text);
  return lock;
}

void throw_if_a_program_ended(const Metrics& metrics) {
  std::string text;
  for (const auto& [name, score] : metrics.detectors) {
    if (!score.failure.empty())
      text += (text.empty() ? "" : "\n") + fmt::format("detector {}: {}", name, score.failure);
  }
  const std::string controller = metrics.gaze ? metrics.gaze->failure : metrics.controller_failure;
  if (!controller.empty())
    text += (text.empty() ? "" : "\n") + fmt::format("gaze controller: {}", controller);
  if (!text.empty()) throw RunError(text);
}

void report_run_folder(const fs::path& folder, const Metrics& metrics, const FormatRegistry& formats) {
  write_report(folder, formats);
  print_summary(metrics);
  print_page(folder);
}

void finish_run_folder(const fs::path& folder, const Metrics& metrics, const FormatRegistry& formats) {
  report_run_folder(folder, metrics, formats);
  if (interrupted()) throw RunError("interrupted; the run folder holds what happened until then");
  throw_if_a_program_ended(metrics);
}

}  // namespace saccade
