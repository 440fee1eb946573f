#include "config/calibration_file.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace saccade {
namespace {

using Kind = YamlNode::Kind;
using Values = std::vector<const YamlNode*>;

constexpr std::array<std::string_view, 3> matrix_keys = {"camera_matrix", "cameraMatrix", "Camera_Matrix"};
constexpr std::array<std::string_view, 4> coefficient_keys = {"distortion_coefficients", "distCoeffs",
                                                              "dist_coeffs", "Distortion_Coefficients"};
constexpr std::array<std::string_view, 2> width_keys = {"image_width", "image_Width"};
constexpr std::array<std::string_view, 2> height_keys = {"image_height", "image_Height"};

/// The first of these keys that a map has.
std::optional<std::string> first_of(const YamlNode& map, std::span<const std::string_view> keys) {
  for (const std::string_view key : keys) {
    if (map.entry(key) != nullptr) return std::string(key);
  }
  return std::nullopt;
}

/// None where the node is no number. YamlReader checks the values that are used.
std::optional<double> number_of(const YamlNode& node) {
  double value = 0.0;
  const char* const end = node.text.data() + node.text.size();
  const auto [stop, error] = std::from_chars(node.text.data(), end, value);
  if (node.kind != Kind::scalar || error != std::errc() || stop != end) return std::nullopt;
  return value;
}

std::string in_words(std::size_t numbers) {
  return std::to_string(numbers) + (numbers == 1 ? " number" : " numbers");
}

/// The scalars of a list, or of a list of lists, in their order.
void append_scalars(const YamlNode& node, Values& values) {
  for (const YamlNode& item : node.items) {
    if (item.kind == Kind::list) {
      append_scalars(item, values);
    } else {
      values.push_back(&item);
    }
  }
}

/// The text without what cv::FileStorage adds to YAML: the directive, and the tags of matrices.
std::string without_opencv_marks(std::string text) {
  if (text.starts_with("%YAML")) text.replace(0, text.find_first_of("\r\n"), "");
  constexpr std::string_view tag = "!!opencv-matrix";
  for (std::size_t at = text.find(tag); at != std::string::npos; at = text.find(tag, at))
    text.replace(at, tag.size(), tag.size(), ' ');
  return text;
}

/// Makes the section `calibration` out of another program's tree.
class Translator {
 public:
  explicit Translator(const YamlTree& from) : from_(from), block_(YamlNode::of(Kind::map, {1, 1})) {
    tree_.file = from.file;
    tree_.problems = from.problems;
  }

  /// OpenCV's and ROS's keys.
  void take_matrices() {
    const YamlNode& root = from_.root;
    set("width_px", need(root, width_keys, "", "the width of the image, px"));
    set("height_px", need(root, height_keys, "", "the height of the image, px"));
    take_matrix(root);
    if (const YamlNode* const xi = root.entry("xi"))
      fail(xi->mark, "xi", xi->found(), "no such key: a lens radial_tangential or fisheye, no mirror");
    const std::string key = first_of(root, coefficient_keys).value_or(std::string(coefficient_keys[0]));
    const YamlNode* const node = need(root, coefficient_keys, "", "the distortion coefficients");
    if (node == nullptr) return;
    const bool fisheye = is_fisheye(root);
    const auto coefficients = values_of(*node, key);
    if (!coefficients) return;
    if (fisheye) {
      set_fisheye(*coefficients, node->mark, key);
    } else {
      set_radial_tangential(*coefficients, node->mark, key);
    }
  }

