#include "evaluation/replay/foxglove_writer.h"

#include <nlohmann/json.hpp>

#include "core/error.h"

namespace saccade {

using Json = nlohmann::ordered_json;

std::size_t FoxgloveWriter::add(const std::string& topic, const std::string& schema) {
  return add_channel(topic, schema, foxglove_schema(schema));
}

std::size_t FoxgloveWriter::add_plain(const std::string& topic, const std::string& schema,
                                      const std::vector<PlainMember>& members) {
  return add_channel(topic, schema, plain_schema(schema, members));
}

std::size_t FoxgloveWriter::add_channel(const std::string& topic, const std::string& schema,
                                        const std::string& text) {
  const auto [place, is_new] = schemas_.try_emplace(schema, std::uint16_t{0});
  if (is_new) place->second = file_.add_schema(schema, "jsonschema", text);
  next_.push_back(0);
  return file_.add_channel(place->second, topic, "json");
}

void FoxgloveWriter::write(std::size_t topic, std::int64_t t_us, const Json& message) {
  constexpr std::int64_t largest_us = 4'000'000'000'000'000;  // s of 32 bits
  if (t_us < 0 || t_us > largest_us) {
    throw InputError("the run", "a time of " + std::to_string(t_us) + " us",
                     "times from 0 to " + std::to_string(largest_us) + " us for MCAP");
  }
  const auto ns = static_cast<std::uint64_t>(t_us) * 1000;
  file_.write({.channel = static_cast<std::uint16_t>(topic),
               .sequence = next_.at(topic)++,
               .log_ns = ns,
               .publish_ns = ns},
              message.dump(-1, ' ', false, Json::error_handler_t::replace));
  ++messages_;
}

Json foxglove_time(std::int64_t t_us) {
  return {{"sec", t_us / 1'000'000}, {"nsec", t_us % 1'000'000 * 1'000}};
}

Json foxglove_vector(const Eigen::Vector3d& v) { return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}}; }

Json foxglove_quaternion(const Eigen::Quaterniond& q) {
  return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}};
}

Json foxglove_pose(const Eigen::Isometry3d& pose) {
  return {{"position", foxglove_vector(pose.translation())},
          {"orientation", foxglove_quaternion(Eigen::Quaterniond(pose.linear()))}};
}

Json foxglove_colour(Colour colour, double alpha) {
  constexpr double most = 255.0;
  return {{"r", colour.red / most}, {"g", colour.green / most}, {"b", colour.blue / most}, {"a", alpha}};
}

Json foxglove_entity(std::int64_t t_us, const std::string& frame, const std::string& id) {
  Json entity = {{"timestamp", foxglove_time(t_us)},
                 {"frame_id", frame},
                 {"id", id},
                 {"lifetime", foxglove_time(0)},
                 {"frame_locked", true}};
  for (const char* const list :
       {"metadata", "arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models"})
    entity[list] = Json::array();
  return entity;
}

}  // namespace saccade
