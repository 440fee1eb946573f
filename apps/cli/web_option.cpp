#include "apps/cli/web_option.h"

namespace saccade {

Option add_web_option(Command& command, std::optional<LiveAddress>& address) {
  Option option = command.option(
      "--web", [&address](const std::string& text) { address = live_address_of(text == "true" ? "" : text); },
      "Offer a live page in a browser, and print its link: PORT on this machine alone, ADDRESS:PORT to "
      "others, or nothing for "
      "a free port. Write --web=PORT before a positional argument");
  return option.value_optional();
}

}  // namespace saccade
