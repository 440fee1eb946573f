#include "apps/view/own_detector.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "core/error.h"

namespace saccade {
namespace {

/// Sets one text of a config.
class TextSetter final : public FieldVisitor {
 public:
  TextSetter(std::string key, std::string value) : key_(std::move(key)), value_(std::move(value)) {}

  void text(std::string_view key, std::string& value, std::string_view) override {
    if (key == key_) value = value_;
  }
  void real(std::string_view, double&, Range, std::string_view) override {}
  void integer(std::string_view, std::int64_t&, Range, std::string_view) override {}
  void boolean(std::string_view, bool&, std::string_view) override {}
  void choice(std::string_view, std::string&, const std::vector<std::string>&, std::string_view) override {}
  void numbers(std::string_view, std::span<double>, Range, std::string_view) override {}
  void point_list(std::string_view, std::vector<double>&, std::size_t, Range, std::string_view) override {}
  void section(std::string_view, const std::function<void(FieldVisitor&)>&, std::string_view) override {}
  void require(bool, std::string_view, std::string_view, std::string_view) override {}

 private:
  std::string key_, value_;
};

/// Letters, digits, _ and - of a text, at most 40.
std::string name_from(std::string text) {
  std::erase_if(
      text, [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '_' && c != '-'; });
  constexpr std::size_t longest = 40;
  text.resize(std::min(text.size(), longest));
  return text.empty() ? "mine" : text;
}

}  // namespace

ViewDetector own_detector(const DetectorRegistry& detectors, const std::string& text,
                          std::span<const ViewDetector> others) {
  namespace fs = std::filesystem;
  const std::size_t colon = text.rfind(".py:");
  const bool is_python = colon != std::string::npos;
  const std::string file = is_python ? text.substr(0, colon + 3) : text;
  const auto row =
      std::ranges::find(detectors.rows(), is_python ? "python" : "command", &DetectorRow::selecting_key);
  if (row == detectors.rows().end()) throw InputError("detector", text, "a preset of this program");
  std::error_code error;
  if (!fs::is_regular_file(file, error))
    throw InputError("detector", file, "FILE.py:CLASS or a program, a file that exists");
  const std::string stem = name_from(is_python ? text.substr(colon + 4) : fs::path(text).stem().string());
  ViewDetector added{stem, detectors.config(row->name), true};
  for (int i = 2; std::ranges::find(others, added.name, &ViewDetector::name) != others.end(); ++i)
    added.name = stem + "_" + std::to_string(i);
  TextSetter setter(row->selecting_key, fs::absolute(file).string() + text.substr(file.size()));
  describe(setter, added.config);
  return added;
}

}  // namespace saccade
