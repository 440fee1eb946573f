#include "robot/client_stream.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include "robot/bottle.h"

namespace saccade {
namespace {

static_assert(std::endian::native == std::endian::little, "the wire is little-endian");

constexpr std::size_t number_bytes = 8;  // "YA", a 32-bit integer, "RP"
constexpr std::size_t index_bytes = 10;  // counts of blocks, and filling
constexpr std::size_t command_bytes = 8;
constexpr std::int32_t first_carrier = 7777;
constexpr std::int32_t fast_tcp = first_carrier + 3, tcp = fast_tcp + 128;
constexpr int deepest_text = 8;
constexpr std::ptrdiff_t more = 0, not_acceptable = -1;

std::string_view text_of(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::int32_t integer_at(std::span<const std::byte> bytes, std::size_t at) {
  std::int32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof(value));
  return value;
}

/// Of the first number_bytes; none for other bytes.
std::optional<std::int32_t> number(std::span<const std::byte> bytes) {
  const std::string_view text = text_of(bytes);
  if (text.substr(0, 2) != "YA" || text.substr(6, 2) != "RP") return std::nullopt;
  return integer_at(bytes, 2);
}

/// A line with its end, within `longest` bytes.
std::ptrdiff_t line(std::span<const std::byte> held, std::size_t longest) {
  const std::string_view text = text_of(held);
  const auto end = text.find('\n');
  if (end == std::string_view::npos) return text.size() > longest ? not_acceptable : more;
  return end > longest || !is_bounded_text(text.substr(0, end)) ? not_acceptable
                                                                : static_cast<std::ptrdiff_t>(end + 1);
}

/// A carrier's number and a name.
std::ptrdiff_t binary_introduction(std::span<const std::byte> held, std::string_view& name) {
  constexpr std::size_t before_name = number_bytes + sizeof(std::int32_t);
  if (held.size() < before_name) return more;
  const std::int32_t length = integer_at(held, number_bytes);
  if (length < 1 || length > static_cast<std::int32_t>(longest_client_name)) return not_acceptable;
  const auto size = static_cast<std::size_t>(length);
  if (held.size() < before_name + size) return more;
  name = text_of(held.subspan(before_name, size));
  name = name.substr(0, name.find('\0'));
  return is_bounded_text(name) ? static_cast<std::ptrdiff_t>(before_name + size) : not_acceptable;
}

}  // namespace

bool is_bounded_text(std::string_view line) {
  int depth = 0;
  bool quoted = false;
  bool escaped = false;
  for (const char c : line) {
    if (c == '\r' || c == '\0') continue;  // YARP leaves them out
    if (escaped) {
      escaped = false;
    } else if (c == '\\') {
      escaped = true;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && (c == '(' || c == '[' || c == '{')) {
      if (++depth > deepest_text) return false;
    } else if (!quoted && (c == ')' || c == ']' || c == '}')) {
      if (--depth < 0) return false;
    }
  }
  return depth == 0 && !quoted && !escaped;
}

bool ClientStream::add(std::span<const std::byte> bytes, std::vector<std::byte>& passed) {
  if (state_ == State::broken) return false;
  held_.insert(held_.end(), bytes.begin(), bytes.end());
  std::size_t at = 0;
  while (at < held_.size()) {
    next_ = state_;
    const std::ptrdiff_t size = unit(std::span(held_).subspan(at));
    if (size == not_acceptable) {
      state_ = State::broken;
      held_ = {};
      return false;
    }
    if (size == more) break;
    state_ = next_;
    const auto begin = held_.begin() + static_cast<std::ptrdiff_t>(at);
    passed.insert(passed.end(), begin, begin + size);
    at += static_cast<std::size_t>(size);
  }
  held_.erase(held_.begin(), held_.begin() + static_cast<std::ptrdiff_t>(at));
  return true;
}

std::ptrdiff_t ClientStream::unit(std::span<const std::byte> held) {
  switch (state_) {
    case State::introduction:
      return introduction(held);
    case State::binary:
      return message(held);
    case State::text:
      return line(held, longest_bottle);
    case State::reversed:
      if (held.size() < number_bytes) return more;
      return number(held) == 0 ? static_cast<std::ptrdiff_t>(number_bytes) : not_acceptable;
    case State::broken:
      break;
  }
  return not_acceptable;
}

UdpIntroduction udp_introduction(std::span<const std::byte> first) {
  if (first.size() < number_bytes)
    return {std::string_view("YA").starts_with(text_of(first).substr(0, 2)), {}};
  if (number(first) != first_carrier) return {};
  std::string_view name;
  const std::ptrdiff_t size = binary_introduction(first, name);
  if (size == more) return {true, {}};
  return size == not_acceptable ? UdpIntroduction{} : UdpIntroduction{true, std::string(name)};
}

std::ptrdiff_t ClientStream::introduction(std::span<const std::byte> held) {
  if (held.size() < number_bytes) return more;
  const std::string_view carrier = text_of(held).substr(0, number_bytes);
  if (carrier == "CONNECT " || carrier == "CONNACK ") {
    next_ = State::text;
    return line(held, number_bytes + longest_client_name);
  }
  const auto code = number(held);
  if (code != tcp && code != fast_tcp) return not_acceptable;
  next_ = State::binary;
  std::string_view name;
  return binary_introduction(held, name);
}

std::ptrdiff_t ClientStream::message(std::span<const std::byte> held) {
  constexpr std::int32_t index = 10;
  if (held.size() < number_bytes) return more;
  if (number(held) != index) return not_acceptable;
  if (held.size() < number_bytes + index_bytes) return more;
  const auto blocks =
      static_cast<std::size_t>(held[number_bytes]) + static_cast<std::size_t>(held[number_bytes + 1]);
  const std::size_t before_payload = number_bytes + index_bytes + blocks * sizeof(std::int32_t);
  if (held.size() < before_payload) return more;
  std::size_t payload = 0;
  for (std::size_t i = 0; i < blocks; ++i) {
    const std::int32_t length = integer_at(held, number_bytes + index_bytes + i * sizeof(std::int32_t));
    if (length < 0) return not_acceptable;
    payload += static_cast<std::size_t>(length);
    if (payload > longest_bottle) return not_acceptable;
  }
  if (held.size() < before_payload + payload) return more;
  if (!command(held.subspan(before_payload, payload))) return not_acceptable;
  return static_cast<std::ptrdiff_t>(before_payload + payload);
}

/// The payload of a message: a command of a port, as a letter or behind the head as a text, and what belongs to it.
bool ClientStream::command(std::span<const std::byte> payload) {
  if (payload.size() < command_bytes) return false;
  const std::string_view head = text_of(payload.first(command_bytes));
  if (head[4] != '~') return false;
  char key = head[5];
  std::span<const std::byte> rest = payload.subspan(command_bytes);
  if (key == '\0') {
    const std::string_view text = text_of(rest);
    const auto end = text.find('\0');
    if (end == std::string_view::npos || end == 0 || !is_bounded_text(text.substr(0, end))) return false;
    key = text.front();
    rest = rest.subspan(end + 1);
  }
  switch (key) {
    case 'd':
    case 'D':
    case 'a':
      return check_bottle(rest).empty();
    case 'r':
      next_ = State::reversed;
      return rest.empty();
    case '/':
    case '!':
    case '~':
    case '*':
    case 'q':
    case '?':
    case 'h':
      return rest.empty();
    default:
      return false;
  }
}

}  // namespace saccade
