#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "recording/message_cursor.h"
#include "recording/other_records.h"

namespace saccade {

/// ROS messages of other sensors than event cameras.
enum class SensorMessageType {
  image,             ///< sensor_msgs/Image
  compressed_image,  ///< sensor_msgs/CompressedImage: a PNG or JPEG file
  imu,               ///< sensor_msgs/Imu
};

/// The message of a ROS 1 or ROS 2 type's name, where `others` (may be null) wants it.
[[nodiscard]] std::optional<SensorMessageType> wanted_sensor_message(const OtherRecords* others,
                                                                     std::string_view name);

/// Passes on a message. Its time is the header's stamp. Returns what is broken in it, and an encoding of images other than
/// mono8, mono16, 8UC1, 16UC1, rgb8, bgr8, rgba8, bgra8 and Bayer patterns of 8 or 16 bits, which are kept as they are.
[[nodiscard]] std::optional<BrokenMessage> read_sensor_message(SensorMessageType type,
                                                               Serialisation serialisation,
                                                               std::string_view message,
                                                               std::string_view topic, OtherRecords& others);

}  // namespace saccade
