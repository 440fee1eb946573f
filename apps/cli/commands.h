#pragma once

#include "apps/cli/command_line.h"
#include "config/registry.h"

namespace saccade {

/// One function per subcommand, which adds it to the command line. The registry must outlive the command line.
void add_benchmark_command(CommandLine& line, const Registry& registry);
void add_calibrate_command(CommandLine& line, const Registry& registry);
void add_check_command(CommandLine& line, const Registry& registry);
/// Hidden: writes the man pages and the completion of shells of what `line` has.
void add_command_pages_command(CommandLine& line);
void add_compare_command(CommandLine& line);
void add_convert_command(CommandLine& line, const Registry& registry);
void add_dataset_command(CommandLine& line, const Registry& registry);
void add_deploy_command(CommandLine& line, const Registry& registry);
void add_guard_command(CommandLine& line, const Registry& registry);
void add_detect_command(CommandLine& line, const Registry& registry);
void add_emulate_command(CommandLine& line, const Registry& registry);
void add_film_command(CommandLine& line, const Registry& registry);
void add_fit_latency_command(CommandLine& line, const Registry& registry);
void add_fit_sensor_command(CommandLine& line, const Registry& registry);
void add_info_command(CommandLine& line, const Registry& registry);
void add_keys_command(CommandLine& line, const Registry& registry);
void add_label_command(CommandLine& line, const Registry& registry);
void add_migrate_command(CommandLine& line);
void add_repair_command(CommandLine& line, const Registry& registry);
void add_report_command(CommandLine& line, const Registry& registry);
void add_run_command(CommandLine& line, const Registry& registry);
void add_score_command(CommandLine& line);
void add_serve_command(CommandLine& line, const Registry& registry);
void add_sweep_command(CommandLine& line, const Registry& registry);
void add_sweep_task_command(CommandLine& line, const Registry& registry);
void add_test_command(CommandLine& line, const Registry& registry);
void add_test_task_command(CommandLine& line, const Registry& registry);
void add_view_command(CommandLine& line, const Registry& registry);

}  // namespace saccade
