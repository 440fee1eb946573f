#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// Encodings of Prophesee's sensors (recording/evt_codec.h).
enum class EvtEncoding { evt2, evt21, evt21_legacy, evt3 };

/// "evt2", "evt21", "evt21_legacy", "evt3", in the order of EvtEncoding.
[[nodiscard]] const std::vector<std::string>& evt_encoding_names();

/// The encoding of words, the first of a file: all but 1 % are of types that it defines, and all but 1 % of the times
/// continue the ones before. None where no encoding fits, or there is no time among the words.
[[nodiscard]] std::optional<EvtEncoding> guess_evt_encoding(std::string_view words);
/// Whether words are in that encoding, as above.
[[nodiscard]] bool fits_evt_encoding(std::string_view words, EvtEncoding encoding);

}  // namespace saccade
