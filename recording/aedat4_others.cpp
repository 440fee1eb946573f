#include "recording/aedat4_others.h"

#include "core/units.h"
#include "recording/aedat4_generated.h"

namespace saccade {
namespace {

constexpr std::size_t size_bytes = sizeof(flatbuffers::uoffset_t);

/// The root of a packet after its offsets have been checked; null where one leads outside.
template <class Table>
const Table* checked(std::string_view table, const char* identifier) {
  flatbuffers::Verifier::Options options;
  options.check_alignment = false;
  flatbuffers::Verifier verifier(reinterpret_cast<const std::uint8_t*>(table.data()), table.size(), options);
  if (!verifier.VerifyBuffer<Table>(identifier)) return nullptr;
  return flatbuffers::GetRoot<Table>(table.data());
}

std::optional<BrokenMessage> read_frame(const aedat4::Frame& stored, std::string_view source,
                                        OtherRecords& others) {
  RecordedFrame frame;
  frame.t_us = stored.timestamp();
  if (stored.end_of_exposure() != 0) {
    frame.begin_us = stored.begin_of_exposure();
    frame.end_us = stored.end_of_exposure();
  }
  frame.width = stored.size_x();
  frame.height = stored.size_y();
  frame.x = stored.position_x();
  frame.y = stored.position_y();
  const int format = static_cast<std::uint8_t>(stored.format());
  const int depth = format & 7;
  frame.channels = (format >> 3) + 1;
  frame.bits = depth == 2 ? 16 : 8;
  frame.source = source;
  if ((depth != 0 && depth != 2) || (frame.channels != 1 && frame.channels != 3 && frame.channels != 4))
    return BrokenMessage{"a frame of the format " + std::to_string(format),
                         "1, 3 or 4 channels of 8 or 16 bits"};
  const std::size_t there = stored.pixels() == nullptr ? 0 : stored.pixels()->size();
  if (frame.width <= 0 || frame.height <= 0)
    return BrokenMessage{"a frame of " + std::to_string(frame.width) + "x" + std::to_string(frame.height),
                         "one with pixels"};
  const std::size_t expected = static_cast<std::size_t>(frame.width) *
                               static_cast<std::size_t>(frame.height) *
                               static_cast<std::size_t>(frame.channels * frame.bits / 8);
  if (there != expected)
    return BrokenMessage{"a frame of " + std::to_string(there) + " bytes", std::to_string(expected)};
  frame.pixels = std::as_bytes(std::span(stored.pixels()->data(), there));
  others.add(frame);
  return std::nullopt;
}

void read_readings(const aedat4::ImuPacket& packet, std::string_view source, OtherRecords& others) {
  if (packet.elements() == nullptr) return;
  for (const aedat4::Imu* stored : *packet.elements()) {
    InertialReading reading;
    reading.t_us = stored->timestamp();
    reading.acceleration_m_s2 = {standard_gravity_m_s2 * stored->acceleration_x(),
                                 standard_gravity_m_s2 * stored->acceleration_y(),
                                 standard_gravity_m_s2 * stored->acceleration_z()};
    reading.angular_velocity_rad_s = {rad_per_deg * stored->rotation_x(), rad_per_deg * stored->rotation_y(),
                                      rad_per_deg * stored->rotation_z()};
    reading.temperature_deg_c = stored->temperature();
    reading.source = source;
    others.add(reading);
  }
}

void read_triggers(const aedat4::TriggerPacket& packet, std::string_view source, OtherRecords& others) {
  using enum TriggerKind;
  constexpr std::array<TriggerKind, 10> kinds = {
      reset,       rising,    falling,        pulse,       generator_rising, generator_falling,
      frame_begin, frame_end, exposure_begin, exposure_end};
  if (packet.elements() == nullptr) return;
  for (const aedat4::Trigger* stored : *packet.elements()) {
    const auto type = static_cast<std::size_t>(static_cast<std::uint8_t>(stored->type()));
    others.add(RecordedTrigger{stored->timestamp(), 0, type < kinds.size() ? kinds[type] : unknown, source});
  }
}

}  // namespace

bool wants_aedat4(const OtherRecords& others, std::string_view type) {
  return (type == "FRME" && others.wants_frames()) || (type == "IMUS" && others.wants_inertial()) ||
         (type == "TRIG" && others.wants_triggers());
}

std::optional<BrokenMessage> read_aedat4_others(std::string_view type, std::string_view packet,
                                                std::string_view source, OtherRecords& others) {
  const std::string_view table = packet.substr(std::min(size_bytes, packet.size()));
  const std::string identifier(type);
  if (type == "FRME") {
    if (const auto* frame = checked<aedat4::Frame>(table, identifier.c_str()))
      return read_frame(*frame, source, others);
  } else if (type == "IMUS") {
    if (const auto* readings = checked<aedat4::ImuPacket>(table, identifier.c_str())) {
      read_readings(*readings, source, others);
      return std::nullopt;
    }
  } else if (const auto* triggers = checked<aedat4::TriggerPacket>(table, identifier.c_str())) {
    read_triggers(*triggers, source, others);
    return std::nullopt;
  }
  return BrokenMessage{"an offset that leads outside the packet", "a whole packet " + identifier};
}

}  // namespace saccade
