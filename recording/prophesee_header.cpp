#include "recording/prophesee_header.h"

#include <algorithm>
#include <cctype>

#include "recording/codec.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr std::size_t longest_prophesee_line = 4096;
constexpr std::size_t longest_prophesee_header = 1 << 16;
constexpr int largest_prophesee_length_px = 1 << 14;

/// The number behind `name=` in `EVT3;height=720;width=1280`.
int field_of(std::string_view fields, std::string_view name) {
  const std::size_t place = fields.find(";" + std::string(name) + "=");
  int number = 0;
  if (place == std::string_view::npos) return number;
  const std::string_view rest = fields.substr(place + name.size() + 2);
  (void)parse_number(rest.substr(0, rest.find(';')), number);
  return number;
}

}  // namespace

PropheseeHeader::PropheseeHeader(InputFile& file) {
  while (file.peek(2).starts_with('%')) {
    // Events can begin with the byte of '%' too, but hardly with that of a blank after it.
    if (file.peek(2).size() == 2 && file.peek(2)[1] != ' ' && file.peek(2)[1] != '\n') return;
    const std::string_view ahead = file.peek(longest_prophesee_line).substr(0, longest_prophesee_line);
    const std::size_t length = ahead.find('\n');
    if (length == std::string_view::npos || file.offset() > longest_prophesee_header) {
      file.fail(ahead.size() < longest_prophesee_line ? "the end of the file" : "a header without an end",
                "header lines, % key value");
    }
    std::string_view line = ahead.substr(1, length - 1);
    while (!line.empty() && (line.front() == ' ')) line.remove_prefix(1);
    while (!line.empty() && (line.back() == ' ' || line.back() == '\r')) line.remove_suffix(1);
    const std::size_t blank = std::min(line.find(' '), line.size());
    std::string key(line.substr(0, blank));
    std::transform(key.begin(), key.end(), key.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    values_[key] = line.substr(std::min(blank + 1, line.size()));
    file.skip(length + 1);
    if (key == "end") return;
  }
}

std::string PropheseeHeader::value(const std::string& key) const {
  const auto found = values_.find(key);
  return found == values_.end() ? std::string() : found->second;
}

std::optional<ImageSize> PropheseeHeader::image_size() const {
  const auto sensible = [](ImageSize size) {
    return size.width > 0 && size.height > 0 && size.width <= largest_prophesee_length_px &&
           size.height <= largest_prophesee_length_px;
  };
  const std::optional<ImageSize> geometry = parse_size(value("geometry"));
  if (geometry && sensible(*geometry)) return geometry;
  const ImageSize format{field_of(value("format"), "width"), field_of(value("format"), "height")};
  if (sensible(format)) return format;
  ImageSize lines;
  const bool both = parse_number(value("width"), lines.width) && parse_number(value("height"), lines.height);
  return both && sensible(lines) ? std::optional(lines) : std::nullopt;
}

}  // namespace saccade
