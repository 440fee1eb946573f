#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// The start of a .npy file as NumPy writes it: the header ends at a multiple of 64 bytes.
inline std::string npy_header(std::string_view descr, std::string_view shape, int version = 1,
                              std::string_view fortran_order = "False") {
  std::string text = "{'descr': '" + std::string(descr) +
                     "', 'fortran_order': " + std::string(fortran_order) + ", 'shape': (" +
                     std::string(shape) + "), }";
  const std::size_t start = version == 1 ? 10 : 12;
  while ((start + text.size() + 1) % 64 != 0) text += ' ';
  text += '\n';
  std::string bytes = "\x93NUMPY";
  bytes += static_cast<char>(version);
  bytes += '\0';
  for (std::size_t i = 0; i < start - 8; ++i) bytes += static_cast<char>((text.size() >> (8 * i)) & 0xff);
  return bytes + text;
}

/// The numbers as they lie in memory.
template <class Value>
std::string raw_bytes(const std::vector<Value>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Value)};
}

}  // namespace saccade
