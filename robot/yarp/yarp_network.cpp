#include "robot/yarp/yarp_network.h"

#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <pthread.h>
#include <sched.h>
#include <sys/socket.h>
#include <unistd.h>
#include <yarp/os/Bottle.h>
#include <yarp/os/ContactStyle.h>
#include <yarp/os/Log.h>
#include <yarp/os/impl/BufferedConnectionWriter.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "core/error.h"

namespace saccade {
namespace {

using yarp::os::NetworkBase;

constexpr auto output_period = std::chrono::milliseconds(40);

/// Of share_priority(); 0: none.
std::atomic<int> shared_priority = 0;

yarp::os::ContactStyle style(double timeout_s) {
  yarp::os::ContactStyle style;
  style.quiet = true;
  style.timeout = timeout_s;
  return style;
}

Ipv4Address address_of(const yarp::os::Contact& contact) {
  addrinfo wanted{};
  wanted.ai_family = AF_INET;
  addrinfo* found = nullptr;
  if (contact.getPort() <= 0 || ::getaddrinfo(contact.getHost().c_str(), nullptr, &wanted, &found) != 0)
    return {};
  sockaddr_in address{};
  std::memcpy(&address, found->ai_addr, sizeof address);
  ::freeaddrinfo(found);
  return {address.sin_addr.s_addr, htons(static_cast<std::uint16_t>(contact.getPort()))};
}

/// Whether a file of this process is a TCP socket that is connected to an address, and neither side has closed it.
bool is_open_to(int file, const Ipv4Address& address) {
  sockaddr_in remote{};
  socklen_t size = sizeof remote;
  if (::getpeername(file, reinterpret_cast<sockaddr*>(&remote), &size) != 0 || remote.sin_family != AF_INET ||
      remote.sin_port != address.port || remote.sin_addr.s_addr != address.host)
    return false;
  tcp_info info{};
  size = sizeof info;
  return ::getsockopt(file, IPPROTO_TCP, TCP_INFO, &info, &size) == 0 && info.tcpi_state == TCP_ESTABLISHED;
}

/// The first such socket; -1 for none.
int socket_to(const Ipv4Address& address) {
  constexpr long most_files = 4096;  // numbers are given from the lowest on
  const long files = std::min(::sysconf(_SC_OPEN_MAX), most_files);
  for (int file = 3; address.port != 0 && file < files; ++file) {
    if (is_open_to(file, address)) return file;
  }
  return -1;
}

/// Of what YARP says only errors; it tells of every port that opens and closes otherwise.
void print_errors(yarp::os::Log::LogType type, const char* text, const char* file, const unsigned int line,
                  const char* function, double system_s, double network_s, double external_s,
                  const char* component, const char* id) {
  if (type != yarp::os::Log::ErrorType && type != yarp::os::Log::FatalType) return;
  yarp::os::Log::defaultPrintCallback()(type, text, file, line, function, system_s, network_s, external_s,
                                        component, id);
}

}  // namespace

void skip_message(yarp::os::ConnectionReader& reader) {
  if (reader.isTextMode()) return;
  std::array<char, 4096> bytes;
  for (std::size_t left = reader.getSize(); left > 0;) {
    const std::size_t count = std::min(left, bytes.size());
    if (!reader.expectBlock(bytes.data(), count)) return;
    left -= count;
  }
}

void discard(yarp::os::ConnectionReader& reader) {
  skip_message(reader);
  reader.requestDrop();
}

void share_priority() {
  sched_param priority{};
  int policy = 0;
  if (pthread_getschedparam(pthread_self(), &policy, &priority) != 0) return;
  shared_priority = policy == SCHED_FIFO ? priority.sched_priority : 0;
}

void adopt_priority() {
  thread_local int adopted = 0;
  const int wanted = shared_priority;
  if (adopted == wanted || wanted == 0) return;
  adopted = wanted;  // one attempt
  sched_param priority{};
  priority.sched_priority = wanted;
  (void)pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority);
}

