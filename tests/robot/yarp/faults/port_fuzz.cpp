// Random messages to the input ports of a program of YARP: PID SECONDS SEED PORT... All ports in turn, each from a sender
// of its own: valid messages, and such with changed bytes, false counts and false lengths, as binary and as text, whole and
// cut off. Prints the number of messages and the largest memory of the process. Status 1 if it ended or exceeded 300 MB.
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>
#include <yarp/os/Bottle.h>
#include <yarp/os/ConnectionWriter.h>
#include <yarp/os/Network.h>
#include <yarp/os/Port.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <fstream>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace saccade {
namespace {

constexpr long most_kb = 300'000;
constexpr const char* texts[] = {"look 3D (-0.5 0.1 0.3)",
                                 "look mono (left 64 60 0.5)",
                                 "get info",
                                 "set Tneck 0.8",
                                 "bind pitch -10 10",
                                 "set tweak ((camera_width_left 128))",
                                 "[set] [vel] (1.0 2.0 3.0 4.0 5.0 6.0)",
                                 "[get] [encs]",
                                 "help",
                                 "1.0 2.0 3.0 4.0 5.0 6.0",
                                 "[set] [icmd] [cmod] 0 [pos]",
                                 "AE 4 1 2 3 4",
                                 "stor",
                                 "rest 1",
                                 "del 1",
                                 "susp",
                                 "run"};

struct Bytes final : yarp::os::PortWriter {
  std::string bytes;
  bool write(yarp::os::ConnectionWriter& writer) const override {
    writer.appendBlock(bytes.data(), bytes.size());
    return true;
  }
};

class Messages {
 public:
  explicit Messages(std::uint64_t seed) : random_(seed) {}

  std::size_t below(std::size_t n) { return random_() % n; }

  std::string text() { return changed(texts[below(std::size(texts))]); }

  std::string binary() {
    if (below(8) == 0) return changed(std::string(below(200), '\0'));
    yarp::os::Bottle bottle;
    bottle.fromString(texts[below(std::size(texts))]);
    std::size_t size = 0;
    const char* data = bottle.toBinary(&size);
    return changed(std::string(data, size));
  }

 private:
  std::string changed(std::string bytes) {
    for (std::size_t n = below(4); n > 0 && !bytes.empty(); --n) {
      const std::size_t at = below(bytes.size());
      switch (below(5)) {
        case 0:
          bytes[at] = static_cast<char>(random_());
          break;
        case 1:
          bytes.resize(at);
          break;
        case 2:
          bytes.insert(at, below(64), static_cast<char>(random_()));
          break;
        case 3: {  // a count or a length
          constexpr std::int32_t counts[] = {-1, 0, 1, 1 << 16, 1 << 28, 0x7fffffff, -0x7fffffff};
          const std::int32_t count = counts[below(std::size(counts))];
          const std::size_t word = at / 4 * 4;
          if (word + 4 <= bytes.size()) std::memcpy(bytes.data() + word, &count, 4);
          break;
        }
        default:
          bytes += bytes;
      }
      if (bytes.size() > 100'000) bytes.resize(100'000);
    }
    return bytes;
  }

  std::mt19937_64 random_;
};

/// Sends text to a port as `yarp write` does, without an end in half of the cases.
void send_text(const std::string& port, const std::string& name, Messages& messages) {
  const yarp::os::Contact contact = yarp::os::Network::queryName(port);
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(contact.getPort()));
  std::string text = "CONNECT " + name + "\r\nd\r\n";
  for (std::size_t n = messages.below(5); n > 0; --n)
    text += messages.text() + (messages.below(2) == 0 ? "\r\n" : "");
  if (::connect(socket, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0)
    (void)!::send(socket, text.data(), text.size(), MSG_NOSIGNAL);
  ::close(socket);
}

class Sender {
 public:
  Sender(std::string to, std::size_t number, std::uint64_t seed)
      : to_(std::move(to)),
        name_(fmt::format("/port_fuzz/{}/{}", ::getpid(), number)),
        messages_(seed + number) {
    port_.setTimeout(1.0F);
    port_.open(name_);
  }
  void send() {
    if (messages_.below(50) == 0) send_text(to_, name_, messages_);
    if (port_.getOutputCount() == 0)
      yarp::os::Network::connect(name_, to_, messages_.below(2) == 0 ? "tcp" : "fast_tcp");
    Bytes message;
    message.bytes = messages_.binary();
    port_.write(message);
    ++sent_;
  }
  [[nodiscard]] long sent() const { return sent_; }

 private:
  std::string to_, name_;
  Messages messages_;
  yarp::os::Port port_;
  long sent_ = 0;
};

long memory_kb(int pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmRSS:")) return std::strtol(line.c_str() + 6, nullptr, 10);
  }
  return -1;
}

}  // namespace
}  // namespace saccade

int main(int count, char** arguments) {
  using namespace saccade;
  if (count < 5) {
    fmt::print(stderr, "usage: saccade_port_fuzz PID SECONDS SEED PORT...\n");
    return 2;
  }
  const int pid = std::atoi(arguments[1]);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(std::atoi(arguments[2]));
  const std::uint64_t seed = std::strtoull(arguments[3], nullptr, 10);
  const std::vector<std::string> ports(arguments + 4, arguments + count);
  const yarp::os::Network network;
  // One thread: YARP 3.12 looks up names with gethostbyname, which is not made for several.
  std::vector<std::unique_ptr<Sender>> senders;
  for (std::size_t i = 0; i < ports.size(); ++i)
    senders.push_back(std::make_unique<Sender>(ports[i], i, seed));
  long largest_kb = memory_kb(pid);
  fmt::print("process {}: {} MB at first\n", pid, largest_kb / 1000);
  bool lives = largest_kb > 0;
  while (lives && std::chrono::steady_clock::now() < end) {
    for (const auto& sender : senders) sender->send();
    const long now_kb = memory_kb(pid);
    lives = now_kb > 0;
    largest_kb = std::max(largest_kb, now_kb);
  }
  for (std::size_t i = 0; i < ports.size(); ++i)
    fmt::print("{}: {} messages\n", ports[i], senders[i]->sent());
  fmt::print("{}; {} MB at most, {} MB allowed\n", lives ? "the process lives" : "THE PROCESS ENDED",
             largest_kb / 1000, most_kb / 1000);
  return lives && largest_kb <= most_kb ? 0 : 1;
}
