#include "apps/sweep/live_sweep.h"

#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/live/live_message.h"

namespace saccade {
namespace {

using Json = nlohmann::ordered_json;

constexpr auto period = std::chrono::seconds(2);
constexpr std::size_t most_rows = 50;

Json row_json(const SweepRow& row) {
  Json json = {row.run, row.status};
  for (const std::string& value : row.values) json.push_back(value);
  for (const auto& metric : row.metrics) json.push_back(metric ? Json(*metric) : Json(nullptr));
  return json;
}

}  // namespace

LiveSweep::LiveSweep(const LiveAddress& address)
    : server_({.address = address, .page = live_page()}),
      last_missing_(std::numeric_limits<std::size_t>::max()) {}

void LiveSweep::show(const SweepCoordinator& coordinator) {
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return;
  next_ = now + period;
  const SweepStore& store = coordinator.store();
  if (coordinator.missing() != last_missing_) {  // the whole table is read only where it has changed
    last_missing_ = coordinator.missing();
    const SweepTable table = store.table();
    std::map<std::int64_t, const SweepRow*> rows;
    for (const SweepRow& row : table.rows) {
      rows[row.run] = &row;
      if (row.status != "waiting" && known_.insert(row.run).second) newest_.push_back(row.run);
    }
    if (newest_.size() > most_rows) newest_.erase(newest_.begin(), newest_.end() - std::ptrdiff_t{most_rows});
    Json columns = {"run", "status"};
    for (const std::string& axis : table.axes) columns.push_back(axis);
    for (const std::string& metric : table.metrics) columns.push_back(metric);
    Json shown = Json::array();
    for (auto run = newest_.rbegin(); run != newest_.rend(); ++run) shown.push_back(row_json(*rows.at(*run)));
    results_ = Json{{"columns", std::move(columns)}, {"rows", std::move(shown)}}.dump();
  }
  Json head = Json::parse(results_);
  head["title"] = store.name();
  head["total"] = coordinator.distinct();
  head["failed"] = store.count("failed");
  head["done"] =
      coordinator.distinct() - coordinator.missing() - static_cast<std::size_t>(store.count("failed"));
  head["running"] = coordinator.running();
  std::string update = live_message(head);
  head["kind"] = "sweep";
  server_.set_greeting(live_message(std::move(head)));
  server_.publish(std::move(update));
}

}  // namespace saccade
