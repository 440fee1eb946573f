#include "config/world_defaults.h"

#include "config/yaml_reader.h"
#include "worlds/random_world_parts.h"

namespace saccade {
namespace {

/// Sets the key radius_px of a config that has it.
template <class Config>
void set_radius(Config& config, const std::array<double, 2>& radius_px) {
  YamlTree tree;
  set_value(tree, "radius_px=[" + text_of(radius_px[0]) + ", " + text_of(radius_px[1]) + "]");
  YamlReader reader(tree);
  describe(reader, config);  // a key that it does not have is left aside: finish() is not called
}

}  // namespace

void draw_defaults(const YamlTree& tree, const std::string& folder, Scenario& scenario) {
  Scenario given = scenario;
  YamlReader reader(tree, {}, folder);
  describe(reader, given);
  if (!given.world) return;
  std::optional<Camera> camera;
  if (tree.root.find("camera") != nullptr) camera = given.sim.camera;
  const DrawnWorld drawn = random_world::draw_world(*given.world, static_cast<std::uint64_t>(given.seed),
                                                    camera, given.sim.world.head);

  scenario.run.duration_s = drawn.duration_s;
  scenario.sim = drawn.sim;
  if (!camera) scenario.drawn_camera = drawn.sim.camera;
  // Given objects replace the drawn ones; so does a given kind of motion.
  if (tree.root.find("objects") != nullptr) scenario.sim.world.objects.clear();
  if (tree.root.find("ball.trajectory.kind") != nullptr) scenario.sim.world.ball.trajectory = {};

  const std::array<double, 2> radius_px = radius_range_px(drawn.sim.camera.size);
  for (auto& [name, config] : scenario.detectors) set_radius(config, radius_px);
  if (tree.root.find(frame_detector_name) != nullptr) {
    set_radius(scenario.frame_30hz.emplace(), radius_px);
  }

  const YamlNode* const driver = tree.root.find("gaze.detector");
  if (driver != nullptr && driver->text != "none") return;
  scenario.gaze.detector = "none";
  ScriptConfig* const script = scenario.gaze.controller.get_if<ScriptConfig>();
  if (drawn.motion == HeadMotion::still || script == nullptr) return;
  scenario.gaze.controller.controller = "script";
  *script = drawn.script;
}

}  // namespace saccade
