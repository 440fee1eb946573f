#include "apps/session/run_folder.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "apps/session/interrupt.h"
#include "apps/session/summary.h"
#include "core/error.h"
#include "evaluation/report/report.h"
#include "recording/output_file.h"
#include "recording/run_file_names.h"

namespace saccade::inline v0_1 {
namespace {

namespace fs = std::filesystem;

}  // namespace

void prepare_run_folder(const fs::path& folder, bool force, const FormatRegistry& formats) {
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_directory(folder, error)) {
    throw InputError(folder.string(), "a file", "a folder for the run");
  }
  if (fs::exists(folder, error) && !fs::is_empty(folder, error)) {
    if (!force) throw InputError(folder.string(), "a folder that is not empty", "a new one, or --force");
    const std::vector<std::string> names_of_a_run = run_file_names(formats);
    bool holds_a_run = false;
    for (const std::string& name : names_of_a_run) holds_a_run |= fs::exists(folder / name, error);
    if (!holds_a_run) {
      for (const auto& entry : fs::directory_iterator(folder)) {
        holds_a_run |= entry.path().extension() == ".part";
      }
    }
    if (!holds_a_run) {
      throw InputError(folder.string(), "a folder with other files in it", "a new folder, or that of a run");
    }
    for (const std::string& name : names_of_a_run) {
      fs::remove_all(folder / name, error);
      fs::remove(folder / (name + ".part"), error);
    }
  }
  fs::create_directories(folder, error);
  if (error) throw RunError(folder.string() + ": cannot make the folder: " + error.message());
}

void start_run_folder(const fs::path& folder, bool force, const FormatRegistry& formats,
                      const std::string& name, const std::string& text) {
  prepare_run_folder(folder, force, formats);
  write_file(folder / name, text);
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

void finish_run_folder(const fs::path& folder, const Metrics& metrics, const FormatRegistry& formats) {
  write_report(folder, formats);
  print_summary(metrics);
  fmt::print("{}\n", (folder / "report.html").string());
  if (interrupted()) throw RunError("interrupted; the run folder holds what happened until then");
  throw_if_a_program_ended(metrics);
}

}  // namespace saccade::inline v0_1
