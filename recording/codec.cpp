#include "recording/codec.h"

#include <algorithm>
#include <charconv>

#include "core/error.h"

namespace saccade {

void check_writable(const Event& event, ImageSize image_size, int cameras,
                    const std::filesystem::path& path) {
  if (!image_size.contains(event.x, event.y)) {
    throw InputError(path.string(), "an event at " + std::to_string(event.x) + ", " + std::to_string(event.y),
                     "pixels inside " + text_of(image_size) + "; --region 0,0," +
                         std::to_string(image_size.width) + "," + std::to_string(image_size.height) +
                         " of saccade convert removes others");
  }
  if (event.camera >= cameras) {
    throw InputError(path.string(), "an event of camera " + std::to_string(event.camera),
                     cameras == 1 ? "events of the left camera alone" : "events of camera 0 or 1");
  }
}

std::optional<ImageSize> parse_size(std::string_view text) {
  ImageSize size;
  const char* end = text.data() + text.size();
  const auto width = std::from_chars(text.data(), end, size.width);
  if (width.ec != std::errc() || width.ptr == end || *width.ptr != 'x') return std::nullopt;
  if (std::from_chars(width.ptr + 1, end, size.height).ec != std::errc()) return std::nullopt;
  return size;
}

std::string text_of(ImageSize size) { return std::to_string(size.width) + "x" + std::to_string(size.height); }

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

void append_count(std::string& text, std::int64_t count, std::string_view what) {
  if (count == 0) return;
  if (!text.empty()) text += ", ";
  text += std::to_string(count) + " " + std::string(what);
}

std::string printable(std::string_view bytes) {
  constexpr std::size_t longest = 60;
  std::string text(bytes.substr(0, longest));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < 0x20 || c > 0x7e; }, '.');
  return bytes.size() > longest ? text + "..." : text;
}

}  // namespace saccade
