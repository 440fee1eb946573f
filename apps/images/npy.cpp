#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <string_view>

#include "apps/images/image_kinds.h"
#include "core/error.h"
#include "recording/codec.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr std::string_view npy_magic = "\x93NUMPY";

/// The header of a .npy file: a Python dictionary of three entries
/// (numpy.org/doc/stable/reference/generated/numpy.lib.format.html).
class NpyHeader {
 public:
  std::string type;
  bool fortran_order = false;
  std::vector<std::int64_t> shape;

  /// False where the text is no such header.
  [[nodiscard]] bool parse(std::string_view text) {
    rest_ = text;
    bool has_type = false;
    bool has_order = false;
    bool has_shape = false;
    if (!take('{')) return false;
    while (!take('}')) {
      std::string key;
      if (!quoted(key) || !take(':')) return false;
      bool& seen = key == "descr" ? has_type : key == "fortran_order" ? has_order : has_shape;
      if (seen) return false;
      if (key == "descr") {
        seen = quoted(type);
      } else if (key == "fortran_order") {
        fortran_order = word("True");
        seen = fortran_order || word("False");
      } else {
        seen = key == "shape" && tuple();
      }
      if (!seen) return false;
      if (!take(',') && !rest_.starts_with('}')) return false;
    }
    return has_type && has_order && has_shape;
  }

 private:
  void skip_blanks() {
    while (!rest_.empty() && is_blank(rest_.front())) rest_.remove_prefix(1);
  }
  bool word(std::string_view text) {
    skip_blanks();
    if (!rest_.starts_with(text)) return false;
    rest_.remove_prefix(text.size());
    skip_blanks();
    return true;
  }
  bool take(char c) { return word({&c, 1}); }
  bool quoted(std::string& text) {
    skip_blanks();
    if (rest_.empty() || (rest_.front() != '\'' && rest_.front() != '"')) return false;
    const std::size_t end = rest_.find(rest_.front(), 1);
    if (end == std::string_view::npos) return false;
    text = rest_.substr(1, end - 1);
    rest_.remove_prefix(end + 1);
    return true;
  }
  bool tuple() {
    if (!take('(')) return false;
    while (!take(')')) {
      const std::size_t end = std::min(rest_.find_first_not_of("0123456789"), rest_.size());
      std::int64_t length = 0;
      if (!parse_number(rest_.substr(0, end), length)) return false;
      shape.push_back(length);
      rest_.remove_prefix(end);
      if (!take(',') && !rest_.starts_with(')')) return false;
    }
    return true;
  }

  std::string_view rest_;
};

class NpySequence final : public ImageSequence {
 public:
  explicit NpySequence(const std::filesystem::path& path)
      : name_(path.string()), stream_(path, std::ios::binary) {
    static_assert(std::endian::native == std::endian::little);
    const NpyHeader header = read_header();
    if (header.fortran_order) {
      throw InputError(name_, "an array in Fortran order", "one in C order (numpy.ascontiguousarray)");
    }
    const auto type = std::ranges::find(types, header.type, &Type::name);
    if (type == types.end()) {
      throw InputError(name_, "numbers of the type " + printable(header.type),
                       "float32 (<f4), float64 (<f8), uint8 (|u1) or uint16 (<u2)");
    }
    type_ = *type;
    if (header.shape.size() != 3) {
      throw InputError(name_, "an array of " + std::to_string(header.shape.size()) + " dimensions",
                       "three: images, height, width");
    }
    info_.count = header.shape[0];
    info_.size = {static_cast<int>(std::min<std::int64_t>(header.shape[2], longest_image_side + 1)),
                  static_cast<int>(std::min<std::int64_t>(header.shape[1], longest_image_side + 1))};
    info_.linear = true;
    if (!is_possible_image(info_.size)) {
      throw InputError(
          name_, "images of " + std::to_string(header.shape[2]) + " x " + std::to_string(header.shape[1]),
          possible_image_sizes());
    }
    const auto image_bytes = static_cast<std::uintmax_t>(info_.size.pixels()) * type_.bytes;
    const std::uintmax_t bytes =
        std::filesystem::file_size(path) - static_cast<std::uintmax_t>(stream_.tellg());
    if (bytes % image_bytes != 0 || bytes / image_bytes != static_cast<std::uintmax_t>(info_.count)) {
      throw InputError(name_, std::to_string(bytes) + " bytes of images",
                       std::to_string(info_.count) + " images of " + std::to_string(image_bytes) + " bytes");
    }
  }

  bool read(std::vector<float>& luminance) override {
    if (next_ == info_.count) return false;
    const auto pixels = static_cast<std::size_t>(info_.size.pixels());
    luminance.resize(pixels);
    bytes_.resize(pixels * type_.bytes);
    char* const into =
        type_.bytes == sizeof(float) ? reinterpret_cast<char*>(luminance.data()) : bytes_.data();
    if (!stream_.read(into, static_cast<std::streamsize>(bytes_.size()))) {
      throw InputError(name_of(next_), "a file that cannot be read", "an image");
    }
    if (type_.name == "<f8") convert<double>(luminance);
    if (type_.name == "|u1") convert<std::uint8_t>(luminance);
    if (type_.name == "<u2") convert<std::uint16_t>(luminance);
    ++next_;
    return true;
  }

  [[nodiscard]] std::string name_of(std::int64_t image) const override {
    return name_ + ", image " + std::to_string(image);
  }

 private:
  struct Type {
    std::string_view name;
    std::size_t bytes;
  };
  static constexpr std::array<Type, 4> types = {{{"<f4", 4}, {"<f8", 8}, {"|u1", 1}, {"<u2", 2}}};

  /// Leaves the stream at the first number.
  NpyHeader read_header() {
    std::array<char, 12> start{};
    const auto fail = [this](std::string found) {
      throw InputError(name_, std::move(found), "a NumPy array (.npy of version 1 or 2)");
    };
    if (!stream_.is_open()) fail("a file that cannot be read");
    stream_.read(start.data(), 8);
    if (!stream_ || std::string_view(start.data(), npy_magic.size()) != npy_magic)
      fail("another kind of file");
    const int version = start[6];
    if (version != 1 && version != 2) fail("version " + std::to_string(version));
    std::size_t length = 0;
    for (int i = 0; i < (version == 1 ? 2 : 4); ++i) {
      length |= static_cast<std::size_t>(static_cast<unsigned char>(stream_.get())) << (8 * i);
    }
    std::string text(std::min(length, std::size_t{1} << 20), '\0');
    stream_.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!stream_) fail("a file that is cut off in its header");
    NpyHeader header;
    if (!header.parse(text)) fail("the header " + printable(text));
    return header;
  }

  template <class Value>
  void convert(std::vector<float>& luminance) const {
    const char* at = bytes_.data();
    for (float& value : luminance) {
      Value number;
      std::memcpy(&number, at, sizeof number);
      value = static_cast<float>(number);
      at += sizeof number;
    }
  }

  std::string name_;
  std::ifstream stream_;
  Type type_{};
  std::vector<char> bytes_;
  std::int64_t next_ = 0;
};

}  // namespace

std::unique_ptr<ImageSequence> open_npy(const std::filesystem::path& path) {
  return std::make_unique<NpySequence>(path);
}

}  // namespace saccade
