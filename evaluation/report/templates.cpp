#include "evaluation/report/templates.h"

#include <kainjow/mustache.hpp>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "evaluation/report/html.h"

namespace saccade {
namespace {

using kainjow::mustache::data;

data mustache_of(const nlohmann::ordered_json& json) {
  if (json.is_object()) {
    data object(data::type::object);
    for (const auto& [key, value] : json.items()) object.set(key, mustache_of(value));
    return object;
  }
  if (json.is_array()) {
    data list(data::type::list);
    for (const auto& value : json) list.push_back(mustache_of(value));
    return list;
  }
  if (json.is_boolean()) return data(json.get<bool>());
  if (json.is_null()) return data(false);
  return data(json.is_string() ? json.get<std::string>() : json.dump());
}

}  // namespace

std::string rendered(std::string_view name, const nlohmann::ordered_json& values) {
  kainjow::mustache::mustache page{std::string(report_asset(name))};
  SACCADE_CHECK(page.is_valid());
  page.set_custom_escape([](const std::string& text) { return escaped(text); });
  const std::string text = page.render(mustache_of(values));
  SACCADE_CHECK(page.error_message().empty());
  return text;
}

}  // namespace saccade
