#include "config/xml_file.h"

#include <algorithm>
#include <fstream>

namespace saccade {
namespace {

constexpr std::size_t largest_xml = std::size_t{16} << 20;
constexpr std::size_t block_bytes = std::size_t{64} << 10;

}  // namespace

std::string text_of_file(const std::string& path, std::size_t most, const std::string& expectation) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  while (file && text.size() <= most) {
    const std::size_t before = text.size();
    text.resize(before + std::min(block_bytes, most + 1 - before));
    file.read(text.data() + before, static_cast<std::streamsize>(text.size() - before));
    text.resize(before + static_cast<std::size_t>(file.gcount()));
  }
  if (!file.is_open() || file.bad() || (text.empty() && !file.eof())) throw InputError(path, "", expectation);
  if (text.size() > most)
    throw InputError(path, "more than " + std::to_string(most) + " bytes", expectation + " of fewer");
  return text;
}

XmlFile::XmlFile(std::string path, std::string_view root)
    : path_(std::move(path)), text_(text_of_file(path_, largest_xml, "a readable file of XML")) {
  const std::string expectation = "XML with the root <" + std::string(root) + ">";
  const pugi::xml_parse_result result =
      document_.load_buffer(text_.data(), text_.size(), pugi::parse_default, pugi::encoding_utf8);
  if (!result)
    throw InputError(path_ + ":" + std::to_string(line_at(static_cast<std::size_t>(result.offset))),
                     result.description(), expectation);
  if (std::string_view(this->root().name()) != root) {
    throw InputError(place(this->root()), "such a root", expectation);
  }
}

std::size_t XmlFile::line_at(std::size_t offset) const {
  const auto end = text_.begin() + static_cast<std::ptrdiff_t>(std::min(offset, text_.size()));
  return 1 + static_cast<std::size_t>(std::count(text_.begin(), end, '\n'));
}

std::size_t XmlFile::line_of(const pugi::xml_node& element) const {
  return line_at(static_cast<std::size_t>(std::max<std::ptrdiff_t>(element.offset_debug(), 0)));
}

std::string XmlFile::place(const pugi::xml_node& element) const {
  std::string text = path_ + ":" + std::to_string(line_of(element)) + ": <" + std::string(element.name());
  if (const pugi::xml_attribute name = element.attribute("name"))
    text += " name=\"" + std::string(name.value()) + "\"";
  return text + ">";
}

}  // namespace saccade
