#include "recording/module_path.h"

#include <dlfcn.h>

#include <cstring>

namespace saccade {

std::filesystem::path module_path() {
  Dl_info info{};
  std::error_code error;
  // A program that PATH found has no folder in its name.
  const bool named = ::dladdr(reinterpret_cast<const void*>(&module_path), &info) != 0 &&
                     info.dli_fname != nullptr && std::strchr(info.dli_fname, '/') != nullptr;
  if (named) {
    const std::filesystem::path file = std::filesystem::canonical(info.dli_fname, error);
    if (!error) return file;
  }
  return std::filesystem::canonical("/proc/self/exe", error);
}

}  // namespace saccade
