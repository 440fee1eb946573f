#include "recording/own_file.h"

#include <dlfcn.h>

#include <cstring>

namespace saccade {

std::filesystem::path own_file() {
  Dl_info info{};
  std::error_code error;
  // A program that PATH found has no folder in its name.
  const bool named = ::dladdr(reinterpret_cast<const void*>(&own_file), &info) != 0 &&
                     info.dli_fname != nullptr && std::strchr(info.dli_fname, '/') != nullptr;
  if (named) {
    const std::filesystem::path file = std::filesystem::canonical(info.dli_fname, error);
    if (!error) return file;
  }
  return std::filesystem::canonical("/proc/self/exe", error);
}

}  // namespace saccade
