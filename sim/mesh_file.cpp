#include "sim/mesh_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>

#include "core/config.h"
#include "core/error.h"

namespace saccade {
namespace {

using Eigen::Vector3d;
using Corner = TriangleMesh::Corner;

constexpr std::uintmax_t largest_bytes = 64'000'000;
constexpr double smallest_m = 0.001;
constexpr double largest_m = 5.0;

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view blanks = " \t\r";
  std::vector<std::string_view> words;
  for (std::size_t begin = line.find_first_not_of(blanks); begin < line.size();) {
    const std::size_t end = std::min(line.find_first_of(blanks, begin), line.size());
    words.push_back(line.substr(begin, end - begin));
    begin = line.find_first_not_of(blanks, end);
  }
  return words;
}

template <class Number>
bool parse(std::string_view text, Number& value) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc() && result.ptr == text.data() + text.size();
}

/// Reads text line by line, with the line's place for messages.
class MeshText {
 public:
  MeshText(const std::string& path, std::string_view text) : path_(path), rest_(text) {}

  /// The words of the next line; false at the end.
  bool next() {
    if (rest_.empty()) return false;
    const std::size_t end = std::min(rest_.find('\n'), rest_.size());
    words = words_of(rest_.substr(0, end));
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    ++line_;
    return true;
  }
  [[nodiscard]] std::string place() const { return path_ + ":" + std::to_string(line_); }
  [[noreturn]] void refuse(const std::string& found, const std::string& expectation) const {
    throw InputError(place(), found, expectation);
  }
  [[nodiscard]] double number(std::size_t word) const {
    double value = 0.0;
    if (word >= words.size())
      refuse(std::to_string(words.size() - 1) + " numbers", std::to_string(word) + " or more");
    if (!parse(words[word], value) || !std::isfinite(value))
      refuse("\"" + std::string(words[word]) + "\"", "a finite number");
    return value;
  }
  [[nodiscard]] Vector3d point(std::size_t word) const {
    return {number(word), number(word + 1), number(word + 2)};
  }

  std::vector<std::string_view> words;

 private:
  const std::string& path_;
  std::string_view rest_;
  int line_ = 0;
};

/// An index of an OBJ file, from 1, or negative from the end; as an index from 0.
int index_of(const MeshText& text, std::string_view word, std::size_t count, const char* what) {
  long index = 0;
  const bool is_number = parse(word, index) && index != 0;
  const long from_zero = index > 0 ? index - 1 : static_cast<long>(count) + index;
  if (!is_number || from_zero < 0 || from_zero >= static_cast<long>(count)) {
    text.refuse("\"" + std::string(word) + "\"",
                "the number of a " + std::string(what) + ", 1 to " + std::to_string(count));
  }
  return static_cast<int>(from_zero);
}

TriangleMesh read_obj(const std::string& path, std::string_view content) {
  TriangleMesh mesh;
  MeshText text(path, content);
  while (text.next()) {
    if (text.words.empty()) continue;
    const std::string_view kind = text.words.front();
    if (kind == "v") {
      mesh.points_m.push_back(text.point(1));
    } else if (kind == "vt") {
      mesh.texels.emplace_back(text.number(1), 1.0 - text.number(2));
    } else if (kind == "f") {
      std::vector<Corner> corners;
      for (std::size_t i = 1; i < text.words.size(); ++i) {
        const std::string_view word = text.words[i];
        const std::size_t slash = std::min(word.find('/'), word.size());
        Corner corner{index_of(text, word.substr(0, slash), mesh.points_m.size(), "point"), -1};
        const std::string_view after = word.substr(std::min(slash + 1, word.size()));
        const std::string_view texel = after.substr(0, std::min(after.find('/'), after.size()));
        if (!texel.empty()) corner.texel = index_of(text, texel, mesh.texels.size(), "texture coordinate");
        corners.push_back(corner);
      }
      if (corners.size() < 3)
        text.refuse(std::to_string(corners.size()) + " corners", "a face of three or more");
      for (std::size_t i = 2; i < corners.size(); ++i)
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    }
  }
  return mesh;
}

