#include <algorithm>

#include "core/error.h"
#include "evaluation/replay/replay_asset.h"

namespace saccade {

std::string filled_page(std::string_view text,
                        const std::vector<std::pair<std::string_view, std::string_view>>& values) {
  std::string page;
  while (true) {
    const std::size_t open = text.find("{{{");
    if (open == std::string_view::npos) return page.append(text);
    const std::size_t close = text.find("}}}", open);
    const std::string_view name = text.substr(open + 3, close - open - 3);
    const auto value = std::ranges::find(values, name, &std::pair<std::string_view, std::string_view>::first);
    SACCADE_CHECK(value != values.end());
    page.append(text.substr(0, open)).append(value->second);
    text.remove_prefix(close + 3);
  }
}

}  // namespace saccade
