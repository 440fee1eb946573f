#pragma once

#include <Eigen/Core>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace saccade {

/// Reads a request word by word.
class RequestWords {
 public:
  explicit RequestWords(const std::string& text) {
    std::string word;
    for (const char c : text + " ") {
      if (std::string_view(" \t\r\n()[]\",").find(c) == std::string_view::npos) {
        word += c;
      } else if (!word.empty()) {
        words_.push_back(std::move(word));
        word.clear();
      }
    }
  }
  std::string next() { return at_ < words_.size() ? words_[at_++] : std::string(); }
  /// Whether `word` is there after `after` others; takes it out.
  bool take(std::string_view word, std::size_t after) {
    if (at_ + after >= words_.size() || words_[at_ + after] != word) return false;
    words_.erase(words_.begin() + static_cast<std::ptrdiff_t>(at_ + after));
    return true;
  }
  [[nodiscard]] bool has_more() const { return at_ < words_.size(); }
  /// The remaining words as numbers; none unless they are exactly that many finite numbers.
  std::optional<Eigen::VectorXd> numbers(int count) {
    const auto values = next_numbers(count);
    return has_more() ? std::nullopt : values;
  }
  std::optional<Eigen::VectorXd> next_numbers(int count) {
    Eigen::VectorXd values(count);
    for (int i = 0; i < count; ++i) {
      const std::string word = next();
      const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), values[i]);
      if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(values[i])) return {};
    }
    return values;
  }

 private:
  std::vector<std::string> words_;
  std::size_t at_ = 0;
};

}  // namespace saccade
