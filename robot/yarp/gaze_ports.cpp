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

#include <array>

#include "core/error.h"
#include "core/units.h"
#include "robot/yarp/checked_port.h"
#include "robot/yarp/yarp_network.h"

namespace saccade::inline v0_1 {
namespace {

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

template <class Values>
void write(yarp::os::BufferedPort<yarp::os::Bottle>& port, const Values& values, yarp::os::Stamp& stamp) {
  if (port.getOutputCount() == 0) return;
  yarp::os::Bottle& message = port.prepare();
  message.clear();
  for (const double value : values) message.addFloat64(value);
  port.setEnvelope(stamp);
  port.write();
}

}  // namespace

struct YarpGazePorts::Ports {
  using Port = yarp::os::BufferedPort<yarp::os::Bottle>;

  explicit Ports(Answer given) : answer(std::move(given)) {}
  ~Ports() {
    rpc.interrupt();
    rpc.close();
    for (yarp::os::Port* port : {&xd, &mono, &stereo, &angles_in}) {
      port->interrupt();
      port->close();
    }
    for (Port* port : {&x, &q, &angles_out, &events}) {
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
  Port x, q, angles_out, events;
  yarp::os::RpcServer rpc;
  yarp::os::Stamp stamp;
};

YarpGazePorts::YarpGazePorts(const std::string& name, Answer answer)
    : ports_(std::make_unique<Ports>(std::move(answer))) {
  Ports& ports = *ports_;
  const auto open = [&](auto& port, const char* end) {
    if (!port.open(name + end)) {
      throw RunError("YARP cannot open the port " + name + end + ": is the name in use?");
    }
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
  open(ports.x, "/x:o");
  open(ports.q, "/q:o");
  open(ports.angles_out, "/angles:o");
  open(ports.events, "/events:o");
  open(ports.rpc, "/rpc");
}

YarpGazePorts::~YarpGazePorts() = default;

void YarpGazePorts::send(const Eigen::Vector3d& fixation_m, const JointVector& position_rad,
                         const Eigen::Vector3d& angles_deg, const std::vector<std::string>& events) {
  Ports& ports = *ports_;
  ports.stamp.update(yarp::os::Time::now());
  write(ports.x, fixation_m, ports.stamp);
  write(ports.q, Eigen::VectorXd(position_rad.head<joint_count>() * deg_per_rad), ports.stamp);
  write(ports.angles_out, angles_deg, ports.stamp);
  for (const std::string& event : events) {
    if (ports.events.getOutputCount() == 0) break;
    yarp::os::Bottle& message = ports.events.prepare();
    message.clear();
    message.addString(event);
    message.addFloat64(ports.stamp.getTime());
    ports.events.setEnvelope(ports.stamp);
    ports.events.writeStrict();
  }
}

}  // namespace saccade::inline v0_1