void add_triangle(TriangleMesh& mesh, const std::array<Vector3d, 3>& points_m) {
  std::array<Corner, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) {
    corners[k].point = static_cast<int>(mesh.points_m.size());
    mesh.points_m.push_back(points_m[k]);
  }
  mesh.triangles.push_back(corners);
}

TriangleMesh read_stl_text(const std::string& path, std::string_view content) {
  TriangleMesh mesh;
  MeshText text(path, content);
  std::array<Vector3d, 3> points_m;
  std::size_t count = 0;
  while (text.next()) {
    if (text.words.empty()) continue;
    if (text.words.front() == "vertex") {
      if (count == 3) text.refuse("a fourth vertex", "facets of three");
      points_m[count++] = text.point(1);
    } else if (text.words.front() == "endfacet") {
      if (count != 3) text.refuse("a facet of " + std::to_string(count) + " vertices", "facets of three");
      add_triangle(mesh, points_m);
      count = 0;
    }
  }
  return mesh;
}

/// 80 bytes, the number of triangles, then 50 bytes for each: normal, three points (little-endian floats), 2 bytes.
TriangleMesh read_stl_binary(const std::string& path, std::string_view content) {
  constexpr std::size_t header_bytes = 84;
  constexpr std::size_t triangle_bytes = 50;
  std::uint32_t count = 0;
  std::memcpy(&count, content.data() + header_bytes - sizeof count, sizeof count);
  TriangleMesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<float, 9> values{};
    std::memcpy(values.data(), content.data() + header_bytes + i * triangle_bytes + 12, sizeof values);
    if (!std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); })) {
      throw InputError(path + ": triangle " + std::to_string(i + 1), "a coordinate that is not finite",
                       "finite numbers");
    }
    std::array<Vector3d, 3> points_m;
    for (std::size_t k = 0; k < 3; ++k)
      points_m[k] = Eigen::Map<const Eigen::Vector3f>(values.data() + 3 * k).cast<double>();
    add_triangle(mesh, points_m);
  }
  return mesh;
}

TriangleMesh read_stl(const std::string& path, std::string_view content) {
  constexpr std::size_t header_bytes = 84;
  if (content.size() >= header_bytes) {
    std::uint32_t count = 0;
    std::memcpy(&count, content.data() + header_bytes - sizeof count, sizeof count);
    if (content.size() == header_bytes + 50 * static_cast<std::size_t>(count))
      return read_stl_binary(path, content);
  }
  if (content.starts_with("solid")) return read_stl_text(path, content);
  throw InputError(path, std::to_string(content.size()) + " bytes that are no STL",
                   "a whole binary or text STL file");
}

std::string lower_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return extension;
}

}  // namespace

TriangleMesh read_mesh_file(const std::string& path, double scale) {
  const std::string extension = lower_extension(path);
  if (extension != ".obj" && extension != ".stl")
    throw InputError(path, "the extension \"" + extension + "\"", ".obj or .stl");
  std::error_code error;
  const std::uintmax_t bytes = std::filesystem::file_size(path, error);
  if (error) throw InputError(path, "", "a readable mesh file");
  if (bytes > largest_bytes)
    throw InputError(path, std::to_string(bytes) + " bytes", "at most " + std::to_string(largest_bytes));
  std::ifstream file(path, std::ios::binary);
  std::ostringstream content;
  if (bytes == 0 || !(content << file.rdbuf())) throw InputError(path, "", "a mesh");
  const std::string text = content.str();
  TriangleMesh mesh = extension == ".obj" ? read_obj(path, text) : read_stl(path, text);
  Vector3d least_m = Vector3d::Constant(INFINITY);
  Vector3d most_m = -least_m;
  for (Vector3d& p : mesh.points_m) {
    p *= scale;
    least_m = least_m.cwiseMin(p);
    most_m = most_m.cwiseMax(p);
  }
  check_surface(mesh, path);
  const double extent_m = (most_m - least_m).maxCoeff();
  if (!(extent_m >= smallest_m && extent_m <= largest_m)) {
    throw InputError(path, "a mesh of " + text_of(extent_m) + " m",
                     expectation_of({smallest_m, largest_m}, "an extent in metres") +
                         "; `scale` changes it, 0.001 for millimetres");
  }
  return mesh;
}

}  // namespace saccade
