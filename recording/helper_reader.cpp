#include "recording/helper_reader.h"

#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "core/error.h"
#include "recording/helper_process.h"
#include "recording/module_path.h"

namespace saccade {
namespace {

class HelperReader final : public EventReader {
 public:
  HelperReader(const std::string& name, const std::string& library, const HelperCommand& command)
      : process_(name, library, command) {
    HelperImageSize size{};
    const std::string opened = process_.receive(HelperMessageKind::opened).value_or("");
    if (opened.size() < sizeof size) process_.fail_of_library("(bad message)");
    std::memcpy(&size, opened.data(), sizeof size);
    if (size.width > 0 && size.height > 0) image_size_ = ImageSize{size.width, size.height};
    format_ = opened.substr(sizeof size);
  }

  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t count = 0;
    while (count < max_events) {
      if (next_ == block_.size() && !next_block(count > 0)) break;
      const std::size_t more = std::min(block_.size() - next_, max_events - count);
      const auto first = block_.begin() + static_cast<std::ptrdiff_t>(next_);
      events.insert(events.end(), first, first + static_cast<std::ptrdiff_t>(more));
      next_ += more;
      count += more;
    }
    return count;
  }
  [[nodiscard]] std::optional<ImageSize> image_size() const override { return image_size_; }
  [[nodiscard]] std::string format() const override { return format_; }

 private:
  /// False at the end; where the file is broken false too, as long as there are events to return first.
  bool next_block(bool has_events) {
    block_.clear();
    next_ = 0;
    if (failure_ && !has_events) throw InputError(*failure_);
    if (failure_ || ended_) return false;
    try {
      const std::optional<std::string> bytes = process_.receive(HelperMessageKind::events);
      ended_ = !bytes;
      if (bytes) take_events(*bytes);
    } catch (const InputError& error) {
      failure_ = error;
      if (!has_events) throw;
    }
    return !block_.empty();
  }

  void take_events(const std::string& bytes) {
    for (std::size_t i = 0; i + sizeof(HelperEvent) <= bytes.size(); i += sizeof(HelperEvent)) {
      HelperEvent sent;
      std::memcpy(&sent, bytes.data() + i, sizeof sent);
      block_.push_back({sent.t_us, sent.x, sent.y, sent.on != 0, sent.camera});
    }
  }

  HelperProcess process_;
  std::optional<ImageSize> image_size_;
  std::string format_;
  std::vector<Event> block_;
  std::size_t next_ = 0;
  bool ended_ = false;
  std::optional<InputError> failure_;
};

}  // namespace

std::unique_ptr<EventReader> open_in_helper(const std::string& name, const std::string& library,
                                            const HelperCommand& command) {
  return std::make_unique<HelperReader>(name, library, command);
}

namespace {

/// Where a helper may be, the first place first.
std::vector<std::filesystem::path> helper_folders() {
  namespace fs = std::filesystem;
  constexpr const char* below_prefix = "libexec/saccade";
  const fs::path own_folder = module_path().parent_path();
  std::vector<fs::path> folders = {own_folder};
  for (fs::path above = own_folder; above.has_relative_path(); above = above.parent_path()) {
    std::error_code ignored;
    if (const fs::path folder = above.parent_path() / below_prefix; fs::is_directory(folder, ignored))
      folders.push_back(folder);
  }
  if (const char* const data = std::getenv("SACCADE_DATA"); data != nullptr && *data != '\0')
    folders.push_back(fs::path(data) / "../.." / below_prefix);
  folders.insert(folders.end(), {SACCADE_LIBEXEC_DIR, SACCADE_BUILD_BIN_DIR});
  return folders;
}

/// Its path in the first folder that has it; empty where none has.
std::filesystem::path helper_in(const std::vector<std::filesystem::path>& folders,
                                std::string_view file_name) {
  for (const std::filesystem::path& folder : folders) {
    std::filesystem::path file = folder / file_name;
    if (::access(file.c_str(), R_OK) == 0) return file;
  }
  return {};
}

}  // namespace

bool has_helper(std::string_view file_name) { return !helper_in(helper_folders(), file_name).empty(); }

std::filesystem::path find_helper(std::string_view file_name) {
  const std::vector<std::filesystem::path> folders = helper_folders();
  if (std::filesystem::path file = helper_in(folders, file_name); !file.empty()) return file;
  std::string searched;
  for (const std::filesystem::path& folder : folders) {
    searched += (searched.empty() ? "" : ", ") + folder.string();
  }
  throw RunError("the file " + std::string(file_name) + " is missing; searched in " + searched);
}

const void* helper_symbol(std::string_view file_name, const char* symbol) {
  // Loaded once: the system's loader returns the same library from then on.
  void* const library = ::dlopen(find_helper(file_name).c_str(), RTLD_NOW | RTLD_LOCAL);
  const void* const found = library != nullptr ? ::dlsym(library, symbol) : nullptr;
  if (found == nullptr) throw RunError(std::string(file_name) + " cannot be loaded: " + ::dlerror());
  return found;
}

}  // namespace saccade
