#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "core/config.h"

namespace saccade {

/// Widgets for every key of a config's `describe`: a slider, a box or a list of choices. A slider covers four times the
/// first value; Ctrl-click types a number beyond that. The tooltip explains the key. A value that is typed and lies outside the
/// key's range is not taken: what was expected stands below the widget until the next change.
class FieldEditor final : public FieldVisitor {
 public:
  /// Draws the widgets of `config`; true when one of them changed it. `name` identifies the config. `hidden` keys are
  /// left out.
  template <class Config>
  bool edit(const std::string& name, Config& config, const std::set<std::string>& hidden = {}) {
    begin(name, hidden);
    describe(*this, config);
    return end();
  }

  void real(std::string_view key, double& value, Range range, std::string_view doc) override;
  void integer(std::string_view key, std::int64_t& value, Range range, std::string_view doc) override;
  void boolean(std::string_view key, bool& value, std::string_view doc) override;
  void text(std::string_view, std::string&, std::string_view) override {}
  void choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
              std::string_view doc) override;
  void numbers(std::string_view key, std::span<double> values, Range range, std::string_view doc) override;
  void point_list(std::string_view, std::vector<double>&, std::size_t, Range, std::string_view) override {}
  void section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
               std::string_view doc) override;
  void require(bool, std::string_view, std::string_view, std::string_view) override {}

 private:
  void begin(const std::string& name, const std::set<std::string>& hidden);
  bool end();
  [[nodiscard]] bool is_hidden(std::string_view key) const { return hidden_.contains(std::string(key)); }
  /// Whether the last widget has a new value. A number that is being typed is one when the widget is left; `wanted` gets it.
  bool settled(std::string_view key, bool changed, std::vector<double>& wanted);
  /// Notes whether the widget's new value is taken, and draws below it why the last one was not.
  bool accept(std::string_view key, bool edited, bool valid, const std::string& found,
              const std::string& expected);
  /// Draws the key at the left and leaves space for the widget at the right.
  void label(std::string_view key, std::string_view doc);
  [[nodiscard]] Range sensible(std::string_view key, double value, Range range);

  std::string path_;
  std::set<std::string> hidden_;
  std::map<std::string, double> first_;  // first values, by path
  std::string typed_path_;               ///< the key that a number is typed for, and that number
  std::vector<double> typed_;
  std::string rejected_path_, problem_;  ///< the key whose last value was not taken, and why
  bool changed_ = false;
};

}  // namespace saccade
