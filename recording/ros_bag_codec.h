#pragma once

#include <filesystem>
#include <memory>

#include "recording/format_registry.h"

namespace saccade {

/// Bags of ROS 1, version 2.0 (wiki.ros.org/Bags/Format/2.0): the line `#ROSBAG V2.0`, then records. A record is u32 and that
/// many bytes of fields (u32 length, `name=value`), then u32 and that many bytes of data. Its field `op` is 3 for the file's
/// header with `index_pos`, `conn_count` and `chunk_count`, 5 for a chunk of connections (7) and messages (2), compressed
/// as `compression` says (none, lz4: a frame, bz2), 4 for the index of the chunk before, 6 for a chunk's entry in the index
/// at the end. Messages of events: recording/event_message.h.
///
/// A bag whose recorder was killed has index_pos 0 and is read to its end. One with an index that ends before it is an
/// InputError after the events.
///
/// The writer makes messages of up to 8192 events and 10 ms on the topic `/dvs/events`, of two cameras on `/dvs/left/events`
/// and `/dvs/right/events`, in chunks without compression, of
/// dvs_msgs/EventArray; of event_camera_msgs/EventPacket (mono) where the name ends with `.packets.bag`. It throws
/// InputError for times outside [0, 2^32) s.
[[nodiscard]] RecordingFormat ros_bag_format();

[[nodiscard]] std::unique_ptr<EventWriter> create_ros_bag(const std::filesystem::path& path,
                                                          ImageSize image_size, int cameras);

}  // namespace saccade
