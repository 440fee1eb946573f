#include <lz4frame.h>

#include <algorithm>
#include <array>

#include "core/error.h"
#include "recording/aedat4_codec.h"
#include "recording/aedat4_generated.h"
#include "recording/codec.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

constexpr std::size_t packet_events = 8192;
constexpr std::int64_t no_table = -1;  ///< its place in a file without one
constexpr int largest_written_length_px = 32767;

/// A packet as the table at the end has it.
struct PacketInfo {
  std::int64_t offset = 0;  ///< of its bytes, after its header
  aedat4::PacketHeader header;
  std::int64_t events = 0;
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
};

/// Two cameras are two streams from different sources.
std::string stream_description(ImageSize size, int cameras) {
  const auto attribute = [](std::string_view key, std::string_view type, std::string_view value) {
    return "<attr key=\"" + std::string(key) + "\" type=\"" + std::string(type) + "\">" + std::string(value) +
           "</attr>\n";
  };
  std::string text = "<dv version=\"2.0\">\n<node name=\"outInfo\" path=\"/mainloop/Recorder/outInfo/\">\n";
  for (int camera = 0; camera < cameras; ++camera) {
    const std::string number = std::to_string(camera);
    const std::string source = cameras == 1 ? "saccade" : camera == 0 ? "saccade_left" : "saccade_right";
    text += "<node name=\"" + number + "\" path=\"/mainloop/Recorder/outInfo/" + number + "/\">\n" +
            attribute("compression", "string", "LZ4") + attribute("originalModuleName", "string", "saccade") +
            attribute("originalOutputName", "string", "events") +
            attribute("typeDescription", "string", "Array of events (polarity ON/OFF).") +
            attribute("typeIdentifier", "string", "EVTS") +
            "<node name=\"info\" path=\"/mainloop/Recorder/outInfo/" + number + "/info/\">\n" +
            attribute("sizeX", "int", std::to_string(size.width)) +
            attribute("sizeY", "int", std::to_string(size.height)) + attribute("source", "string", source) +
            attribute("tsOffset", "long", "0") + "</node>\n</node>\n";
  }
  return text + "</node>\n</dv>\n";
}

/// The table in front, with its size: compression, place of the table of packets, description of the streams.
std::string header_table(ImageSize size, int cameras, std::int64_t table_place) {
  flatbuffers::FlatBufferBuilder builder;
  const auto description = builder.CreateString(stream_description(size, cameras));
  builder.ForceDefaults(true);
  aedat4::IOHeaderBuilder header(builder);
  header.add_data_table_position(table_place);
  header.add_info_node(description);
  header.add_compression(aedat4::Compression::lz4);
  aedat4::FinishSizePrefixedIOHeaderBuffer(builder, header.Finish());
  return {reinterpret_cast<const char*>(builder.GetBufferPointer()), builder.GetSize()};
}

std::string compress(const flatbuffers::FlatBufferBuilder& builder) {
  std::string packed(LZ4F_compressFrameBound(builder.GetSize(), nullptr), '\0');
  const std::size_t size = LZ4F_compressFrame(packed.data(), packed.size(), builder.GetBufferPointer(),
                                              builder.GetSize(), nullptr);
  SACCADE_CHECK(LZ4F_isError(size) == 0);
  packed.resize(size);
  return packed;
}

class Aedat4Writer final : public EventWriter {
 public:
  Aedat4Writer(const std::filesystem::path& path, ImageSize image_size, int cameras)
      : file_(path), image_size_(image_size), cameras_(cameras) {
    put(aedat4_mark);
    put(header_table(image_size, cameras, no_table));
  }

  void write(std::span<const Event> events) override {
    for (const Event& event : events) {
      check_writable(event, image_size_, cameras_, file_.path());
      auto& pending = pending_[event.camera];
      pending.emplace_back(event.t_us, static_cast<std::int16_t>(event.x), static_cast<std::int16_t>(event.y),
                           event.on);
      if (pending.size() == packet_events) put_packet(event.camera);
    }
  }

  void sync() override {
    put_pending();
    file_.sync();
  }

  void commit() override {
    put_pending();
    const std::int64_t table_place = offset_;
    put_table();
    const std::string header = header_table(image_size_, cameras_, table_place);
    file_.overwrite(static_cast<std::int64_t>(aedat4_mark.size()), std::as_bytes(std::span(header)));
    file_.commit();
  }

 private:
  void put_pending() {
    for (std::size_t camera = 0; camera < pending_.size(); ++camera) {
      if (!pending_[camera].empty()) put_packet(camera);
    }
  }

  void put(std::string_view bytes) {
    file_.write(bytes);
    offset_ += static_cast<std::int64_t>(bytes.size());
  }

  void put_packet(std::size_t camera) {
    std::vector<aedat4::Event>& pending = pending_[camera];
    flatbuffers::FlatBufferBuilder builder(packet_events * sizeof(aedat4::Event) + 64);
    const auto elements = builder.CreateVectorOfStructs(pending);
    builder.FinishSizePrefixed(aedat4::CreateEventPacket(builder, elements), "EVTS");
    const std::string packed = compress(builder);
    const aedat4::PacketHeader header(static_cast<std::int32_t>(camera),
                                      static_cast<std::int32_t>(packed.size()));
    put({reinterpret_cast<const char*>(&header), sizeof header});
    const auto [first, last] = std::minmax_element(
        pending.begin(), pending.end(),
        [](const aedat4::Event& a, const aedat4::Event& b) { return a.timestamp() < b.timestamp(); });
    packets_.push_back(
        {offset_, header, static_cast<std::int64_t>(pending.size()), first->timestamp(), last->timestamp()});
    put(packed);
    pending.clear();
  }

  void put_table() {
    flatbuffers::FlatBufferBuilder builder;
    std::vector<flatbuffers::Offset<aedat4::FileDataDefinition>> rows;
    for (const PacketInfo& packet : packets_) {
      aedat4::FileDataDefinitionBuilder row(builder);
      row.add_timestamp_end(packet.last_us);
      row.add_timestamp_start(packet.first_us);
      row.add_num_elements(packet.events);
      row.add_byte_offset(packet.offset);
      row.add_packet_info(&packet.header);
      rows.push_back(row.Finish());
    }
    const auto table = builder.CreateVector(rows);
    builder.FinishSizePrefixed(aedat4::CreateFileDataTable(builder, table), "FTAB");
    put(compress(builder));
  }

  OutputFile file_;
  ImageSize image_size_;
  int cameras_;
  std::int64_t offset_ = 0;
  std::array<std::vector<aedat4::Event>, 2> pending_;  ///< of each camera
  std::vector<PacketInfo> packets_;
};

}  // namespace

std::unique_ptr<EventWriter> create_aedat4(const std::filesystem::path& path, ImageSize image_size,
                                           int cameras) {
  if (image_size.width > largest_written_length_px || image_size.height > largest_written_length_px) {
    throw InputError(path.string(), "an image of " + text_of(image_size), "at most 32767x32767 for AEDAT 4");
  }
  return std::make_unique<Aedat4Writer>(path, image_size, cameras);
}

}  // namespace saccade
