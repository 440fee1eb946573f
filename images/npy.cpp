#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <string_view>

#include "core/error.h"
#include "images/image_kinds.h"
#include "recording/codec.h"
#include "recording/npy_header.h"

namespace saccade {
namespace {

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
      throw InputError(
          name_,
          header.fields.empty() ? "numbers of the type " + printable(header.type) : "an array of records",
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
    if (!stream_ || std::string_view(start.data(), npy_mark.size()) != npy_mark) fail("another kind of file");
    const int version = start[6];
    if (version != 1 && version != 2) fail("version " + std::to_string(version));
    std::size_t length = 0;
    for (int i = 0; i < (version == 1 ? 2 : 4); ++i) {
      length |= static_cast<std::size_t>(static_cast<unsigned char>(stream_.get())) << (8 * i);
    }
    std::string text(std::min(length, std::size_t{1} << 20), '\0');
    stream_.read(text.data(), static_cast<std::streamsize>(text.size()));
    if (!stream_) fail("a file that is cut off in its header");
    std::optional<NpyHeader> header = NpyHeader::parse(text);
    if (!header) fail("the header " + printable(text));
    return *header;
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