  /// Kalibr's keys.
  void take_kalibr(const std::string& name) {
    const std::array<std::string_view, 1> block_key = {name};
    const YamlNode* const camera = need(from_.root, block_key, "", "a camera of Kalibr");
    if (camera == nullptr) return;
    block_.mark = camera->mark;
    const auto list = [&](std::string_view key, std::string_view of) -> std::optional<Values> {
      const std::array<std::string_view, 1> keys = {key};
      const YamlNode* const node = need(*camera, keys, name, "a list of " + std::string(of));
      return node == nullptr ? std::nullopt : values_of(*node, name + "." + std::string(key));
    };
    const auto word = [&](std::string_view key, const std::string& expectation) -> std::string {
      const std::array<std::string_view, 1> keys = {key};
      const YamlNode* const node = need(*camera, keys, name, expectation);
      if (node != nullptr && node->text.empty())
        fail(node->mark, name + "." + std::string(key), node->found(), expectation);
      return node == nullptr ? "" : node->text;
    };
    const std::string model = word("camera_model", "pinhole");
    if (!model.empty() && model != "pinhole") {
      fail(camera->entry("camera_model")->mark, name + ".camera_model", model,
           "pinhole: saccade has no other model of Kalibr's");
    }
    if (const auto resolution = list("resolution", "width and height, px"))
      set_all({"width_px", "height_px"}, *resolution, camera->entry("resolution")->mark,
              name + ".resolution");
    if (const auto intrinsics = list("intrinsics", "fu, fv, pu, pv, px")) {
      set_all({"fx_px", "fy_px", "cx_px", "cy_px"}, *intrinsics, camera->entry("intrinsics")->mark,
              name + ".intrinsics");
    }
    const std::string models = "radtan, equidistant or none";
    const std::string lens = word("distortion_model", models);
    if (lens == "none") return set_all_zero(camera->entry("distortion_model")->mark);
    const std::string path = name + ".distortion_coeffs";
    if (!lens.empty() && lens != "radtan" && lens != "equidistant")
      return fail(camera->entry("distortion_model")->mark, name + ".distortion_model", lens, models);
    const auto coefficients = list("distortion_coeffs", "4 coefficients");
    if (!coefficients || lens.empty()) return;
    const TextMark mark = camera->entry("distortion_coeffs")->mark;
    if (lens == "equidistant") {
      set_fisheye(*coefficients, mark, path);
    } else {
      set_all({"k1", "k2", "p1", "p2"}, *coefficients, mark, path);
    }
  }

  [[nodiscard]] YamlTree take() && {
    // Values that a problem stands for, so that a reader does not miss them.
    if (!tree_.problems.empty()) {
      const bool fisheye = block_.entry("lens") != nullptr;
      for (const char* key : {"width_px", "height_px", "fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2",
                              fisheye ? "k3" : "p1", fisheye ? "k4" : "p2"}) {
        const YamlNode rejected = YamlNode::of(Kind::rejected);
        if (block_.entry(key) == nullptr) set(key, &rejected);
      }
    }
    tree_.root.mark = block_.mark;
    tree_.root.keys = {"calibration"};
    tree_.root.items = {std::move(block_)};
    return std::move(tree_);
  }

 private:
  void fail(TextMark mark, std::string_view path, std::string found, std::string expectation) {
    tree_.problems.push_back({mark, {tree_.place(mark, path), std::move(found), std::move(expectation)}});
  }

  /// The value of the first of `keys` that `map` has; none is a problem.
  const YamlNode* need(const YamlNode& map, std::span<const std::string_view> keys, std::string_view path,
                       const std::string& expectation) {
    if (const auto key = first_of(map, keys)) return map.entry(*key);
    const std::string place = (path.empty() ? "" : std::string(path) + ".") + std::string(keys.front());
    fail({std::max(map.mark.line, 1), 1}, place, "no such key", expectation);
    return nullptr;
  }

  void set(std::string_view key, const YamlNode* value) {
    if (value == nullptr) return;
    block_.keys.emplace_back(key);
    block_.items.push_back(*value);
  }
  void set(std::string_view key, std::string text, TextMark mark) {
    YamlNode node = YamlNode::of(Kind::scalar, mark);
    node.text = std::move(text);
    set(key, &node);
  }
  /// The values as these keys; another number of values is a problem.
  void set_all(std::initializer_list<std::string_view> keys, const Values& values, TextMark mark,
               std::string_view path) {
    if (values.size() != keys.size())
      return fail(mark, path, in_words(values.size()), std::to_string(keys.size()));
    for (std::size_t i = 0; i < keys.size(); ++i) set(keys.begin()[i], values[i]);
  }
  void set_all_zero(TextMark mark) {
    for (const char* key : {"k1", "k2", "p1", "p2"}) set(key, "0", mark);
  }

  /// The numbers of a matrix of OpenCV or ROS (rows, cols, data), or of a list; none after a problem.
  std::optional<Values> values_of(const YamlNode& node, std::string_view path) {
    const YamlNode* const data = node.kind == Kind::map ? node.entry("data") : &node;
    if (data == nullptr || data->kind != Kind::list) {
      fail(node.mark, path, node.found(), "a list of numbers, or a matrix of them: rows, cols and data");
      return std::nullopt;
    }
    Values values;
    append_scalars(*data, values);
    const YamlNode* const rows = node.entry("rows");
    const YamlNode* const cols = node.entry("cols");
    if (rows == nullptr || cols == nullptr) return values;
    if (number_of(*rows).value_or(0.0) * number_of(*cols).value_or(0.0) !=
        static_cast<double>(values.size())) {
      fail(node.mark, path, in_words(values.size()),
           rows->found() + " x " + cols->found() + ", as rows and cols say");
      return std::nullopt;
    }
    return values;
  }

