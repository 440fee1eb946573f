#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "evaluation/replay/packed_table.h"

namespace saccade {

/// A message of the stream: the length of the JSON text in four bytes (the lowest first), that text, and the columns of the
/// tables that it describes.
[[nodiscard]] std::string live_message(nlohmann::ordered_json head,
                                       const std::vector<PackedTable>& tables = {});

/// The live page.
[[nodiscard]] std::string live_page();

}  // namespace saccade
