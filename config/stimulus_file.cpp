#include "config/stimulus_file.h"

#include "config/yaml_reader.h"
#include "config/yaml_writer.h"
#include "recording/run_files.h"

namespace saccade {

StimulusFile read_stimulus_file(const std::filesystem::path& path) {
  const YamlTree tree = read_yaml_file(path);
  YamlReader reader(tree, {"stimuli"}, path.parent_path().string());
  StimulusFile file;
  describe(reader, file);
  reader.finish();
  for (auto& [name, stimulus] : file.stimuli) {
    if (stimulus.kind != StimulusKind::disc) continue;
    for (const TruthRow& row : read_table<TruthRow>(stimulus.circles_file))
      stimulus.circles.push_back({row.t_us, row.circle});
    if (stimulus.circles.size() < 2) {
      throw InputError(stimulus.circles_file, std::to_string(stimulus.circles.size()) + " circles",
                       "at least 2");
    }
  }
  return file;
}

std::string emulator_yaml(EmulatorConfig config) {
  YamlWriter writer;
  writer.section(
      "emulator", [&](FieldVisitor& v) { describe(v, config); }, "the event camera's pixels");
  return writer.yaml();
}

}  // namespace saccade
