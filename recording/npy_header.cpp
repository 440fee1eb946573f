#include "recording/npy_header.h"

#include <algorithm>

#include "recording/number_text.h"

namespace saccade {
namespace {

/// Reads the parts of a Python literal, one after the other.
class PythonText {
 public:
  explicit PythonText(std::string_view text) : rest_(text) {}

  [[nodiscard]] bool word(std::string_view text) {
    skip_blanks();
    if (!rest_.starts_with(text)) return false;
    rest_.remove_prefix(text.size());
    skip_blanks();
    return true;
  }
  [[nodiscard]] bool take(char c) { return word({&c, 1}); }
  [[nodiscard]] bool next_is(char c) const { return rest_.starts_with(c); }
  [[nodiscard]] bool quoted(std::string& text) {
    skip_blanks();
    if (!next_is('\'') && !next_is('"')) return false;
    const std::size_t end = rest_.find(rest_.front(), 1);
    if (end == std::string_view::npos) return false;
    text = rest_.substr(1, end - 1);
    rest_.remove_prefix(end + 1);
    return true;
  }
  /// (10,) or (3, 4) or ()
  [[nodiscard]] bool tuple(std::vector<std::int64_t>& numbers) {
    if (!take('(')) return false;
    while (!take(')')) {
      const std::size_t end = std::min(rest_.find_first_not_of("0123456789"), rest_.size());
      std::int64_t number = 0;
      if (!parse_number(rest_.substr(0, end), number)) return false;
      numbers.push_back(number);
      rest_.remove_prefix(end);
      if (!take(',') && !next_is(')')) return false;
    }
    return true;
  }
  /// 'on', or with a title ('p', 'on')
  [[nodiscard]] bool field_name(NpyHeader::Field& field) {
    if (!take('(')) return quoted(field.name);
    return quoted(field.title) && take(',') && quoted(field.name) && take(')');
  }
  /// [('x', '<u2'), ('y', '<u2')]
  [[nodiscard]] bool records(std::vector<NpyHeader::Field>& fields) {
    if (!take('[')) return false;
    while (!take(']')) {
      NpyHeader::Field field;
      if (!take('(') || !field_name(field) || !take(',') || !quoted(field.type)) return false;
      if (!take(')')) return false;
      fields.push_back(std::move(field));
      if (!take(',') && !next_is(']')) return false;
    }
    return !fields.empty();
  }

 private:
  void skip_blanks() {
    while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
  }

  std::string_view rest_;
};

}  // namespace

std::optional<NpyHeader> NpyHeader::parse(std::string_view text) {
  PythonText rest(text);
  NpyHeader header;
  bool has_type = false;
  bool has_order = false;
  bool has_shape = false;
  if (!rest.take('{')) return std::nullopt;
  while (!rest.take('}')) {
    std::string key;
    if (!rest.quoted(key) || !rest.take(':')) return std::nullopt;
    bool& seen = key == "descr" ? has_type : key == "fortran_order" ? has_order : has_shape;
    if (seen) return std::nullopt;
    if (key == "descr") {
      seen = rest.next_is('[') ? rest.records(header.fields) : rest.quoted(header.type);
    } else if (key == "fortran_order") {
      header.fortran_order = rest.word("True");
      seen = header.fortran_order || rest.word("False");
    } else {
      seen = key == "shape" && rest.tuple(header.shape);
    }
    if (!seen) return std::nullopt;
    if (!rest.take(',') && !rest.next_is('}')) return std::nullopt;
  }
  if (!has_type || !has_order || !has_shape) return std::nullopt;
  return header;
}

}  // namespace saccade
