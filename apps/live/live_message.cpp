#include "apps/live/live_message.h"

#include <nlohmann/json.hpp>

#include "evaluation/replay/replay_asset.h"

namespace saccade {

/// A file of apps/live/page/.
std::string_view live_asset(std::string_view name);

std::string live_message(nlohmann::ordered_json head, const std::vector<PackedTable>& tables) {
  head["tables"] = nlohmann::ordered_json::array();
  for (const PackedTable& table : tables) head["tables"].push_back(table.description());
  const std::string text = head.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string message;
  for (int shift = 0; shift < 32; shift += 8) message += static_cast<char>(text.size() >> shift & 0xff);
  message += text;
  for (const PackedTable& table : tables)
    message.append(reinterpret_cast<const char*>(table.bytes().data()), table.bytes().size());
  return message;
}

std::string live_page() {
  std::string script;
  for (const char* const name : {"page.js", "tables.js", "plot.js", "eye.js"}) script += replay_asset(name);
  script += live_asset("live.js");
  return filled_page(live_asset("live.html"), {{"style", replay_asset("replay.css")}, {"script", script}});
}

}  // namespace saccade
