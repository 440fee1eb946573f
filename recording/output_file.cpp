#include "recording/output_file.h"

#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

namespace saccade::inline v0_1 {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const char* what) {
  const int cause = errno;
  const std::string message = path.string() + ": " + what + ": " + std::generic_category().message(cause);
  if (cause == ENOSPC || cause == EDQUOT || cause == EFBIG) throw DiskFull(message);
  throw RunError(message);
}

}  // namespace

void check_outputs(std::span<const std::filesystem::path> outputs,
                   std::span<const std::filesystem::path> inputs, bool force) {
  namespace fs = std::filesystem;
  for (const fs::path& output : outputs) {
    std::error_code error;
    for (const fs::path& input : inputs) {
      fs::path part = output;
      part += ".part";
      if (fs::equivalent(output, input, error) || fs::equivalent(part, input, error)) {
        throw InputError(output.string(), "the file that is read, " + input.string(), "another name");
      }
    }
    if (fs::is_directory(output, error)) {
      throw InputError(output.string(), "a folder", "the name of a file to write");
    }
    if (!force && fs::exists(output, error)) {
      throw InputError(output.string(), "a file that exists", "another name, or --force to replace it");
    }
  }
}

OutputFile::OutputFile(std::filesystem::path path) : path_(std::move(path)), part_(path_) {
  part_ += ".part";
  file_ = std::fopen(part_.c_str(), "wb");
  if (file_ == nullptr) fail(path_, "cannot be created");
}

OutputFile::~OutputFile() {
  if (file_ == nullptr) return;
  std::fclose(file_);
  if (!keeps_part_) std::remove(part_.c_str());
}

void OutputFile::write(std::span<const std::byte> bytes) {
  SACCADE_CHECK(file_ != nullptr);
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) fail(path_, "cannot be written");
}

void OutputFile::write(std::string_view text) { write(std::as_bytes(std::span(text))); }

void OutputFile::overwrite(std::int64_t offset, std::span<const std::byte> bytes) {
  SACCADE_CHECK(file_ != nullptr);
  if (::fseeko(file_, offset, SEEK_SET) != 0) fail(path_, "cannot be written");
  write(bytes);
  if (::fseeko(file_, 0, SEEK_END) != 0) fail(path_, "cannot be written");
}

void OutputFile::sync() {
  SACCADE_CHECK(file_ != nullptr);
  keeps_part_ = true;
  if (std::fflush(file_) != 0 || ::fdatasync(::fileno(file_)) != 0) fail(path_, "cannot be written");
}

void OutputFile::commit() {
  SACCADE_CHECK(file_ != nullptr);
  if (std::fflush(file_) != 0 || ::fsync(::fileno(file_)) != 0) fail(path_, "cannot be written");
  if (std::rename(part_.c_str(), path_.c_str()) != 0) fail(path_, "cannot be created");
  std::fclose(file_);
  file_ = nullptr;
}

void write_file(const std::filesystem::path& path, std::string_view text) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

}  // namespace saccade::inline v0_1
