#include "robot/yarp/checked_port.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <yarp/os/ConnectionWriter.h>
#include <yarp/os/Contact.h>
#include <yarp/os/Network.h>

#include <utility>
#include <vector>

#include "core/error.h"
#include "robot/bottle.h"

namespace saccade {
namespace {

constexpr int attempts = 5;  // another program can take a socket between its choice and its use

/// A TCP port that no program uses; 0 if the operating system gives none.
int free_socket() {
  const int file = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (file < 0) return 0;
  sockaddr_in address{};
  address.sin_family = AF_INET;
  socklen_t size = sizeof address;
  const bool found = ::bind(file, reinterpret_cast<const sockaddr*>(&address), size) == 0 &&
                     ::getsockname(file, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  ::close(file);
  return found ? ntohs(address.sin_port) : 0;
}

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
  const auto failed = [&](const char* what) {
    return RunError("YARP cannot " + std::string(what) + " " + name);
  };
  out_.setInputMode(false);
  if (!out_.open(name + "/checked")) throw failed("open the port that checks the messages of");
  if (!yarp::os::Network::connect(out_.getName(), name, kind == Kind::requests ? "tcp" : "fast_tcp"))
    throw failed("connect the port that checks the messages of");
  // The name moves to in_. A socket of the operating system's choice, not of the name server's: that would give the socket
  // of the port that lost its name to the next port of this name, while it is still in use.
  const std::string host = yarp::os::Network::queryName(name).getHost();
  in_.setReader(*this);
  if (kind == Kind::requests) in_.setRpcMode(true);
  for (int attempt = 0; attempt < attempts; ++attempt) {
    const yarp::os::Contact contact(name, "tcp", host, free_socket());
    if (!in_.open(contact)) continue;
    yarp::os::Network::registerContact(contact);  // open() does not, with a socket
    return;
  }
  throw failed("open a checked port named");
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

}  // namespace saccade
