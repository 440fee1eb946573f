// Any bytes as a scenario: they are one, or give an InputError, nothing else. One that is resolved reads again.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "config/scenario.h"
#include "core/error.h"
#include "tests/config/built_in.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace saccade;
  std::string resolved;
  try {
    const std::string text(reinterpret_cast<const char*>(data), size);
    resolved = resolved_scenario(read_scenario(parse_yaml(text, "fuzz.yaml"), ".", built_in()));
  } catch (const InputError&) {
    return 0;
  }
  try {
    (void)read_scenario(parse_yaml(resolved, "resolved.yaml"), ".", built_in());
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s\n%s", error.what(), resolved.c_str());
    std::abort();
  }
  return 0;
}
