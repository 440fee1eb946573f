#include "apps/cli/program.h"

#include <mujoco/mujoco.h>

#include <stdexcept>
#include <string>
#include <vector>

#include "apps/cli/commands.h"
#include "apps/deploy/robot_backends.h"
#include "core/detectors/built_in_detectors.h"
#include "core/error.h"
#include "external/external_robot.h"
#include "external/external_rows.h"
#include "session/version.h"
#include "sim/gl_context.h"

namespace saccade {
namespace {

/// Version, commit, MuJoCo, OpenGL as runs use it, and the values of render.backend and render.device on this machine, one a
/// line.
std::string version_text() {
  std::string text =
      "saccade " + std::string(version()) + " (" + std::string(commit()) + ")\nMuJoCo " + mj_versionString();
  const std::vector<GlWay> ways = GlContext::ways();
  try {
    text += "\nOpenGL " + GlContext::create("auto")->description();
  } catch (const std::runtime_error& error) {
    text += std::string("\nOpenGL none: ") + error.what();
  }
  for (const GlWay& way : ways)
    text += "\nrender.backend " + way.backend + ": " + (way.works ? "" : "none, ") + way.description;
  const std::vector<GlDevice> devices = GlContext::devices();
  for (std::size_t i = 0; i < devices.size(); ++i)
    text += "\nrender.device " + std::to_string(i) + ": " + devices[i].name;
  return text;
}

}  // namespace

Registry built_in_registry() {
  Registry registry = {built_in_detectors(), built_in_controllers(), built_in_gates(), built_in_formats(),
                       built_in_backends()};
  add_external_detectors(registry.detectors);
  add_external_controllers(registry.controllers);
  add_external_robots(registry.backends);
  return registry;
}

int program(int argc, const char* const* argv, const Registry& registry) {
  CommandLine line("saccade",
                   "Closed-loop testbench for event-driven ball detection and gaze fixation on the iCub.",
                   {{0, "fine"},
                    {1, "the run failed"},
                    {2, "bad input or usage"},
                    {3, "an `expect:` was not met or a figure has changed"}});
  line.add_version(version_text);
  line.add_environment("SACCADE_DATA",
                       "Folder with models/ and scenarios/, instead of share/saccade above the program.");
  line.add_environment("MUJOCO_GL", "egl or osmesa: how images are drawn with `render.backend: auto`.");
  line.add_environment("DISPLAY", "X display of the windows of `view`, `label` and `run --view`.");
  add_run_command(line, registry);
  add_detect_command(line, registry);
  add_score_command(line);
  add_report_command(line, registry);
  add_info_command(line, registry);
  add_convert_command(line, registry);
  add_repair_command(line, registry);
  add_emulate_command(line, registry);
  add_calibrate_command(line, registry);
  add_fit_sensor_command(line, registry);
  add_fit_latency_command(line, registry);
  add_serve_command(line, registry);
  add_deploy_command(line, registry);
  add_guard_command(line, registry);
  add_check_command(line, registry);
  add_test_command(line, registry);
  add_test_task_command(line, registry);
  add_compare_command(line);
  add_sweep_command(line, registry);
  add_benchmark_command(line, registry);
  add_dataset_command(line, registry);
  add_sweep_task_command(line, registry);
  add_view_command(line, registry);
  add_film_command(line, registry);
  add_label_command(line, registry);
  add_keys_command(line, registry);
  add_migrate_command(line);
  add_command_pages_command(line);
  return line.run(argc, argv);
}

}  // namespace saccade
