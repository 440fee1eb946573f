#include "apps/images/image_sequence.h"

#include <stdlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <string_view>

#include "core/config.h"
#include "core/srgb.h"
#include "recording/codec.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr int longest_side = 16384;
constexpr std::string_view npy_magic = "\x93NUMPY";

bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

[[nodiscard]] bool is_possible(ImageSize size) {
  return size.width >= 1 && size.height >= 1 && size.width <= longest_side && size.height <= longest_side;
}

std::string possible_sizes() { return "width and height in [1, " + std::to_string(longest_side) + "]"; }

/// Numbers in names by their value: f2 before f10.
bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t k = 0;
  while (i < a.size() && k < b.size()) {
    if (!is_digit(a[i]) || !is_digit(b[k])) {
      if (a[i] != b[k]) return a[i] < b[k];
      ++i;
      ++k;
      continue;
    }
    const auto number = [](const std::string& text, std::size_t& at) {
      const std::size_t end = std::min(text.find_first_not_of("0123456789", at), text.size());
      const std::size_t begin = std::min(text.find_first_not_of('0', at), end);
      at = end;
      return std::string_view(text).substr(begin, end - begin);
    };
    const std::string_view first = number(a, i);
    const std::string_view second = number(b, k);
    if (first.size() != second.size()) return first.size() < second.size();
    if (first != second) return first < second;
  }
  if ((i < a.size()) != (k < b.size())) return k < b.size();
  return a < b;
}

std::string kind_of(const cv::Mat& image) {
  const char* const depths[] = {
      "8 bit", "8 bit with a sign", "16 bit", "16 bit with a sign", "32 bit", "float", "float", "half float"};
  return depths[image.depth()];
}

bool is_float(const cv::Mat& image) { return image.depth() == CV_32F || image.depth() == CV_64F; }

/// Decoded images to luminance; see ImageSequence.
class Luminance {
 public:
  explicit Luminance(double white) : white_(white) {}

  /// Throws InputError for numbers or channels that no luminance can be made of.
  void convert(const cv::Mat& image, const std::string& name, std::vector<float>& luminance) {
    const int channels = image.channels();
    if (channels != 1 && channels != 3) {
      throw InputError(name, std::to_string(channels) + " channels", "one of grey or three of colour");
    }
    luminance.resize(image.total());
    switch (image.depth()) {
      case CV_8U:
        prepare(256);
        convert_rows<std::uint8_t>(image, luminance, [this](std::uint8_t v) { return linear_[v]; });
        return;
      case CV_16U:
        prepare(65536);
        convert_rows<std::uint16_t>(image, luminance, [this](std::uint16_t v) { return linear_[v]; });
        return;
      case CV_32F:
        convert_rows<float>(image, luminance, [](float v) { return v; });
        return;
      case CV_64F:
        convert_rows<double>(image, luminance, [](double v) { return v; });
        return;
      default:
        throw InputError(name, kind_of(image) + " numbers", "8 or 16 bit without a sign, or float");
    }
  }

 private:
  void prepare(std::size_t levels) {
    if (linear_.size() == levels) return;
    linear_.resize(levels);
    for (std::size_t i = 0; i < levels; ++i) {
      linear_[i] = white_ * linear_from_srgb(static_cast<double>(i) / static_cast<double>(levels - 1));
    }
  }

  template <class Value, class Linear>
  static void convert_rows(const cv::Mat& image, std::vector<float>& luminance, Linear linear) {
    float* out = luminance.data();
    for (int row = 0; row < image.rows; ++row) {
      const Value* in = image.ptr<Value>(row);
      if (image.channels() == 1) {
        for (int i = 0; i < image.cols; ++i) *out++ = static_cast<float>(linear(in[i]));
        continue;
      }
      for (int i = 0; i < image.cols; ++i, in += 3) {  // blue, green, red
        *out++ = static_cast<float>(0.0722 * linear(in[0]) + 0.7152 * linear(in[1]) + 0.2126 * linear(in[2]));
      }
    }
  }

  double white_;
  std::vector<double> linear_;  // by grey level
};

/// A sequence of images that OpenCV decodes, the first one ahead of time.
class DecodedSequence : public ImageSequence {
 public:
  bool read(std::vector<float>& luminance) final {
    if (ahead_.empty() && !decode(ahead_)) return false;
    const std::string name = name_of(next_);
    const ImageSize size{ahead_.cols, ahead_.rows};
    if (size != info_.size) {
      throw InputError(name, "an image of " + text_of(size), text_of(info_.size) + ", as the first one");
    }
    if (kind_of(ahead_) != kind_) throw InputError(name, kind_of(ahead_), kind_ + ", as the first one");
    luminance_.convert(ahead_, name, luminance);
    ahead_.release();
    ++next_;
    return true;
  }

 protected:
  explicit DecodedSequence(double white) : luminance_(white) {}

