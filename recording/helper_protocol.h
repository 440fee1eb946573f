#pragma once

#include <cstddef>
#include <cstdint>

// What a helper process sends through its pipe (helper_server.h sends, helper_reader.h receives): messages of a
// HelperMessage and `bytes` bytes.
namespace saccade {

inline constexpr std::size_t helper_block_events = 1 << 14;

enum class HelperMessageKind : std::uint32_t {
  opened,     ///< HelperImageSize, then the format's name; of an array HelperArray and the lengths as u64
  events,     ///< up to helper_block_events of HelperEvent
  end,        ///< of the recording
  bad_input,  ///< place, value and expectation of an InputError, separated by NUL
  failure,    ///< text of any other exception
  rows,       ///< of an array: its bytes go on
};

struct HelperMessage {
  HelperMessageKind kind = HelperMessageKind::end;
  std::uint32_t bytes = 0;  ///< at most helper_most_bytes
};

/// An event in which every byte may have every value: a helper with corrupted memory may send anything.
struct HelperEvent {
  std::int64_t t_us;
  std::uint16_t x;
  std::uint16_t y;
  std::uint8_t on;
  std::uint8_t camera;
  std::uint16_t unused;
};
static_assert(sizeof(HelperEvent) == 16);
inline constexpr std::size_t helper_most_bytes = helper_block_events * sizeof(HelperEvent);

struct HelperImageSize {
  std::int32_t width;
  std::int32_t height;  ///< both 0 where the size is unknown
};

struct HelperArray {
  std::uint32_t type;     ///< ArrayType
  std::uint32_t lengths;  ///< number of dimensions
};

}  // namespace saccade
