#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// Longest name with which a client of YARP introduces itself, bytes.
inline constexpr std::size_t longest_client_name = 1000;

/// Whether YARP reads a line of text in bounded depth and memory: its lists are at most 8 deep and end in the line, and so
/// do its quotes.
[[nodiscard]] bool is_bounded_text(std::string_view line);

/// The longest introduction of a client with a binary carrier, bytes.
inline constexpr std::size_t longest_introduction = 8 + 4 + longest_client_name;

/// What the first bytes of a connection say of a client with the carrier udp, whose messages come to another socket.
struct UdpIntroduction {
  bool may_be = false;              ///< with more bytes
  std::optional<std::string> name;  ///< of a whole introduction
};
[[nodiscard]] UdpIntroduction udp_introduction(std::span<const std::byte> first);

/// Checks what a client sends to a port of YARP before YARP reads it: YARP believes every count and length, also in its own
/// administrative messages, and an exception in one of its threads ends the program.
///
/// A stream begins with an introduction: the carrier (tcp, fast_tcp, text, text_ack; no other, see udp_introduction()) and the client's name. Whole
/// messages of at most longest_bottle bytes follow. Each is a command of YARP's ports; data and administrative messages
/// hold one Bottle, or a line of text (is_bounded_text). A client that reverses the connection, to read, sends nothing but
/// acknowledgements from then on. Source: the format is that of YARP 3.12's own connections.
class ClientStream {
 public:
  /// Takes the next bytes. Appends to `passed` what may go on to YARP: the introduction and whole messages. Returns false
  /// if the connection has to be closed, from then on always.
  [[nodiscard]] bool add(std::span<const std::byte> bytes, std::vector<std::byte>& passed);
  /// Whether the introduction was passed on.
  [[nodiscard]] bool is_introduced() const { return state_ != State::introduction; }
  /// Whether it has a part of a message, or of the introduction, that is not whole.
  [[nodiscard]] bool has_part() const { return !held_.empty(); }

 private:
  enum class State { introduction, binary, text, reversed, broken };
  /// Length of the first unit of the bytes that are held; 0: more are needed, -1: they are not acceptable.
  [[nodiscard]] std::ptrdiff_t unit(std::span<const std::byte> held);
  [[nodiscard]] std::ptrdiff_t introduction(std::span<const std::byte> held);
  [[nodiscard]] std::ptrdiff_t message(std::span<const std::byte> held);
  [[nodiscard]] bool command(std::span<const std::byte> payload);

  State state_ = State::introduction;
  State next_ = State::introduction;  // after the unit
  std::vector<std::byte> held_;
};

}  // namespace saccade
