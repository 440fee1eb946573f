#pragma once

#include "recording/format_registry.h"

namespace saccade {

/// N-MNIST and N-Caltech101 (.bin): events of 5 bytes: x, y, then big-endian polarity (1 = ON) in the top bit and 23 bits of
/// us. The origin is top left. A record with y 240 is no event; later times are 2^13 us longer. Times are continued over
/// their wraps at 2^23 us. The file has no image size: EventReadOptions::image_size.
///
/// The format has no mark. A file with the extension .bin is taken for it where the first 4096 bytes are records with x
/// below 240, y up to 240 and times in order, but for one in a hundred.
///
/// Source: the data sets' read functions (gorchard/event-Python).
[[nodiscard]] RecordingFormat nmnist_format();

}  // namespace saccade
