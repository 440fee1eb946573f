#include <SQLiteCpp/SQLiteCpp.h>
#include <sqlite3.h>

#include <algorithm>
#include <limits>

#include "recording/event_message.h"
#include "recording/message_writer.h"
#include "recording/ros2_bag_codec.h"

namespace saccade {
namespace {

constexpr const char* packet_type = "event_camera_msgs/msg/EventPacket";

/// Tables of schema version 4. rosbag2 fills in `metadata` of a file when it reads one without a row there.
constexpr const char* tables = R"(
CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT NOT NULL,
  offered_qos_profiles TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL,
  encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL);
CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL);
CREATE INDEX timestamp_idx ON messages (timestamp ASC);
INSERT INTO schema VALUES(4, '');
)";

/// In YAML's single quotes.
std::string in_quotes(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) quoted.append(c == '\'' ? 2 : 1, c);
  return quoted + "'";
}

class Ros2BagWriter final : public MessageWriter {
 public:
  Ros2BagWriter(const std::filesystem::path& path, ImageSize image_size, int cameras)
      : MessageWriter(path, image_size, cameras, largest_ros2_stamp_us) {
    for (const std::filesystem::path& file : ros2_bag_companions(path)) metadata_.emplace(file);
    guarded([&] {
      database_.emplace(std::filesystem::absolute(file_.part()).string(), SQLite::OPEN_READWRITE);
      // The file has its name only when it is whole, and OutputFile puts it on the disk.
      database_->exec(
          "PRAGMA journal_mode = MEMORY; PRAGMA synchronous = OFF; PRAGMA locking_mode = EXCLUSIVE");
      database_->exec("BEGIN");
      database_->exec(tables);
      SQLite::Statement definition(*database_,
                                   "INSERT INTO message_definitions VALUES(1, ?, 'ros2msg', ?, '')");
      definition.bind(1, packet_type);
      definition.bind(2, event_packet_definition(Serialisation::cdr));
      definition.exec();
      for (int camera = 0; camera < cameras; ++camera) {
        SQLite::Statement row(*database_, "INSERT INTO topics VALUES(?, ?, ?, 'cdr', '', '')");
        row.bind(1, camera + 1);
        row.bind(2, topic("event_camera", camera));
        row.bind(3, packet_type);
        row.exec();
      }
      insert_.emplace(*database_, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)");
    });
  }

 protected:
  void put_message(int camera, std::span<const Event> events, std::uint32_t seq,
                   std::uint64_t last_ns) override {
    message_.clear();
    append_event_packet(message_, events, image_size(), seq, Serialisation::cdr);
    const auto time_ns = static_cast<std::int64_t>(last_ns);
    guarded([&] {
      insert_->bind(1, camera + 1);
      insert_->bind(2, time_ns);
      insert_->bindNoCopy(3, message_.data(), static_cast<int>(message_.size()));
      insert_->exec();
      insert_->reset();
    });
    ++messages_[static_cast<std::size_t>(camera)];
    first_ns_ = std::min(first_ns_, time_ns);
    last_ns_ = std::max(last_ns_, time_ns);
  }
  void put_chunk() override {
    guarded([&] { database_->exec("COMMIT; BEGIN"); });
  }
  void finish() override {
    guarded([&] { database_->exec("COMMIT"); });
    insert_.reset();
    database_.reset();
    if (!metadata_) return;
    metadata_->write(metadata());
    metadata_->commit();
  }

 private:
  /// Runs `work`; SQLite's exceptions become DiskFull and RunError.
  template <class Work>
  void guarded(const Work& work) const {
    try {
      work();
    } catch (const SQLite::Exception& error) {
      const std::string message = file_.path().string() + ": cannot be written: " + error.what();
      // SQLITE_IOERR is also what a limit on the size of files gives.
      if (error.getErrorCode() == SQLITE_FULL || error.getErrorCode() == SQLITE_IOERR)
        throw DiskFull(message);
      throw RunError(message);
    }
  }

  /// metadata.yaml of the folder, of version 5.
  [[nodiscard]] std::string metadata() const {
    const std::int64_t count = messages_[0] + messages_[1];
    const std::int64_t begin_ns = count == 0 ? 0 : first_ns_;
    const auto times = [&](std::string_view margin) {
      const std::string start = "\n" + std::string(margin);
      return start + "duration:" + start + "  nanoseconds: " + std::to_string(last_ns_ - begin_ns) + start +
             "starting_time:" + start + "  nanoseconds_since_epoch: " + std::to_string(begin_ns) + start +
             "message_count: " + std::to_string(count);
    };
    std::string text = "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3" +
                       times("  ") + "\n  topics_with_message_count:\n";
    for (int camera = 0; camera < cameras(); ++camera) {
      text +=
          "    - topic_metadata:\n        name: " + topic("event_camera", camera) +
          "\n        type: " + packet_type +
          "\n        serialization_format: cdr\n        offered_qos_profiles: \"\"\n      message_count: " +
          std::to_string(messages_[static_cast<std::size_t>(camera)]) + "\n";
    }
    const std::string name = in_quotes(file_.path().filename().string());
    return text + "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - " +
           name + "\n  files:\n    - path: " + name + times("      ") + "\n";
  }

  std::optional<OutputFile> metadata_;
  std::optional<SQLite::Database> database_;
  std::optional<SQLite::Statement> insert_;
  std::string message_;
  std::array<std::int64_t, 2> messages_{};  ///< by camera
  std::int64_t first_ns_ = std::numeric_limits<std::int64_t>::max();
  std::int64_t last_ns_ = 0;
};

}  // namespace

std::vector<std::filesystem::path> ros2_bag_companions(const std::filesystem::path& path) {
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  if (path.stem() != folder.filename().string() + "_0") return {};
  return {path.parent_path() / ros2_metadata_name};
}

std::unique_ptr<EventWriter> create_ros2_bag(const std::filesystem::path& path, ImageSize image_size,
                                             int cameras) {
  check_packet_size(path, image_size);
  return std::make_unique<Ros2BagWriter>(path, image_size, cameras);
}

}  // namespace saccade
