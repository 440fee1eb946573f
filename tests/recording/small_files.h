#pragma once

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "core/event.h"

namespace saccade {

/// A small file of one format, made by hand from the description of the format, in pieces.
struct SmallFile {
  struct Piece {
    std::string bytes;
    std::vector<Event> events;  ///< that are there when the last of the bytes is
    bool may_end = true;        ///< whether a file that ends behind this piece looks whole
  };
  std::string name;  ///< of the file; the extension matters where the content does not identify the format
  std::vector<Piece> pieces;

  [[nodiscard]] std::string bytes() const {
    std::string whole;
    for (const Piece& piece : pieces) whole += piece.bytes;
    return whole;
  }
  [[nodiscard]] std::vector<Event> events() const {
    std::vector<Event> all;
    for (const Piece& piece : pieces) all.insert(all.end(), piece.events.begin(), piece.events.end());
    return all;
  }
};

/// One of each format that is read.
[[nodiscard]] std::vector<SmallFile> small_files();

/// A ZIP file whose members are not compressed.
[[nodiscard]] std::string stored_zip(const std::vector<std::pair<std::string, std::string>>& members);

/// Numbers as bytes.
template <class T>
std::string little_endian(T value) {
  std::string bytes;
  for (std::size_t i = 0; i < sizeof value; ++i)
    bytes += static_cast<char>(static_cast<unsigned char>(static_cast<std::uint64_t>(value) >> 8 * i & 0xff));
  return bytes;
}
template <class T>
std::string big_endian(T value) {
  const std::string bytes = little_endian(value);
  return {bytes.rbegin(), bytes.rend()};
}
template <class T>
std::string little_endian_words(std::initializer_list<T> words) {
  std::string bytes;
  for (const T word : words) bytes += little_endian(word);
  return bytes;
}

}  // namespace saccade
