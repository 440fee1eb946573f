#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "apps/commands.h"
#include "evaluation/report.h"

namespace saccade {

void add_report_command(CLI::App& app, Action& action) {
  auto folders = std::make_shared<std::vector<std::filesystem::path>>();
  CLI::App* command = app.add_subcommand("report", "Write report.html anew from what run folders hold");
  command->add_option("run", *folders, "Run folders")->required();
  command->callback([folders, &action] {
    action = [folders] {
      for (const std::filesystem::path& folder : *folders) {
        write_report(folder);
        fmt::print("{}\n", (folder / "report.html").string());
      }
      return 0;
    };
  });
}

}  // namespace saccade