  /// To be called by the constructors: what the first image tells.
  void look_ahead() {
    if (!decode(ahead_)) return;
    info_.size = {ahead_.cols, ahead_.rows};
    info_.linear = is_float(ahead_);
    kind_ = kind_of(ahead_);
    if (!is_possible(info_.size)) {
      throw InputError(name_of(0), "an image of " + text_of(info_.size), possible_sizes());
    }
  }
  /// The next image; false after the last one.
  virtual bool decode(cv::Mat& image) = 0;
  [[nodiscard]] std::int64_t next() const { return next_; }

 private:
  Luminance luminance_;
  cv::Mat ahead_;
  std::string kind_;
  std::int64_t next_ = 0;
};

constexpr std::array<std::string_view, 9> image_extensions = {".bmp", ".exr", ".jpeg", ".jpg", ".pgm",
                                                              ".png", ".ppm", ".tif",  ".tiff"};

std::string extension_of(const fs::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

std::string bytes_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (!stream.is_open() || stream.bad()) {
    std::error_code error;
    throw InputError(path.string(), fs::exists(path, error) ? "a file that cannot be read" : "no such file",
                     "an image");
  }
  return bytes;
}

/// What OpenCV takes in silence: a JPEG that is cut off becomes grey where it ends, and the levels of a PGM or
/// PPM whose white is neither 255 nor 65535 stay as they are.
void check_bytes(std::string_view bytes, const std::string& name) {
  if (bytes.starts_with("\xff\xd8")) {
    const std::size_t scan = bytes.rfind("\xff\xda");
    if (scan == std::string_view::npos || bytes.find("\xff\xd9", scan) == std::string_view::npos) {
      throw InputError(name, "a JPEG that is cut off", "a whole one");
    }
  }
  if (bytes.size() > 2 && bytes[0] == 'P' &&
      std::string_view("2356").find(bytes[1]) != std::string_view::npos) {
    std::size_t at = 2;
    std::string_view white;
    for (int field = 0; field < 3; ++field) {
      while (at < bytes.size() && (is_blank(bytes[at]) || bytes[at] == '\n' || bytes[at] == '#')) {
        at = bytes[at] == '#' ? std::min(bytes.find('\n', at), bytes.size()) : at + 1;
      }
      const std::size_t end = std::min(bytes.find_first_not_of("0123456789", at), bytes.size());
      white = bytes.substr(at, end - at);
      at = end;
    }
    if (white != "255" && white != "65535") {
      throw InputError(name, "white at " + printable(white), "white at 255 or 65535");
    }
  }
}

class FolderSequence final : public DecodedSequence {
 public:
  FolderSequence(fs::path folder, double white, std::span<const ImageTime> named)
      : DecodedSequence(white), folder_(std::move(folder)) {
    // OpenCV keeps its reader of EXR behind this variable; it is asked for when the first such file is opened.
    setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1);
    if (named.empty()) {
      list_images();
    } else {
      for (const ImageTime& image : named) {
        if (!fs::is_regular_file(folder_ / image.name)) {
          throw InputError(image.place, printable(image.name), "the name of a file in " + folder_.string());
        }
        names_.push_back(image.name);
      }
    }
    info_.count = std::ssize(names_);
    look_ahead();
  }

  [[nodiscard]] std::string name_of(std::int64_t image) const override {
    return (folder_ / names_[static_cast<std::size_t>(image)]).string() + ", image " + std::to_string(image);
  }

 protected:
  bool decode(cv::Mat& image) override {
    if (decoded_ == names_.size()) return false;
    const std::string bytes = bytes_of(folder_ / names_[decoded_]);
    const std::string name = name_of(static_cast<std::int64_t>(decoded_));
    check_bytes(bytes, name);
    ++decoded_;
    try {
      const cv::Mat view(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
      if (!bytes.empty()) image = cv::imdecode(view, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR);
    } catch (const cv::Exception&) {
      image.release();
    }
    if (image.empty()) throw InputError(name, "a file that cannot be decoded", "a whole image");
    return true;
  }

 private:
  void list_images() {
    std::error_code error;
    for (fs::directory_iterator it(folder_, error), end; it != end; it.increment(error)) {
      if (error) break;
      const std::string name = it->path().filename().string();
      const bool known = std::ranges::find(image_extensions, extension_of(name)) != image_extensions.end();
      if (known && !name.starts_with('.') && it->is_regular_file()) {
        names_.push_back(name);
      } else {
        ++info_.passed_over;
      }
    }
    std::ranges::sort(names_, natural_less);
    if (error) throw InputError(folder_.string(), "a folder that cannot be read", "a folder of images");
    if (!names_.empty()) return;
    std::string kinds;
    for (const std::string_view extension : image_extensions) kinds += " " + std::string(extension);
    throw InputError(folder_.string(),
                     info_.passed_over == 0 ? "an empty folder"
                                            : "none among " + std::to_string(info_.passed_over) + " files",
                     "images:" + kinds);
  }

  fs::path folder_;
  std::vector<std::string> names_;
  std::size_t decoded_ = 0;
};

