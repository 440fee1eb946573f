#include "recording/evt_encoding.h"

#include <array>
#include <cstdint>

#include "recording/byte_order.h"
#include "recording/evt21_decoder.h"

namespace saccade {
namespace {

/// What a word of a type and a time tells of the encoding.
struct WordEvidence {
  unsigned type = 0;
  std::uint32_t time = 0;  ///< the upper bits, of a word of time
  bool is_sound = true;    ///< bits that the encoding does not use are 0
};

constexpr unsigned time_type = 0x8;

std::size_t evt_word_bytes(EvtEncoding encoding) {
  return encoding == EvtEncoding::evt3 ? 2 : encoding == EvtEncoding::evt2 ? 4 : 8;
}

WordEvidence evidence_of(const char* bytes, EvtEncoding encoding) {
  if (encoding == EvtEncoding::evt3) {
    const std::uint32_t word = load_little<std::uint16_t>(bytes);
    return {word >> 12, word & 0xfff, true};
  }
  if (encoding == EvtEncoding::evt2) {
    const auto word = load_little<std::uint32_t>(bytes);
    return {word >> 28, word & 0xfffffff, true};
  }
  const auto order = encoding == EvtEncoding::evt21 ? Evt21Order::little : Evt21Order::legacy;
  const std::uint64_t word = load_evt21(bytes, order);
  const auto upper = static_cast<std::uint32_t>(word >> 32);
  return {upper >> 28, upper & 0xfffffff, upper >> 28 != time_type || static_cast<std::uint32_t>(word) == 0};
}

}  // namespace

const std::vector<std::string>& evt_encoding_names() {
  static const std::vector<std::string> names = {"evt2", "evt21", "evt21_legacy", "evt3"};
  return names;
}

bool fits_evt_encoding(std::string_view words, EvtEncoding encoding) {
  // Bit i: type i is defined.
  constexpr unsigned evt2_types = 0xe503, evt21_types = 0xc503, evt3_types = 0xc5fd;
  const unsigned types = encoding == EvtEncoding::evt3   ? evt3_types
                         : encoding == EvtEncoding::evt2 ? evt2_types
                                                         : evt21_types;
  const std::uint32_t time_range = encoding == EvtEncoding::evt3 ? 1u << 12 : 1u << 28;
  const std::uint32_t longest_step = encoding == EvtEncoding::evt3 ? 1u << 10 : 1u << 16;
  std::int64_t count = 0, bad = 0, times = 0, bad_times = 0;
  std::optional<std::uint32_t> last_time;
  for (const std::size_t bytes = evt_word_bytes(encoding); words.size() >= bytes;
       words.remove_prefix(bytes)) {
    const WordEvidence word = evidence_of(words.data(), encoding);
    ++count;
    bad += (types >> word.type & 1) == 0 || !word.is_sound ? 1 : 0;
    if (word.type != time_type || !word.is_sound) continue;
    ++times;
    const std::uint32_t step = (word.time - last_time.value_or(word.time)) & (time_range - 1);
    bad_times += step > longest_step ? 1 : 0;
    last_time = word.time;
  }
  return times > 0 && bad * 100 <= count && bad_times * 100 <= times;
}

std::optional<EvtEncoding> guess_evt_encoding(std::string_view words) {
  // EVT2.1 first: most of its words look like those of EVT2 too.
  for (const EvtEncoding encoding :
       {EvtEncoding::evt21, EvtEncoding::evt21_legacy, EvtEncoding::evt2, EvtEncoding::evt3}) {
    if (fits_evt_encoding(words, encoding)) return encoding;
  }
  return std::nullopt;
}

}  // namespace saccade
