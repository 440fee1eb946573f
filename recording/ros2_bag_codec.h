#pragma once

#include <filesystem>
#include <memory>
#include <string_view>
#include <vector>

#include "recording/format_registry.h"

namespace saccade {

/// ROS 2 bags in SQLite (github.com/ros2/rosbag2, storage sqlite3; the default before ROS 2 Iron): a table `topics` with id, name,
/// type and serialization_format, and a table `messages` with topic_id, timestamp (ns) and data, read in the order of their
/// rows. Messages of events: recording/event_message.h, in CDR; they may be compressed one by one with ZSTD. A file that was
/// cut off is an InputError as a whole, for SQLite fills what is missing with zeros. Nothing is written beside the file; where
/// a recorder has left a write-ahead log beside it, SQLite reads that too.
///
/// The writer makes a file of schema version 4 (rosbag2_storage_sqlite3/src/rosbag2_storage_sqlite3/sqlite_storage.cpp) with
/// messages of event_camera_msgs/msg/EventPacket (mono) of up to 8192 events and 10 ms on `/event_camera/events`, of two
/// cameras on `/event_camera/left/events` and `/event_camera/right/events`, at the time of their last event. Offered QoS
/// profiles, hashes of types and ros_distro are empty. It throws InputError for times outside [0, 2^31) s. An unfinished file
/// is whole after sync() until the next message is written.
[[nodiscard]] RecordingFormat ros2_bag_format();

[[nodiscard]] std::unique_ptr<EventWriter> create_ros2_bag(const std::filesystem::path& path,
                                                           ImageSize image_size, int cameras);

inline constexpr std::string_view ros2_metadata_name = "metadata.yaml";

/// The files that the writer makes beside `path`: in a folder NAME beside NAME_0.db3, as rosbag2 names a bag's first file,
/// `metadata.yaml` (version 5 of rosbag2_storage/include/rosbag2_storage/yaml.hpp), so that the folder is a bag; else none.
[[nodiscard]] std::vector<std::filesystem::path> ros2_bag_companions(const std::filesystem::path& path);

}  // namespace saccade
