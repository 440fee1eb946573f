#include "tests/deploy/disk_fault.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/error.h"
#include "recording/input_file.h"

namespace saccade {
namespace {

/// Writes nothing, until the disk has its fault.
class FaultyWriter final : public EventWriter {
 public:
  explicit FaultyWriter(FaultKind kind) : kind_(kind) {}
  void write(std::span<const Event>) override {
    if (++calls_ > 150) fail();
  }
  void sync() override { fail(); }
  void commit() override {}

 private:
  void fail() const {
    if (kind_ == FaultKind::disk_full) throw DiskFull("events.faulty: cannot be written: no room");
    if (kind_ == FaultKind::disk_fails)
      throw RunError("events.faulty: cannot be written: input/output error");
    if (calls_ % 500 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }

  FaultKind kind_;
  int calls_ = 0;
};

}  // namespace

DiskFault::Quiet::Quiet() : out_(::dup(STDOUT_FILENO)), error_(::dup(STDERR_FILENO)) {
  std::fflush(nullptr);
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(nowhere, STDERR_FILENO);
  ::close(nowhere);
}

DiskFault::Quiet::~Quiet() {
  std::fflush(nullptr);
  ::dup2(out_, STDOUT_FILENO);
  ::dup2(error_, STDERR_FILENO);
  ::close(out_);
  ::close(error_);
}

DiskFault::DiskFault(FaultKind kind, const Loop& loop, std::uint64_t number)
    : kind_(kind),
      folder_(std::filesystem::temp_directory_path() /
              fmt::format("saccade-disk-{}-{}", ::getpid(), number)) {
  std::filesystem::create_directories(folder_);
  RecordingFormat format;
  format.name = "faulty";
  format.extensions = {".faulty"};
  format.sniff = [](const FileStart&) { return Match::none; };
  format.open = [](InputFile, const EventReadOptions&) -> std::unique_ptr<EventReader> { return nullptr; };
  format.create = [kind](const std::filesystem::path&, ImageSize, int) {
    return std::make_unique<FaultyWriter>(kind);
  };
  file_.output.formats.add(format);
  file_.output.events = "faulty";
  file_.output.least_free_mb = 0;
  DeployFacts facts;
  facts.record = true;
  recorder_ = std::make_unique<DeployRecorder>(folder_, file_, loop, ImageSize{128, 128}, std::move(facts));
}

DiskFault::~DiskFault() {
  recorder_.reset();
  std::error_code ignored;
  std::filesystem::remove_all(folder_, ignored);
}

std::string DiskFault::problem() {
  recorder_->finish();
  const auto json = nlohmann::json::parse(std::ifstream(folder_ / "deploy.json"));
  const std::string ended = json.at("recording_ended");
  if (json.at("not_recorded").at("ticks") != 0) return "ticks are missing in the tables";
  if (ended.empty() != (kind_ == FaultKind::disk_slow)) return "the recording's end is not named: " + ended;
  return {};
}

}  // namespace saccade