class VideoSequence final : public DecodedSequence {
 public:
  VideoSequence(const fs::path& path, double white) : DecodedSequence(white), name_(path.string()) {
    try {
      video_.open(name_, cv::CAP_FFMPEG);
      if (video_.isOpened()) look_ahead();
    } catch (const cv::Exception&) {
      video_.release();
    }
    if (!video_.isOpened() || !info_.size.contains(0, 0)) {
      throw InputError(name_, "a file that cannot be decoded",
                       "a video, a NumPy array (.npy) or a folder of images");
    }
    const double count = video_.get(cv::CAP_PROP_FRAME_COUNT);
    if (count >= 1.0 && count < 1e12) info_.count = std::llround(count);
    const double rate = video_.get(cv::CAP_PROP_FPS);
    if (rate > 0.0 && std::isfinite(rate)) info_.images_per_s = rate;
  }

  [[nodiscard]] std::string name_of(std::int64_t image) const override {
    return name_ + ", image " + std::to_string(image);
  }

 protected:
  bool decode(cv::Mat& image) override {
    try {
      return video_.read(image);
    } catch (const cv::Exception&) {
      throw InputError(name_of(next()), "an image that cannot be decoded", "a whole video");
    }
  }

 private:
  std::string name_;
  cv::VideoCapture video_;
};

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
  explicit NpySequence(const fs::path& path) : name_(path.string()), stream_(path, std::ios::binary) {
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
    info_.size = {static_cast<int>(std::min<std::int64_t>(header.shape[2], longest_side + 1)),
                  static_cast<int>(std::min<std::int64_t>(header.shape[1], longest_side + 1))};
    info_.linear = true;
    if (!is_possible(info_.size)) {
      throw InputError(
          name_, "images of " + std::to_string(header.shape[2]) + " x " + std::to_string(header.shape[1]),
          possible_sizes());
    }
    const auto image_bytes = static_cast<std::uintmax_t>(info_.size.pixels()) * type_.bytes;
    const std::uintmax_t bytes = fs::file_size(path) - static_cast<std::uintmax_t>(stream_.tellg());
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

/// Fields apart by blanks or a comma.
std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t i = 0; i < line.size();) {
    const auto apart = [&] { return is_blank(line[i]) || line[i] == ','; };
    const std::size_t begin = i;
    while (i < line.size() && !apart()) ++i;
    if (i > begin) fields.push_back(line.substr(begin, i - begin));
    while (i < line.size() && apart()) ++i;
  }
  return fields;
}

}  // namespace

std::vector<ImageTime> read_image_times(const fs::path& path) {
  std::ifstream stream(path);
  if (!stream || fs::is_directory(path)) {
    throw InputError(path.string(), fs::exists(path) ? "what cannot be read" : "no such file",
                     "a file of times, one a line");
  }
  std::vector<ImageTime> times;
  std::optional<bool> in_seconds;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const std::vector<std::string_view> fields = fields_of(line);
    if (fields.empty() || fields[0].starts_with('#')) continue;
    ImageTime time;
    time.place = path.string() + ":" + std::to_string(number);
    const auto fail = [&](std::string_view found, std::string expectation) {
      throw InputError(time.place, printable(found), std::move(expectation));
    };
    if (fields.size() > 2) fail(line, "a time, or a time and the name of a file");
    const bool seconds = fields[0].find('.') != std::string_view::npos;
    double value_s = 0.0;
    const bool parsed = seconds ? parse_number(fields[0], value_s) && std::abs(value_s) < 4e9
                                : parse_number(fields[0], time.t_us);
    if (!parsed) fail(fields[0], "a time in us, or in seconds with a decimal point");
    // A double holds 4e9 s to less than half a microsecond.
    if (seconds) time.t_us = std::llround(value_s * 1e6);
    if (seconds || time.t_us != 0) {
      if (in_seconds.value_or(seconds) != seconds) {
        fail(fields[0], *in_seconds ? "seconds with a decimal point, as before" : "us, as before");
      }
      in_seconds = seconds;
    }
    if (fields.size() == 2) time.name = fields[1];
    if (!times.empty() && time.t_us <= times.back().t_us) {
      fail(fields[0], "a time after " + std::to_string(times.back().t_us) + " us");
    }
    if (!times.empty() && time.name.empty() != times.back().name.empty()) {
      fail(line, time.name.empty() ? "a time and the name of a file, as before" : "a time alone, as before");
    }
    times.push_back(std::move(time));
  }
  if (times.empty()) throw InputError(path.string(), "no times", "a time per image, one a line");
  return times;
}

std::unique_ptr<ImageSequence> open_image_sequence(const fs::path& path, double white,
                                                   std::span<const ImageTime> named) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    throw InputError(path.string(), "no such file or folder",
                     "a folder of images, a NumPy array (.npy) or a video");
  }
  if (fs::is_directory(path, error)) return std::make_unique<FolderSequence>(path, white, named);
  if (!named.empty()) {
    throw InputError(named.front().place, "the name " + printable(named.front().name),
                     "times alone, for " + path.string() + " is no folder");
  }
  if (extension_of(path) == ".npy") return std::make_unique<NpySequence>(path);
  return std::make_unique<VideoSequence>(path, white);
}

}  // namespace saccade
