#pragma once

#include <CLI/CLI.hpp>
#include <functional>

namespace saccade {

/// What a parsed subcommand does; its value is the exit status (0, or 3 for an unmet `expect:`). Bad input is
/// thrown as InputError (status 2), a failed run as RunError (status 1).
using Action = std::function<int()>;

/// One per subcommand: adds it to `app`; when the user chose it, `action` is set.
void add_run_command(CLI::App& app, Action& action);
void add_detect_command(CLI::App& app, Action& action);
void add_report_command(CLI::App& app, Action& action);
void add_info_command(CLI::App& app, Action& action);
void add_convert_command(CLI::App& app, Action& action);
void add_emulate_command(CLI::App& app, Action& action);
void add_calibrate_command(CLI::App& app, Action& action);
void add_serve_command(CLI::App& app, Action& action);
void add_deploy_command(CLI::App& app, Action& action);
void add_sweep_command(CLI::App& app, Action& action);
void add_sweep_task_command(CLI::App& app, Action& action);
void add_view_command(CLI::App& app, Action& action);

}  // namespace saccade
