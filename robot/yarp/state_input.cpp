#include "robot/yarp/state_input.h"

#include <yarp/os/ConnectionReader.h>
#include <yarp/os/PortInfo.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <span>
#include <string_view>
#include <utility>

#include "core/error.h"
#include "robot/number_list.h"
#include "robot/yarp/yarp_network.h"

namespace saccade {

std::optional<std::int64_t> sent_us(yarp::os::ConnectionReader& reader) {
  const yarp::os::Bytes bytes = reader.readEnvelope();
  std::string_view text(bytes.get(), bytes.length());
  const auto space = text.find(' ');  // "number time", time in s
  if (space == std::string_view::npos) return std::nullopt;
  text.remove_prefix(std::min(text.find_first_not_of(' ', space), text.size()));
  double time_s = 0.0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), time_s);
  if (result.ec != std::errc() || !(time_s > 0.0 && time_s < 1e12)) return std::nullopt;
  return std::llround(time_s * 1e6);
}

StateInput::StateInput(const std::string& local, std::string remote, const std::string& carrier,
                       double timeout_s, const SteadyClock& clock)
    : remote_(std::move(remote)), clock_(clock) {
  port_.setReader(*this);
  port_.setReporter(*this);
  if (!port_.open(local)) throw RunError("YARP cannot open the port " + local);
  if (!connect_ports(remote_, port_.getName(), carrier, timeout_s)) lost_ = true;
}

StateInput::~StateInput() { close_input(port_, remote_); }

bool StateInput::read(yarp::os::ConnectionReader& reader) {
  if (!reader.isValid()) return false;
  std::array<std::byte, longest_number_list> bytes;
  const std::size_t size = reader.getSize();
  if (reader.isTextMode() || size > bytes.size() || reader.getRemoteContact().getName() != remote_) {
    ++discarded_;
    discard(reader);
    return false;
  }
  adopt_priority();
  if (!reader.expectBlock(reinterpret_cast<char*>(bytes.data()), size)) return false;
  std::array<double, most_values> value{};
  int length = 0;
  if (!read_number_list(std::span(bytes).first(size), value, length).empty()) {
    ++discarded_;
    return true;
  }
  const std::lock_guard lock(mutex_);
  State state = state_.read();
  const std::int64_t arrival_us = clock_.now_us();
  const auto sent = sent_us(reader);
  const int count = std::min(length, most_values);
  const std::int64_t t_us = sent ? sender_.to_local(*sent, arrival_us) : arrival_us;
  const std::int64_t step_us =
      sent && last_sent_us_ ? *sent - *last_sent_us_ : std::max<std::int64_t>(t_us - state.t_us, 0);
  last_sent_us_ = sent;
  if (state.count > 0 && step_us <= 0) return true;  // the same reading again, or one from before
  for (int i = 0; i < count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    state.rate[at] =
        i < state.count ? (value[at] - state.value[at]) * 1e6 / static_cast<double>(step_us) : 0.0;
    state.value[at] = value[at];
  }
  state.count = count;
  state.t_us = std::max(state.t_us, t_us);
  state_.write(state);
  return true;
}

void StateInput::report(const yarp::os::PortInfo& info) {
  const bool closed = info.tag == yarp::os::PortInfo::PORTINFO_CONNECTION && info.incoming && !info.created;
  if (closed && info.sourceName == remote_) lost_ = true;
}

}  // namespace saccade
