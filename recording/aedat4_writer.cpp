#include <flatbuffers/flatbuffers.h>
#include <lz4frame.h>

#include <algorithm>

#include "core/error.h"
#include "recording/aedat4_codec.h"
#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/output_file.h"

namespace saccade {
namespace {

constexpr std::string_view mark_line = "#!AER-DAT4.0\r\n";
constexpr std::size_t packet_events = 8192;
constexpr std::int32_t stream = 0;
constexpr int largest_length_px = 32767;

/// The structs of the tables, as FlatBuffers lays them out.
struct PackedEvent {
  std::int64_t t_us;
  std::int16_t x;
  std::int16_t y;
  std::uint8_t on;
  std::uint8_t unused[3];
};
static_assert(sizeof(PackedEvent) == 16 && alignof(PackedEvent) == 8);
struct PacketHead {
  std::int32_t stream;
  std::int32_t bytes;
};
static_assert(sizeof(PacketHead) == 8 && alignof(PacketHead) == 4);

/// Where the n-th field of a table is named.
constexpr flatbuffers::voffset_t field(int n) { return static_cast<flatbuffers::voffset_t>(4 + 2 * n); }

/// A packet as the table at the end has it.
struct PacketInfo {
  std::int64_t offset = 0;  ///< of its bytes, behind its head
  PacketHead head{};
  std::int64_t events = 0;
  std::int64_t first_us = 0;
  std::int64_t last_us = 0;
};

std::string stream_description(ImageSize size) {
  const auto attribute = [](std::string_view key, std::string_view type, std::string_view value) {
    return "<attr key=\"" + std::string(key) + "\" type=\"" + std::string(type) + "\">" + std::string(value) +
           "</attr>\n";
  };
  return "<dv version=\"2.0\">\n<node name=\"outInfo\" path=\"/mainloop/Recorder/outInfo/\">\n"
         "<node name=\"0\" path=\"/mainloop/Recorder/outInfo/0/\">\n" +
         attribute("compression", "string", "LZ4") + attribute("originalModuleName", "string", "saccade") +
         attribute("originalOutputName", "string", "events") +
         attribute("typeDescription", "string", "Array of events (polarity ON/OFF).") +
         attribute("typeIdentifier", "string", "EVTS") +
         "<node name=\"info\" path=\"/mainloop/Recorder/outInfo/0/info/\">\n" +
         attribute("sizeX", "int", std::to_string(size.width)) +
         attribute("sizeY", "int", std::to_string(size.height)) + attribute("source", "string", "saccade") +
         attribute("tsOffset", "long", "0") + "</node>\n</node>\n</node>\n</dv>\n";
}

/// The table in front, with its size: compression, place of the table of packets, description of the streams.
std::string header_table(ImageSize size, std::int64_t table_place) {
  constexpr std::int32_t lz4 = 1;
  flatbuffers::FlatBufferBuilder builder;
  const auto description = builder.CreateString(stream_description(size));
  builder.ForceDefaults(true);
  const auto start = builder.StartTable();
  builder.AddElement<std::int64_t>(field(1), table_place, -1);
  builder.AddOffset(field(2), description);
  builder.AddElement<std::int32_t>(field(0), lz4, 0);
  builder.FinishSizePrefixed(flatbuffers::Offset<void>(builder.EndTable(start)), "IOHE");
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
  Aedat4Writer(const std::filesystem::path& path, ImageSize image_size)
      : file_(path), image_size_(image_size) {
    put(mark_line);
    put(header_table(image_size, 0));
  }

  void write(std::span<const Event> events) override {
    for (const Event& event : events) {
      check_writable(event, image_size_, 1, file_.path());
      pending_.push_back({event.t_us,
                          static_cast<std::int16_t>(event.x),
                          static_cast<std::int16_t>(event.y),
                          static_cast<std::uint8_t>(event.on ? 1 : 0),
                          {}});
      if (pending_.size() == packet_events) put_packet();
    }
  }

  void commit() override {
    if (!pending_.empty()) put_packet();
    const std::int64_t table_place = offset_;
    put_table();
    const std::string header = header_table(image_size_, table_place);
    file_.overwrite(static_cast<std::int64_t>(mark_line.size()), std::as_bytes(std::span(header)));
    file_.commit();
  }

 private:
  void put(std::string_view bytes) {
    file_.write(bytes);
    offset_ += static_cast<std::int64_t>(bytes.size());
  }

  void put_packet() {
    flatbuffers::FlatBufferBuilder builder(packet_events * sizeof(PackedEvent) + 64);
    const auto elements = builder.CreateVectorOfStructs(pending_);
    const auto start = builder.StartTable();
    builder.AddOffset(field(0), elements);
    builder.FinishSizePrefixed(flatbuffers::Offset<void>(builder.EndTable(start)), "EVTS");
    const std::string packed = compress(builder);
    const PacketHead head{stream, static_cast<std::int32_t>(packed.size())};
    std::string head_bytes;
    append_little(head_bytes, head.stream);
    append_little(head_bytes, head.bytes);
    put(head_bytes);
    const auto [first, last] =
        std::minmax_element(pending_.begin(), pending_.end(),
                            [](const PackedEvent& a, const PackedEvent& b) { return a.t_us < b.t_us; });
    packets_.push_back({offset_, head, static_cast<std::int64_t>(pending_.size()), first->t_us, last->t_us});
    put(packed);
    pending_.clear();
  }

  void put_table() {
    flatbuffers::FlatBufferBuilder builder;
    std::vector<flatbuffers::Offset<void>> rows;
    for (const PacketInfo& packet : packets_) {
      const auto start = builder.StartTable();
      builder.AddElement<std::int64_t>(field(4), packet.last_us, 0);
      builder.AddElement<std::int64_t>(field(3), packet.first_us, 0);
      builder.AddElement<std::int64_t>(field(2), packet.events, 0);
      builder.AddElement<std::int64_t>(field(0), packet.offset, 0);
      builder.AddStruct(field(1), &packet.head);
      rows.emplace_back(builder.EndTable(start));
    }
    const auto table = builder.CreateVector(rows);
    const auto start = builder.StartTable();
    builder.AddOffset(field(0), table);
    builder.FinishSizePrefixed(flatbuffers::Offset<void>(builder.EndTable(start)), "FTAB");
    put(compress(builder));
  }

  OutputFile file_;
  ImageSize image_size_;
  std::int64_t offset_ = 0;
  std::vector<PackedEvent> pending_;
  std::vector<PacketInfo> packets_;
};

}  // namespace

std::unique_ptr<EventWriter> create_aedat4(const std::filesystem::path& path, ImageSize image_size,
                                           int /*cameras*/) {
  if (image_size.width > largest_length_px || image_size.height > largest_length_px) {
    throw InputError(path.string(), "an image of " + text_of(image_size), "at most 32767x32767 for AEDAT 4");
  }
  return std::make_unique<Aedat4Writer>(path, image_size);
}

}  // namespace saccade
