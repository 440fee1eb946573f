#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/config.h"

namespace saccade {

/// Writes a config struct through its `describe` as YAML that a YamlReader reads back to the same values:
/// every key, in the order described, numbers as text_of() writes them. The values must be valid (finite
/// numbers, UTF-8 text). With comments each key is followed by what it is and what it takes, which makes the
/// defaults, written so, the reference of the keys.
class YamlWriter final : public FieldVisitor {
 public:
  enum class Comments { none, all };

  explicit YamlWriter(Comments comments = Comments::none) : comments_(comments) {}

  void real(std::string_view key, double& value, Range range, std::string_view doc) override;
  void integer(std::string_view key, std::int64_t& value, Range range, std::string_view doc) override;
  void boolean(std::string_view key, bool& value, std::string_view doc) override;
  void text(std::string_view key, std::string& value, std::string_view doc) override;
  void choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
              std::string_view doc) override;
  void numbers(std::string_view key, std::span<double> values, Range range, std::string_view doc) override;
  void point_list(std::string_view key, std::vector<double>& values, std::size_t dimension, Range range,
                  std::string_view doc) override;
  void section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
               std::string_view doc) override;
  void require(bool, std::string_view, std::string_view, std::string_view) override {}

  [[nodiscard]] const std::string& yaml() const { return yaml_; }

 private:
  void line(std::string_view key, std::string_view value, std::string_view doc, std::string_view takes);

  Comments comments_;
  std::size_t depth_ = 0;
  std::string yaml_;
};

template <class Config>
[[nodiscard]] std::string write_config(Config config,
                                       YamlWriter::Comments comments = YamlWriter::Comments::none) {
  YamlWriter writer(comments);
  describe(writer, config);
  return writer.yaml();
}

}  // namespace saccade
