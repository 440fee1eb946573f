#include "config/head_section.h"

#include <fstream>
#include <sstream>

#include "config/yaml_reader.h"
#include "head/ikin_links.h"

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

std::string text_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) throw InputError(path, "", "a readable list of links");
  return text.str();
}

/// Returns whether there are such lists.
bool read_ikin(FieldVisitor& v, HeadConfig& head) {
  const auto left = v.file("ikin_left", "list of links of the left eye, or the only one, as iKin has it");
  const auto right = v.file("ikin_right", "list of links of the right eye");
  v.require(left || !right, "ikin_right", right.value_or(""), "ikin_left beside it");
  if (!left) return false;
  std::optional<IkinText> right_text;
  if (right) right_text = IkinText{*right, text_of_file(*right)};
  const std::string name = head.description.name;
  head.model = HeadKind::described;
  head.description = description_of_ikin({*left, text_of_file(*left)}, right_text ? &*right_text : nullptr);
  head.description.name = name;
  return true;
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
  const bool has_ikin = tree.root.find("ikin_left") != nullptr;
  YamlReader reader(tree, has_ikin ? std::vector<std::string>{} : std::vector<std::string>{"joints"},
                    path.parent_path().string());
  const bool is_ikin = read_ikin(reader, head);
  describe(reader, head.description);
  if (!is_ikin) require_eye(reader);
  require_head(reader, head);
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
  const auto file = v.file("file", "description of a head of one's own");
  if (file) head = read_head(*file);
  describe(v, head);
  if (v.fills_defaults() && !is_ikin && !file && head.model == HeadKind::described) require_eye(v);
  if (v.fills_defaults()) require_head(v, head);
}

}  // namespace saccade
