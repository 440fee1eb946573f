#pragma once

#include "recording/format_registry.h"

namespace saccade {

/// ROS 2 bags in SQLite (github.com/ros2/rosbag2, storage sqlite3; the default before ROS 2 Iron): a table `topics` with id, name,
/// type and serialization_format, and a table `messages` with topic_id, timestamp (ns) and data, read in the order of their
/// rows. Messages of events: recording/event_message.h, in CDR; they may be compressed one by one with ZSTD. A file that was
/// cut off is an InputError as a whole, for SQLite fills what is missing with zeros. Nothing is written beside the file; where
/// a recorder has left a write-ahead log beside it, SQLite reads that too.
[[nodiscard]] RecordingFormat ros2_bag_format();

}  // namespace saccade
