#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "evaluation/replay/foxglove_schemas.h"
#include "evaluation/report/palette.h"
#include "recording/mcap_file.h"

namespace saccade {

/// Topics of JSON messages in an MCAP file. Every member throws RunError where writing fails.
class FoxgloveWriter {
 public:
  using Json = nlohmann::ordered_json;

  /// `file`: empty, and outlives this object.
  explicit FoxgloveWriter(OutputFile& file) : file_(file, "") {}

  /// Topics are added before the first message. `schema`: a name that foxglove_schema() takes.
  std::size_t add(const std::string& topic, const std::string& schema);
  std::size_t add_plain(const std::string& topic, const std::string& schema,
                        const std::vector<PlainMember>& members);
  /// Throws InputError for a time before 0.
  void write(std::size_t topic, std::int64_t t_us, const Json& message);
  void finish() { file_.finish(); }
  [[nodiscard]] std::int64_t messages() const { return messages_; }

 private:
  std::size_t add_channel(const std::string& topic, const std::string& schema, const std::string& text);

  McapFile file_;
  std::map<std::string, std::uint16_t> schemas_;  ///< by name
  std::vector<std::uint32_t> next_;               ///< sequence number of each topic's next message
  std::int64_t messages_ = 0;
};

/// Parts of messages, as Foxglove names them.
[[nodiscard]] nlohmann::ordered_json foxglove_time(std::int64_t t_us);
[[nodiscard]] nlohmann::ordered_json foxglove_vector(const Eigen::Vector3d& v);
[[nodiscard]] nlohmann::ordered_json foxglove_quaternion(const Eigen::Quaterniond& q);
[[nodiscard]] nlohmann::ordered_json foxglove_pose(const Eigen::Isometry3d& pose);
[[nodiscard]] nlohmann::ordered_json foxglove_colour(Colour colour, double alpha = 1.0);
/// A SceneEntity without primitives, which stays until another one of its name comes.
[[nodiscard]] nlohmann::ordered_json foxglove_entity(std::int64_t t_us, const std::string& frame,
                                                     const std::string& id);

}  // namespace saccade
