#include <mujoco/mujoco.h>

#include <cstdio>
#include <exception>
#include <string>

#include "apps/cli/commands.h"
#include "apps/session/version.h"
#include "core/error.h"
#include "sim/gl_context.h"

namespace {

/// Version, commit, MuJoCo and OpenGL, one a line.
std::string version_text() {
  std::string text = "saccade " + std::string(saccade::version()) + " (" + std::string(saccade::commit()) +
                     ")\nMuJoCo " + std::string(mj_versionString());
  try {
    text += "\nOpenGL " + saccade::GlContext::create("auto")->description();
  } catch (const saccade::RunError& error) {
    text += std::string("\nOpenGL none: ") + error.what();
  }
  return text;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Closed-loop testbench for event-driven ball detection and gaze fixation on the iCub.",
               "saccade"};
  app.require_subcommand(1);
  app.footer("Exit status: 0 fine, 1 the run failed, 2 bad input or usage, 3 an `expect:` was not met.");
  bool version = false;
  app.add_flag_callback(
      "--version",
      [&] {
        version = true;
        throw CLI::Success();
      },
      "Tell version, commit, MuJoCo and OpenGL");

  saccade::Action action;
  saccade::add_run_command(app, action);
  saccade::add_detect_command(app, action);
  saccade::add_report_command(app, action);
  saccade::add_info_command(app, action);
  saccade::add_convert_command(app, action);
  saccade::add_emulate_command(app, action);
  saccade::add_calibrate_command(app, action);
  saccade::add_serve_command(app, action);
  saccade::add_deploy_command(app, action);
  saccade::add_sweep_command(app, action);
  saccade::add_sweep_task_command(app, action);
  saccade::add_view_command(app, action);
  try {
    app.parse(argc, argv);
    return action();
  } catch (const CLI::ParseError& error) {
    if (version) {
      std::puts(version_text().c_str());
      return 0;
    }
    return app.exit(error) == 0 ? 0 : 2;
  } catch (const saccade::InputError& error) {
    std::fprintf(stderr, "saccade: %s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "saccade: %s\n", error.what());
    return 1;
  }
}
