#include "robot/yarp/checked_port.h"

#include <yarp/os/ConnectionWriter.h>
#include <yarp/os/Contact.h>
#include <yarp/os/Network.h>

#include <utility>
#include <vector>

#include "core/error.h"
#include "robot/bottle.h"

namespace saccade::inline v0_1 {

namespace {

/// Whether a pair of a Bottle and a vector can be read from it, as controlBoard_nws_yarp does without a check.
bool is_command(const yarp::os::Bottle& message) {
  if (message.size() != 2) return false;
  const yarp::os::Bottle* head = message.get(0).asList();
  const yarp::os::Bottle* values = message.get(1).asList();
  if (head == nullptr || values == nullptr || values->size() == 0) return false;
  if (!head->get(0).isVocab32() && !head->get(0).isInt32()) return false;
  for (std::size_t i = 0; i < values->size(); ++i) {
    if (!values->get(i).isFloat64()) return false;
  }
  return true;
}

}  // namespace

std::optional<yarp::os::Bottle> checked_message(yarp::os::ConnectionReader& reader) {
  if (!reader.isValid()) return std::nullopt;
  yarp::os::Bottle message;
  if (reader.isTextMode()) {
    const std::string line = reader.expectText();
    if (line.size() > longest_bottle) {
      reader.requestDrop();
      return std::nullopt;
    }
    message.fromString(line);
    return message;
  }
  const std::size_t size = reader.getSize();
  if (size > longest_bottle) {
    discard(reader);
    return std::nullopt;
  }
  std::vector<std::byte> bytes(size);
  if (!reader.expectBlock(reinterpret_cast<char*>(bytes.data()), size)) return std::nullopt;
  if (!check_bottle(bytes).empty()) {
    reader.requestDrop();
    return std::nullopt;
  }
  message.fromBinary(reinterpret_cast<const char*>(bytes.data()), size);
  return message;
}

CheckedPort::CheckedPort(const std::string& name, Kind kind) : kind_(kind) {
  in_.setReader(*this);
  if (kind == Kind::requests) in_.setRpcMode(true);
  out_.setInputMode(false);
  const bool open = in_.open(name + "/checked") && out_.open(name + "/checked/out");
  if (!open || !yarp::os::Network::connect(out_.getName(), name, kind == Kind::requests ? "tcp" : "fast_tcp"))
    throw RunError("YARP cannot open the port " + name + "/checked: is the name in use?");
  yarp::os::Contact contact = in_.where();
  contact.setName(name);
  yarp::os::Network::registerContact(contact);
}

CheckedPort::~CheckedPort() {
  in_.interrupt();
  in_.close();
  out_.interrupt();
  out_.close();
}

bool CheckedPort::read(yarp::os::ConnectionReader& reader) {
  const auto message = checked_message(reader);
  if (!message) return false;
  if (kind_ == Kind::commands && !is_command(*message)) {
    reader.requestDrop();
    return false;
  }
  const std::lock_guard lock(mutex_);
  if (kind_ == Kind::commands) return out_.write(*message);
  yarp::os::Bottle reply;
  if (!out_.write(*message, reply)) return false;
  if (yarp::os::ConnectionWriter* writer = reader.getWriter()) reply.write(*writer);
  return true;
}

}  // namespace saccade::inline v0_1
