#include "apps/cli/recorded_text.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace saccade {
namespace {

double seconds(std::int64_t us) { return 1e-6 * static_cast<double>(us); }

std::string name_of(const RecordedFile& file, const std::filesystem::path& folder) {
  return file.path.lexically_relative(folder).string();
}

std::string description(const RecordedFile& file) {
  std::string text = file.unfinished ? "not finished; " : "";
  if (!file.unreadable.empty()) return text + "cannot be read: " + file.unreadable;
  text += fmt::format("{} {}", file.rows, file.has_events ? "events" : "rows");
  if (file.first_us)
    text += fmt::format(" from {:.6f} to {:.6f} s", seconds(*file.first_us), seconds(*file.last_us));
  if (file.after_gap_us) {
    text += *file.after_gap_us < 0
                ? "; times begin anew"
                : fmt::format("; {:.6f} s after the last event before", seconds(*file.after_gap_us));
  }
  return file.torn ? text + "; " + text_of(*file.torn) : text;
}

}  // namespace

std::string text_of(const TornEnd& torn) {
  return fmt::format("{} bytes from byte {} on are {}: {}", torn.bytes, torn.byte,
                     torn.is_cut ? "lost" : "not read", torn.cause);
}

std::string text_of(const std::vector<RecordedFile>& files, const std::filesystem::path& folder) {
  std::size_t width = 0;
  for (const RecordedFile& file : files) width = std::max(width, name_of(file, folder).size());
  std::string text;
  for (const RecordedFile& file : files)
    text += fmt::format("{:<{}}  {}\n", name_of(file, folder), width, description(file));
  return text;
}

std::string json_of(const std::vector<RecordedFile>& files, const std::filesystem::path& folder) {
  using Json = nlohmann::ordered_json;
  Json list = Json::array();
  const auto number = [](const auto& value) { return value ? Json(*value) : Json(nullptr); };
  for (const RecordedFile& file : files) {
    Json json = {{"file", name_of(file, folder)},
                 {"content", file.has_events ? "events" : "table"},
                 {"whole", file.is_whole()},
                 {"finished", !file.unfinished},
                 {"rows", file.rows},
                 {"first_us", number(file.first_us)},
                 {"last_us", number(file.last_us)},
                 {"after_gap_us", number(file.after_gap_us)},
                 {"torn", nullptr}};
    if (file.torn)
      json["torn"] = {{"byte", file.torn->byte},
                      {"bytes", file.torn->bytes},
                      {"cut", file.torn->is_cut},
                      {"cause", file.torn->cause}};
    if (!file.unreadable.empty()) json["unreadable"] = file.unreadable;
    list.push_back(std::move(json));
  }
  return Json({{"folder", folder.string()}, {"files", list}})
             .dump(2, ' ', false, Json::error_handler_t::replace) +
         "\n";
}

}  // namespace saccade
