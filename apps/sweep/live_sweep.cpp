#include "apps/sweep/live_sweep.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/live/live_message.h"
#include "evaluation/report/html.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr auto period = std::chrono::seconds(2);
constexpr std::size_t most_rows = 50;
constexpr std::size_t most_pictures = 6;
constexpr std::uintmax_t longest_picture = 200'000;  // bytes

Json row_json(const SweepRow& row) {
  Json json = {row.run, row.status};
  for (const std::string& value : row.values) json.push_back(value);
  for (const auto& metric : row.metrics) json.push_back(metric ? Json(*metric) : Json(nullptr));
  return json;
}

/// Of each of the runs in `worst` that were made last: the middle one of its images of the eye, with the run's ID.
Json newest_pictures(const fs::path& worst) {
  std::vector<std::pair<fs::file_time_type, fs::path>> found;
  std::error_code error;
  for (const auto& run : fs::directory_iterator(worst, error)) {
    std::vector<fs::path> images;
    for (const auto& file : fs::directory_iterator(run.path() / "frames", error)) {
      if (file.path().filename().string().ends_with("_eye.png")) images.push_back(file.path());
    }
    if (images.empty()) continue;
    std::ranges::sort(images);
    const fs::path& image = images[images.size() / 2];
    if (fs::file_size(image, error) <= longest_picture)
      found.emplace_back(fs::last_write_time(image, error), image);
  }
  std::ranges::sort(found, std::greater<>());
  if (found.size() > most_pictures) found.resize(most_pictures);
  Json pictures = Json::array();
  for (const auto& [time, image] : found) {
    std::ifstream file(image, std::ios::binary);
    const std::vector<unsigned char> bytes{std::istreambuf_iterator<char>(file), {}};
    pictures.push_back(
        {{"run", image.parent_path().parent_path().filename().string()}, {"png", base64(bytes)}});
  }
  return pictures;
}

}  // namespace

LiveSweep::LiveSweep(const LiveAddress& address, SweepFolder folder)
    : server_({.address = address, .page = live_page()}),
      folder_(std::move(folder)),
      last_missing_(std::numeric_limits<std::size_t>::max()) {}

void LiveSweep::show(const SweepCoordinator& coordinator, When when) {
  const auto now = std::chrono::steady_clock::now();
  const bool is_last = coordinator.missing() == 0 && last_missing_ != 0;
  if (when == When::in_time && now < next_ && !is_last) return;
  next_ = now + period;
  const SweepStore& store = coordinator.store();
  if (coordinator.missing() != last_missing_) {  // the whole table is read only where it has changed
    last_missing_ = coordinator.missing();
    const SweepTable table = store.table();
    runs_ = table.rows.size();
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
  head["total"] = runs_;
  head["done"] = store.count("done");
  head["failed"] = store.count("failed");
  head["running"] = coordinator.running();
  head["pictures"] = newest_pictures(folder_.path() / "worst");
  std::string update = live_message(head);
  head["kind"] = "sweep";
  server_.set_greeting(live_message(std::move(head)));
  server_.publish(std::move(update));
}

}  // namespace saccade
