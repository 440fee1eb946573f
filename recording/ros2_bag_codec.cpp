#include "recording/ros2_bag_codec.h"

#include <SQLiteCpp/SQLiteCpp.h>

#include <filesystem>
#include <limits>

#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/message_reader.h"

namespace saccade {
namespace {

constexpr std::string_view sqlite_mark{"SQLite format 3\0", 16};
constexpr std::size_t sqlite_header_bytes = 100;
constexpr std::string_view zstd_mark = "\x28\xb5\x2f\xfd";

/// As a URI that SQLite opens without a file beside it, unless there is a log that belongs to it.
std::string uri_of(const std::filesystem::path& path) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(path).string()) {
    const bool is_special = c == '%' || c == '?' || c == '#';
    constexpr std::string_view digits = "0123456789ABCDEF";
    if (is_special) {
      uri += {'%', digits[static_cast<unsigned char>(c) >> 4], digits[static_cast<unsigned char>(c) & 0xf]};
    } else {
      uri += c;
    }
  }
  std::error_code error;
  const auto log_bytes = std::filesystem::file_size(path.string() + "-wal", error);
  return uri + (error || log_bytes == 0 ? "?immutable=1" : "?mode=ro");
}

class Ros2BagReader final : public MessageReader {
 public:
  Ros2BagReader(InputFile file, const EventReadOptions& options)
      : MessageReader(std::move(file), "ROS 2 bag", options) {
    check_length();
    guarded([&] {
      database_ =
          std::make_unique<SQLite::Database>(uri_of(file_.name()), SQLite::OPEN_READONLY | SQLite::OPEN_URI);
      database_->exec("PRAGMA trusted_schema=OFF");
      for (const char* table : {"topics", "messages"}) {
        SQLite::Statement kind(*database_, "SELECT type FROM sqlite_master WHERE name = ?");
        kind.bind(1, table);
        if (!kind.executeStep() || kind.getColumn(0).getString() != "table")
          throw InputError(file_.name(), "a SQLite file without the table " + std::string(table),
                           "a ROS 2 bag, with the tables topics and messages");
      }
      SQLite::Statement topics(*database_, "SELECT id, name, type, serialization_format FROM topics");
      while (topics.executeStep()) {
        std::string type = topics.getColumn(2).getString();
        const std::string format = topics.getColumn(3).getString();
        if (format != "cdr") type.append(" in ").append(format);
        add_topic(id_of(topics.getColumn(0)), topics.getColumn(1).getString(), type, Serialisation::cdr);
      }
      messages_ =
          std::make_unique<SQLite::Statement>(*database_, "SELECT topic_id, timestamp, data FROM messages");
    });
    read_ahead();
  }

 protected:
  bool next() override {
    bool found = false;
    guarded([&] {
      while (!found && messages_->executeStep()) {
        const std::uint32_t id = id_of(messages_->getColumn(0));
        if (!wants(id)) continue;
        const SQLite::Column data = messages_->getColumn(2);
        const auto bytes = static_cast<std::size_t>(data.getBytes());
        if (bytes > most_message_bytes)
          file_.fail("a message of " + std::to_string(bytes) + " bytes", "at most 2^26");
        const std::string_view message(bytes == 0 ? "" : static_cast<const char*>(data.getBlob()), bytes);
        const auto host_ns = static_cast<std::uint64_t>(messages_->getColumn(1).getInt64());
        take(id, message.starts_with(zstd_mark) ? unpacked(message) : message, host_ns);
        found = true;
      }
    });
    return found;
  }

 private:
  /// Runs `work`; SQLite's exceptions become InputErrors.
  template <class Work>
  void guarded(const Work& work) const {
    try {
      work();
    } catch (const SQLite::Exception& error) {
      throw InputError(file_.name(), std::string("what SQLite cannot read (") + error.what() + ")",
                       "a whole ROS 2 bag");
    }
  }

  /// Throws for a file that is shorter than its header says, and goes to its end: SQLite reads it from here on.
  void check_length() {
    const std::string_view head = file_.peek(sqlite_header_bytes);
    if (head.size() < sqlite_header_bytes) file_.fail("the end of the file inside its header", "a ROS 2 bag");
    const std::uint64_t stored = load_big<std::uint16_t>(head.data() + 16);
    const std::uint64_t page = stored == 1 ? 65536 : stored;
    const bool counts =
        load_big<std::uint32_t>(head.data() + 24) == load_big<std::uint32_t>(head.data() + 92);
    const std::uint64_t pages = counts ? load_big<std::uint32_t>(head.data() + 28) : 0;
    std::error_code error;
    const std::uint64_t bytes = std::filesystem::file_size(file_.name(), error);
    if (error) throw InputError(file_.name(), error.message(), "a ROS 2 bag in a regular file");
    (void)file_.discard(bytes);
    if (page < 512 || bytes % page != 0 || bytes < pages * page)
      throw InputError(file_.name(), std::to_string(bytes) + " bytes",
                       std::to_string(pages) + " pages of " + std::to_string(page) +
                           " bytes as its header says; the file was cut off");
  }

  [[nodiscard]] std::uint32_t id_of(const SQLite::Column& column) const {
    const std::int64_t id = column.getInt64();
    if (id < 0 || id > std::numeric_limits<std::uint32_t>::max())
      file_.fail("the topic " + std::to_string(id), "a number from 0 to 2^32");
    return static_cast<std::uint32_t>(id);
  }

  /// A message that is compressed by itself.
  std::string_view unpacked(std::string_view message) {
    if (!zstd_) zstd_ = make_zstd_decompressor();
    zstd_->begin();
    unpacked_.clear();
    std::array<char, 1 << 16> piece;
    while (!message.empty() || zstd_->unfinished()) {
      const Decompressor::Step step = zstd_->run(message, piece);
      if (step.error != nullptr) file_.fail(step.error, "a message that can be unpacked");
      if (step.read == 0 && step.written == 0)
        file_.fail("compressed data without its end", "a whole message");
      message.remove_prefix(step.read);
      unpacked_.append(piece.data(), step.written);
      if (unpacked_.size() > most_message_bytes)
        file_.fail("a message of more than 2^26 bytes", "at most 2^26");
    }
    return unpacked_;
  }

  std::unique_ptr<SQLite::Database> database_;
  std::unique_ptr<SQLite::Statement> messages_;
  std::unique_ptr<Decompressor> zstd_;
  std::string unpacked_;
};

}  // namespace

RecordingFormat ros2_bag_format() {
  RecordingFormat format;
  format.name = "ROS 2 bag";
  format.extensions = {".db3"};
  format.folder_mark = ros2_metadata_name;
  format.sniff = [](const FileStart& start) { return start.begins_with(sqlite_mark); };
  format.open = [](InputFile file, const EventReadOptions& options) -> std::unique_ptr<EventReader> {
    return std::make_unique<Ros2BagReader>(std::move(file), options);
  };
  format.create = create_ros2_bag;
  format.companions = ros2_bag_companions;
  format.cameras = 2;
  format.reads =
      "SQLite, with ROS 2's (CDR) messages of the types read from bags; ZSTD by message; a folder with "
      "`metadata.yaml` and "
      "one `.db3` or `.mcap` file";
  format.writes =
      "SQLite, messages and topics as in MCAP; with `metadata.yaml` where named `NAME/NAME_0.db3`";
  format.time = "ns, to the nearest us; evt2 34, evt3 24 bits of us";
  format.axes = "top left, 1 is ON";
  format.limits = "y below 32768, times from 0 to 2^31 s";
  return format;
}

}  // namespace saccade
