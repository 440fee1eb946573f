#include "robot/yarp/gaze_ports.h"

#include <yarp/os/Bottle.h>
#include <yarp/os/BufferedPort.h>
#include <yarp/os/ConnectionReader.h>
#include <yarp/os/ConnectionWriter.h>
#include <yarp/os/Port.h>
#include <yarp/os/PortReader.h>
#include <yarp/os/RpcServer.h>
#include <yarp/os/Stamp.h>
#include <yarp/os/Time.h>

#include <deque>

#include "core/error.h"
#include "core/units.h"
#include "robot/yarp/checked_port.h"
#include "robot/yarp/yarp_network.h"

namespace saccade {
namespace {

constexpr std::size_t most_waiting = 100;  // events of a reader that is slow; older ones are dropped

[[noreturn]] void throw_in_use(const std::string& name) {
  throw RunError("YARP cannot open the port " + name + ": is the name in use?");
}

/// What a port says, as the request that means the same.
class Look final : public yarp::os::PortReader {
 public:
  Look(const char* kind, const YarpGazePorts::Answer& answer) : kind_(kind), answer_(answer) {}
  bool read(yarp::os::ConnectionReader& reader) override {
    const auto message = checked_message(reader);
    if (!message) return false;
    answer_("look " + kind_ + " (" + message->toString() + ")");
    return true;
  }

 private:
  std::string kind_;
  const YarpGazePorts::Answer& answer_;
};

class Rpc final : public yarp::os::PortReader {
 public:
  explicit Rpc(const YarpGazePorts::Answer& answer) : answer_(answer) {}
  bool read(yarp::os::ConnectionReader& reader) override {
    const auto request = checked_message(reader);
    if (!request) return false;
    yarp::os::Bottle reply(answer_(request->toString()));
    if (yarp::os::ConnectionWriter* writer = reader.getWriter()) reply.write(*writer);
    return true;
  }

 private:
  const YarpGazePorts::Answer& answer_;
};

/// An output port whose calls do not wait: no message while the previous one is being sent, so that the thread of YARP that
/// sends it, and may close a cut connection, is not disturbed either.
class Output {
 public:
  explicit Output(const std::string& name) {
    port_.setReporter(readers_);
    if (!port_.open(name)) throw_in_use(name);
  }
  ~Output() {
    port_.interrupt();
    port_.close();
  }
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;

  [[nodiscard]] bool has_readers() const { return readers_.count() > 0; }
  /// Returns false, without effect, while the previous message is being sent or nobody reads.
  template <class Fill>
  bool write(yarp::os::Stamp& stamp, const Fill& fill) {
    if (!has_readers() || port_.isWriting()) return false;
    yarp::os::Bottle& message = port_.prepare();
    message.clear();
    fill(message);
    port_.setEnvelope(stamp);
    port_.write();
    return true;
  }

 private:
  OutputCount readers_;  // outlives the port
  yarp::os::BufferedPort<yarp::os::Bottle> port_;
};

template <class Values>
auto numbers(const Values& values) {
  return [&values](yarp::os::Bottle& message) {
    for (const double value : values) message.addFloat64(value);
  };
}

}  // namespace

struct YarpGazePorts::Ports {
  Ports(const std::string& name, Answer given)
      : answer(std::move(given)),
        x(name + "/x:o"),
        q(name + "/q:o"),
        angles_out(name + "/angles:o"),
        events(name + "/events:o") {}
  ~Ports() {
    rpc.interrupt();
    rpc.close();
    for (yarp::os::Port* port : {&xd, &mono, &stereo, &angles_in}) {
      port->interrupt();
      port->close();
    }
  }

  YarpNetwork network{name_server_timeout_s};
  Answer answer;
  Look look_3d{"3D", answer}, look_mono{"mono", answer}, look_stereo{"stereo", answer},
      look_ang{"ang", answer};
  Rpc reader{answer};
  yarp::os::Port xd, mono, stereo, angles_in;
  Output x, q, angles_out, events;
  yarp::os::RpcServer rpc;
  yarp::os::Stamp stamp;
  std::deque<std::string> waiting;  // events
};

YarpGazePorts::YarpGazePorts(const std::string& name, Answer answer)
    : ports_(std::make_unique<Ports>(name, std::move(answer))) {
  Ports& ports = *ports_;
  const auto open = [&](auto& port, const char* end) {
    if (!port.open(name + end)) throw_in_use(name + end);
  };
  ports.xd.setReader(ports.look_3d);
  ports.mono.setReader(ports.look_mono);
  ports.stereo.setReader(ports.look_stereo);
  ports.angles_in.setReader(ports.look_ang);
  ports.rpc.setReader(ports.reader);
  open(ports.xd, "/xd:i");
  open(ports.mono, "/mono:i");
  open(ports.stereo, "/stereo:i");
  open(ports.angles_in, "/angles:i");
  open(ports.rpc, "/rpc");
}

YarpGazePorts::~YarpGazePorts() = default;

void YarpGazePorts::send(const Eigen::Vector3d& fixation_m, const JointVector& position_rad,
                         const Eigen::Vector3d& angles_deg, const std::vector<std::string>& events) {
  Ports& ports = *ports_;
  ports.stamp.update(yarp::os::Time::now());
  const Eigen::VectorXd position_deg = position_rad.head<joint_count>() * deg_per_rad;
  ports.x.write(ports.stamp, numbers(fixation_m));
  ports.q.write(ports.stamp, numbers(position_deg));
  ports.angles_out.write(ports.stamp, numbers(angles_deg));
  ports.waiting.insert(ports.waiting.end(), events.begin(), events.end());
  while (ports.waiting.size() > (ports.events.has_readers() ? most_waiting : 0)) ports.waiting.pop_front();
  if (ports.waiting.empty()) return;
  const bool sent = ports.events.write(ports.stamp, [&](yarp::os::Bottle& message) {
    message.addString(ports.waiting.front());
    message.addFloat64(ports.stamp.getTime());
  });
  if (sent) ports.waiting.pop_front();
}

}  // namespace saccade
