#include "robot/yarp/yarp_network.h"

#include <yarp/os/Bottle.h>
#include <yarp/os/ContactStyle.h>
#include <yarp/os/Log.h>

#include <chrono>

#include "core/error.h"

namespace saccade {
namespace {

using yarp::os::NetworkBase;

constexpr auto output_period = std::chrono::milliseconds(50);
constexpr int looks_per_name_server = 20;

yarp::os::ContactStyle style(double timeout_s) {
  yarp::os::ContactStyle style;
  style.quiet = true;
  style.timeout = timeout_s;
  return style;
}

}  // namespace

YarpNetwork::YarpNetwork(double timeout_s) {
  yarp::os::Log::setMinimumPrintLevel(yarp::os::Log::ErrorType);
  if (!NetworkBase::checkNetwork(timeout_s)) {
    const yarp::os::Contact server = NetworkBase::getNameServerContact();
    throw RunError("no YARP name server answers at " + server.getHost() + ":" +
                   std::to_string(server.getPort()) + " (`yarp conf` tells where it is looked for)");
  }
}

YarpWatch::YarpWatch(const std::vector<Output>& outputs, double timeout_s) {
  for (const Output& output : outputs) outputs_.emplace_back(NetworkBase::queryName(output.from), output.to);
  thread_ = std::thread([this, timeout_s] { run(timeout_s); });
}

YarpWatch::~YarpWatch() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void YarpWatch::run(double timeout_s) {
  std::unique_lock lock(mutex_);
  for (int look = 1; !wake_.wait_for(lock, output_period, [this] { return ending_; }); ++look) {
    lock.unlock();
    if (!lost_ && !outputs_stand()) lost_ = true;
    if (look % looks_per_name_server == 0) has_name_server_ = NetworkBase::checkNetwork(timeout_s);
    lock.lock();
  }
}

bool YarpWatch::outputs_stand() const {
  for (const auto& [port, to] : outputs_) {
    yarp::os::Bottle request("[list] [out]");
    yarp::os::Bottle reply;
    yarp::os::ContactStyle admin = style(1.0);
    admin.admin = true;
    // Addressed by its socket: it needs no name server.
    if (!NetworkBase::write(port, request, reply, admin)) continue;
    bool stands = false;
    for (std::size_t i = 0; i < reply.size(); ++i) stands = stands || reply.get(i).asString() == to;
    if (!stands) return false;
  }
  return true;
}

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