void close_input(yarp::os::Port& port, const std::string& remote) {
  NetworkBase::disconnectInput(port.getName(), remote, true);
  port.interrupt();
  port.close();
}

void OutputCount::report(const yarp::os::PortInfo& info) {
  if (info.tag != yarp::os::PortInfo::PORTINFO_CONNECTION || info.incoming) return;
  count_ += info.created ? 1 : -1;
}

YarpNetwork::YarpNetwork(double timeout_s) {
  yarp::os::Log::setPrintCallback(print_errors);
  if (!name_server_answers(timeout_s)) {
    const yarp::os::Contact server = NetworkBase::getNameServerContact();
    throw RunError("no YARP name server answers at " + server.getHost() + ":" +
                   std::to_string(server.getPort()) + " (`yarp conf` prints the configured address)");
  }
}

Periodic::Periodic(std::chrono::milliseconds period, std::function<void()> work)
    : thread_([this, period, work = std::move(work)] {
        std::unique_lock lock(mutex_);
        while (!wake_.wait_for(lock, period, [this] { return ending_; })) {
          lock.unlock();
          work();
          lock.lock();
        }
      }) {}

Periodic::~Periodic() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

OutputWatch::OutputWatch(const std::string& from, std::string to)
    : from_(NetworkBase::queryName(from)),
      to_(std::move(to)),
      address_(address_of(NetworkBase::queryName(to_))),
      socket_(socket_to(address_)),
      watch_(output_period, [this] {
        if (!lost_ && !is_connected()) lost_ = true;
      }) {}

bool OutputWatch::is_connected() {
  if (socket_ < 0) return is_listed();
  if (!is_open_to(socket_, address_)) socket_ = socket_to(address_);
  return socket_ >= 0;
}

bool OutputWatch::is_listed() const {
  yarp::os::Bottle request("[list] [out]");
  yarp::os::Bottle reply;
  yarp::os::ContactStyle admin = style(1.0);
  admin.admin = true;
  // Addressed by its socket: it needs no name server.
  if (!NetworkBase::write(from_, request, reply, admin)) return true;
  for (std::size_t i = 0; i < reply.size(); ++i) {
    if (reply.get(i).asString() == to_) return true;
  }
  return false;
}

bool name_server_answers(double timeout_s) { return NetworkBase::checkNetwork(timeout_s); }

bool port_answers(const std::string& name, double timeout_s) {
  return NetworkBase::exists(name, style(timeout_s));
}

bool connect_ports(const std::string& from, const std::string& to, const std::string& carrier,
                   double timeout_s) {
  yarp::os::ContactStyle connection = style(timeout_s);
  connection.carrier = carrier;
  return NetworkBase::connect(from, to, connection);
}

}  // namespace saccade

/// For a reader that asks for text, YARP (3.8 to 3.12) turns a message into text when it is sent, after the envelope, and counts
/// the text among the parts of the header: it sends memory of the program and ends it. Here the message becomes text before
/// the envelope is added. This definition replaces that of YARP's library.
void yarp::os::impl::BufferedConnectionWriter::addToHeader() {
  stopWrite();
  stopPool();
  target = &header;
  target_used = &header_used;
}

/// YARP 3.12 resolves a name in several threads at once, such as those of clients that leave. The C library keeps the result
/// of this function in one place for all threads, which ended the program; here each thread has its own.
extern "C" hostent* gethostbyname(const char* name) {
  constexpr std::size_t least_bytes = 1024, most_bytes = 65'536;
  thread_local hostent entry;
  thread_local std::vector<char> text(least_bytes);
  hostent* found = nullptr;
  int problem = 0;
  while (::gethostbyname_r(name, &entry, text.data(), text.size(), &found, &problem) == ERANGE &&
         text.size() < most_bytes)
    text.resize(2 * text.size());
  if (found == nullptr) h_errno = problem;
  return found;
}