  void take_matrix(const YamlNode& root) {
    const YamlNode* const node = need(root, matrix_keys, "", "the matrix of the camera");
    if (node == nullptr) return;
    const std::string key = *first_of(root, matrix_keys);
    const auto numbers = values_of(*node, key);
    if (!numbers) return;
    const Values& values = *numbers;
    if (values.size() != 9) return fail(node->mark, key, in_words(values.size()), "3 x 3, row by row");
    set("fx_px", values[0]);
    set("fy_px", values[4]);
    set("cx_px", values[2]);
    set("cy_px", values[5]);
    for (const std::size_t i : {1U, 3U, 6U, 7U}) {
      if (number_of(*values[i]) != 0.0)
        fail(values[i]->mark, key, values[i]->found(), i == 1 ? "a skew of 0" : "[fx 0 cx; 0 fy cy; 0 0 1]");
    }
    if (number_of(*values[8]) != 1.0)
      fail(values[8]->mark, key, values[8]->found(), "[fx 0 cx; 0 fy cy; 0 0 1]");
  }

  /// By ROS's distortion_model or OpenCV's fisheye_model.
  bool is_fisheye(const YamlNode& root) {
    if (const YamlNode* const model = root.entry("distortion_model")) {
      if (model->text == "equidistant" || model->text == "fisheye") return true;
      if (model->text != "plumb_bob" && model->text != "rational_polynomial") {
        fail(model->mark, "distortion_model", model->found(),
             "plumb_bob, rational_polynomial, equidistant or fisheye");
      }
      return false;
    }
    const YamlNode* const flag = root.entry("fisheye_model");
    if (flag == nullptr || flag->text == "0" || flag->text == "false") return false;
    if (flag->text != "1" && flag->text != "true") fail(flag->mark, "fisheye_model", flag->found(), "0 or 1");
    return true;
  }

  void set_fisheye(const Values& coefficients, TextMark mark, std::string_view path) {
    set("lens", "fisheye", mark);
    set_all({"k1", "k2", "k3", "k4"}, coefficients, mark, path);
  }

  /// k1, k2, p1, p2, k3 of 4, 5, 8, 12 or 14 coefficients in OpenCV's order.
  void set_radial_tangential(const Values& coefficients, TextMark mark, std::string_view path) {
    constexpr std::array<std::string_view, 14> names = {"k1", "k2", "p1", "p2", "k3", "k4", "k5",
                                                        "k6", "s1", "s2", "s3", "s4", "tx", "ty"};
    const std::size_t count = coefficients.size();
    if (count != 4 && count != 5 && count != 8 && count != 12 && count != 14)
      return fail(mark, path, in_words(count), "4, 5, 8, 12 or 14 coefficients: k1, k2, p1, p2, k3 ...");
    for (std::size_t i = 0; i < count; ++i) {
      if (i < 5) {
        set(names[i], coefficients[i]);
      } else if (number_of(*coefficients[i]) != 0.0) {
        fail(coefficients[i]->mark, path, std::string(names[i]) + " of " + coefficients[i]->found(),
             "0: a lens radial_tangential has k1, k2, p1, p2 and k3; calibrate with " +
                 std::string(names[i]) + " fixed at 0, or as a fisheye");
      }
    }
  }

  const YamlTree& from_;
  YamlTree tree_;
  YamlNode block_;
};

}  // namespace

YamlTree read_calibration_file(const std::filesystem::path& path, int camera) {
  YamlTree tree = parse_yaml(without_opencv_marks(read_yaml_text(path)), path.string());
  const YamlNode& root = tree.root;
  if (root.entry("calibration") != nullptr) return tree;
  Translator translator(tree);
  if (root.entry("cam0") != nullptr || root.entry("cam1") != nullptr) {
    translator.take_kalibr(camera == 1 && root.entry("cam1") != nullptr ? "cam1" : "cam0");
  } else if (first_of(root, matrix_keys)) {
    translator.take_matrices();
  } else {
    std::string found;
    constexpr std::size_t most = 5;
    for (std::size_t i = 0; i < std::min(most, root.keys.size()); ++i)
      found += (i == 0 ? "the keys " : ", ") + root.keys[i];
    throw InputError(
        tree.file, found.empty() ? "no keys" : found,
        "calibration (a file of saccade calibrate), camera_matrix (of OpenCV or ROS) or cam0 (of "
        "Kalibr)");
  }
  return std::move(translator).take();
}

}  // namespace saccade
