#include "config/input_files.h"

#include <algorithm>
#include <filesystem>

#include "config/mentioned_files.h"

namespace saccade {
namespace {

bool is_readable_file(const std::string& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

}  // namespace

class InputFiles::Lister final : public FieldVisitor {
 public:
  explicit Lister(InputFiles& files) : files_(files) {}

  void real(std::string_view, double&, Range, std::string_view) override {}
  void integer(std::string_view, std::int64_t&, Range, std::string_view) override {}
  void boolean(std::string_view, bool&, std::string_view) override {}
  void text(std::string_view, std::string&, std::string_view) override {}
  void choice(std::string_view, std::string&, const std::vector<std::string>&, std::string_view) override {}
  void numbers(std::string_view, std::span<double>, Range, std::string_view) override {}
  void point_list(std::string_view, std::vector<double>&, std::size_t, Range, std::string_view) override {}
  void require(bool, std::string_view, std::string_view, std::string_view) override {}

  void path(std::string_view key, std::string& value, std::string_view) override {
    if (!is_readable_file(value)) return;
    add(path_of(key), value, false);
    // A model in MJCF names its meshes, textures and parts.
    if (std::filesystem::path(value).extension() == ".xml") add_mentioned(path_of(key), value, "");
  }
  void reads(std::string_view key, const std::string& folder,
             const std::function<std::vector<std::string>()>& files) override {
    bool in_arguments = false;
    for (const std::string& file : files()) {
      if (is_readable_file(file)) {
        add(path_of(key), file, in_arguments);
        add_mentioned(path_of(key), file, folder);
      }
      in_arguments = true;
    }
  }
  void section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
               std::string_view) override {
    const std::string outer = std::exchange(prefix_, path_of(key) + ".");
    describe_section(*this);
    prefix_ = outer;
  }

  [[nodiscard]] std::vector<FileDigest> take() && { return std::move(listed_); }

 private:
  [[nodiscard]] std::string path_of(std::string_view key) const { return prefix_ + std::string(key); }
  void add(const std::string& key, const std::string& path, bool mentioned) {
    const bool known =
        std::ranges::any_of(listed_, [&](const FileDigest& f) { return f.key == key && f.path == path; });
    if (!known) listed_.push_back({key, path, files_.digest_of(path), mentioned});
  }
  void add_mentioned(const std::string& key, const std::string& path, const std::string& folder) {
    for (const std::string& file : files_.mentioned_in(path, folder)) add(key, file, true);
  }

  InputFiles& files_;
  std::string prefix_;
  std::vector<FileDigest> listed_;
};

const std::string& InputFiles::digest_of(const std::string& path) {
  const auto [at, added] = digests_.try_emplace(path);
  if (added) at->second = digest_of_file(path);
  return at->second;
}

const std::vector<std::string>& InputFiles::mentioned_in(const std::string& path, const std::string& folder) {
  const auto [at, added] = mentioned_.try_emplace({path, folder});
  if (added) at->second = mentioned_files(path, folder);
  return at->second;
}

std::vector<FileDigest> InputFiles::of(const Describe& describe_keys) {
  Lister lister(*this);
  describe_keys(lister);
  return std::move(lister).take();
}

std::vector<FileDigest> InputFiles::of(const Scenario& scenario) {
  Scenario copy = scenario;
  return of([&](FieldVisitor& v) { describe(v, copy); });
}

std::vector<FileDigest> InputFiles::of(const NamedDetectors& detectors) {
  NamedDetectors copy = detectors;
  return of([&](FieldVisitor& v) { describe_detectors(v, copy); });
}

}  // namespace saccade
