#include "recording/file_digest.h"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <vector>

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t fnv_start = 0xcbf29ce484222325ULL;

void add_bytes(std::uint64_t& hash, std::string_view bytes) {
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
}

std::string hex_digits(std::uint64_t hash) {
  std::string text(16, '0');
  for (std::size_t i = text.size(); i-- > 0; hash >>= 4) text[i] = "0123456789abcdef"[hash & 15];
  return text;
}

bool add_file(std::uint64_t& hash, const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::vector<char> block(std::size_t{1} << 16);
  while (file.read(block.data(), static_cast<std::streamsize>(block.size())) || file.gcount() > 0)
    add_bytes(hash, {block.data(), static_cast<std::size_t>(file.gcount())});
  return file.eof();
}

}  // namespace

std::string digest(std::string_view bytes) {
  std::uint64_t hash = fnv_start;
  add_bytes(hash, bytes);
  return hex_digits(hash);
}

std::string digest_of_file(const fs::path& path) {
  std::vector<fs::path> files = {path};
  std::error_code error;
  if (fs::is_directory(path, error)) {
    files.clear();
    for (const auto& entry : fs::directory_iterator(path, error)) {
      if (entry.is_regular_file(error)) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
  }
  std::uint64_t hash = fnv_start;
  for (const fs::path& file : files) {
    if (files.size() > 1 || file != path) add_bytes(hash, file.filename().string());
    if (!add_file(hash, file)) return "unreadable";
  }
  return hex_digits(hash);
}

}  // namespace saccade
