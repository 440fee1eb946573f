#include "config/head_section.h"

#include <algorithm>
#include <cmath>

#include "config/urdf_head.h"
#include "config/xml_file.h"
#include "config/yaml_reader.h"
#include "head/ikin_links.h"
#include "head/placed_joints.h"
#include "sim/mjcf_chain.h"

namespace saccade {
namespace {

/// What is wrong with a head whose keys are all in range.
void require_head(FieldVisitor& v, const HeadConfig& head) {
  constexpr std::string_view block = "head.";
  try {
    (void)head_model(head);
  } catch (const InputError& error) {
    for (const Problem& problem : error.problems()) {
      const bool in_block = problem.place.starts_with(block);
      v.require(false, in_block ? problem.place.substr(block.size()) : problem.place, problem.value,
                problem.expectation);
    }
  }
}

std::string text_of_links(const std::string& path) {
  constexpr std::size_t most = std::size_t{1} << 20;
  return text_of_file(path, most, "a readable list of links");
}

/// Returns whether there are such lists.
bool read_ikin(FieldVisitor& v, HeadConfig& head) {
  const auto left = v.file("ikin_left", "list of links of the left eye, or the only one, as iKin has it");
  const auto right = v.file("ikin_right", "list of links of the right eye");
  v.require(left || !right, "ikin_right", right.value_or(""), "ikin_left beside it");
  if (!left) return false;
  std::optional<IkinText> right_text;
  if (right) right_text = IkinText{*right, text_of_links(*right)};
  const std::string name = head.description.name;
  head.model = HeadKind::described;
  head.description = description_of_ikin({*left, text_of_links(*left)}, right_text ? &*right_text : nullptr);
  head.description.name = name;
  return true;
}

/// The elements that problems name, with their lines. A file that includes others has lines for its own elements alone.
std::vector<Problem> with_lines(std::vector<Problem> problems, const std::string& path) {
  for (Problem& problem : problems) {
    const std::string start = path + ": <";
    if (!problem.place.starts_with(start)) continue;
    const XmlFile file(path, "mujoco");
    const std::string element = problem.place.substr(start.size() - 1);
    const pugi::xml_node node = file.root().find_node([&](const pugi::xml_node& candidate) {
      const std::string place = file.place(candidate);
      return place.ends_with(": " + element) && std::string_view(candidate.parent().name()) != "default";
    });
    if (node) problem.place = file.place(node);
  }
  return problems;
}

PlacedChain chain_of(const ChainRequest& request, bool is_urdf) {
  if (is_urdf) return chain_of_urdf(request);
  try {
    PlacedChain chain = chain_of_mjcf(request);
    for (auto* part : {&chain.common, &chain.eye[0], &chain.eye[1]}) {
      for (PlacedJoint& joint : *part)
        joint.place = with_lines({{joint.place, "", ""}}, request.path).front().place;
    }
    return chain;
  } catch (const InputError& error) {
    throw InputError(with_lines(error.problems(), request.path));
  }
}

/// A model in URDF or MJCF from which the chain of a head is taken.
struct ModelSource {
  std::vector<PlacedJoint> joints;  ///< in the order of the description
  bool is_mjcf = false;
};

/// The cameras look forward, or the axes of camera or base are others than the keys say.
void require_forward(FieldVisitor& v, const PlacedChain& chain) {
  constexpr double most_deg = 60.0;
  for (std::size_t e = 0; e < static_cast<std::size_t>(chain.cameras); ++e) {
    const double angle_deg = degrees_from_forward(chain.root_from_camera[e]);
    v.require(
        angle_deg <= most_deg, e == 0 ? "camera" : "right_camera",
        "an optical axis " + text_of(std::round(angle_deg)) + " deg from forward with all joints at 0",
        "at most 60 deg; camera_axes: body for a link with x forward, or other words for forward and up");
  }
}

/// Reads the description from such a model. None where no key names one, or a key is wrong.
std::optional<ModelSource> read_model(FieldVisitor& v, HeadConfig& head) {
  auto* const keys = dynamic_cast<SourceKeys*>(&v);
  if (keys == nullptr) return std::nullopt;
  ModelSource source;
  const auto urdf = v.file("urdf", "model of a robot in URDF, of which chain and camera are the head");
  const auto joints = keys->names(
      "chain",
      "joints of that model, or of one in MJCF that mjcf names, which move, in the order from the base "
      "to the camera; all others stay at 0. Limits, speeds and roles that the model lacks are keys of "
      "joints; the default role is neck, or eye for joints of one of two cameras");
  const auto mjcf = !urdf && joints ? v.file("mjcf", "") : std::nullopt;
  ChainRequest request;
  request.camera =
      keys->word("camera", "", "link of the left camera, or the only one; in MJCF a camera or body")
          .value_or("");
  request.right_camera = keys->word("right_camera", "", "link of the right camera");
  request.base = keys->word("base", "", "link that is the root; without it the one above all others");
  const std::string forward =
      keys->word("forward", "x", "axis of the base that points forward").value_or("x");
  const std::string up = keys->word("up", "z", "axis of the base that points up").value_or("z");
  const std::string axes =
      keys->word("camera_axes", "optical",
                 "axes of a link that is a camera: optical (z forward, x right), or body (x forward, z up)")
          .value_or("optical");
  const bool any = urdf || joints || !request.camera.empty() || request.right_camera || request.base;
  if (!any) return std::nullopt;
  const auto root_from_base = root_from_axes(forward, up);
  v.require(urdf || mjcf, "chain", "no model", "urdf or mjcf beside it");
  v.require(joints.has_value(), "urdf", "no chain", "chain: the names of the joints that move");
  v.require(!request.camera.empty(), urdf ? "urdf" : "mjcf", "no camera", "camera: the name of a link");
  v.require(root_from_base.has_value(), "up", up,
            "one of x, -x, y, -y, z, -z, across forward (" + forward + ")");
  v.require(axes == "optical" || axes == "body", "camera_axes", axes, "one of optical, body");
  if ((!urdf && !mjcf) || !joints || request.camera.empty() || !root_from_base) return std::nullopt;
  source.is_mjcf = mjcf.has_value();
  request.path = urdf ? *urdf : *mjcf;
  request.joints = *joints;
  request.root_from_base = *root_from_base;
  request.optical = axes == "optical";
  const PlacedChain chain = chain_of(request, urdf.has_value());
  require_forward(v, chain);
  head.model = HeadKind::described;
  head.description = description_of(chain, std::filesystem::path(request.path).stem().string());
  for (const auto* part : {&chain.common, &chain.eye[0], &chain.eye[1]})
    source.joints.insert(source.joints.end(), part->begin(), part->end());
  return source;
}

/// What neither the model nor the keys beside it state. Returns whether all is there.
bool require_known(FieldVisitor& v, const ModelSource& source, const HeadDescription& head) {
  std::string places, keys;
  const auto need = [&keys](const std::string& joint, const char* key) {
    keys += (keys.empty() ? "" : ", ") + ("joints." + joint + "." + key);
  };
  for (const PlacedJoint& joint : source.joints) {
    const auto described =
        std::ranges::find_if(head.joints, [&](const auto& entry) { return entry.first == joint.name; });
    const bool no_limits = std::isnan(described->second.min_deg) || std::isnan(described->second.max_deg);
    const bool no_speed = std::isnan(described->second.max_speed_deg_s);
    if (!no_limits && !no_speed) continue;
    places += (places.empty() ? "" : "; ") + joint.place + " without " +
              (no_limits ? no_speed ? "limits and speed" : "limits" : "a speed");
    if (no_limits) need(joint.name, "min_deg");
    if (no_limits) need(joint.name, "max_deg");
    if (no_speed) need(joint.name, "max_speed_deg_s");
  }
  v.require(places.empty(), "chain", places, keys);
  return places.empty();
}

/// A chain without an eye would end in one that looks along its last link.
void require_eye(FieldVisitor& v) {
  v.require(v.has_section("left_eye", false), "left_eye", "no such key",
            "the eye: links of its own, or its pose; {} for one in the frame after the last of the links");
}

}  // namespace

HeadConfig read_head(const std::filesystem::path& path) {
  const YamlTree tree = read_yaml_file(path);
  HeadConfig head;
  head.model = HeadKind::described;
  head.description.name = path.stem().string();
  const bool has_source = tree.root.find("ikin_left") != nullptr || tree.root.find("chain") != nullptr;
  YamlReader reader(tree, has_source ? std::vector<std::string>{} : std::vector<std::string>{"joints"},
                    path.parent_path().string());
  const bool is_ikin = read_ikin(reader, head);
  const std::optional<ModelSource> source = read_model(reader, head);
  describe(reader, head.description);
  if (!is_ikin && !source) require_eye(reader);
  if (source && source->is_mjcf) head.description.mjcf.clear();
  if (!source || require_known(reader, *source, head.description)) require_head(reader, head);
  reader.finish();
  return head;
}

std::optional<HeadConfig> read_recorded_head(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return std::nullopt;
  const std::optional<YamlTree> tree = block_of(read_yaml_file(path), "head");
  if (!tree) return std::nullopt;
  HeadConfig head;
  YamlReader reader(*tree, {}, path.parent_path().string());
  reader.section(
      "head", [&](FieldVisitor& v) { describe_head(v, head); }, "");
  reader.finish();
  return head;
}

void describe_head(FieldVisitor& v, HeadConfig& head) {
  const bool is_ikin = read_ikin(v, head);
  const std::optional<ModelSource> source = read_model(v, head);
  const auto file = v.file("file", "description of a head of one's own");
  if (file) head = read_head(*file);
  describe(v, head);
  if (!v.fills_defaults()) return;
  if (!is_ikin && !source && !file && head.model == HeadKind::described) require_eye(v);
  if (source && source->is_mjcf) head.description.mjcf.clear();
  if (!source || file || require_known(v, *source, head.description)) require_head(v, head);
}

}  // namespace saccade
