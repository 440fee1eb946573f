#pragma once

#include <yarp/conf/version.h>
#include <yarp/dev/IWrapper.h>
#include <yarp/dev/PolyDriver.h>
#include <yarp/os/Bottle.h>
#include <yarp/os/BufferedPort.h>
#include <yarp/os/ConnectionReader.h>
#include <yarp/os/ConnectionWriter.h>
#include <yarp/os/Port.h>
#include <yarp/os/PortReader.h>
#include <yarp/os/PortWriter.h>
#include <yarp/os/Property.h>
#include <yarp/os/RpcServer.h>
#include <yarp/os/Stamp.h>

#include <atomic>
#include <chrono>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "recording/address_event.h"
#include "robot/event_packet.h"

namespace saccade {

/// What others have on a robot's network, for tests: a camera's event port.
class Grabber {
 public:
  Grabber(const std::string& name, PacketFormat format) : format_(format) { port_.open(name); }

  [[nodiscard]] int readers() { return port_.getOutputCount(); }
  /// `sent_s` is the envelope's time; none where it is negative.
  void send(const EventPacket& packet, double sent_s = -1.0) {
    write_packet(packet, format_, message_.bytes);
    yarp::os::Stamp stamp(number_++, sent_s);
    if (sent_s >= 0.0) port_.setEnvelope(stamp);
    port_.write(message_);
  }
  yarp::os::Port& port() { return port_; }

 private:
  struct Message final : yarp::os::PortWriter {
    std::vector<std::byte> bytes;
    bool write(yarp::os::ConnectionWriter& writer) const override {
      writer.appendBlock(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      return true;
    }
  };

  PacketFormat format_;
  yarp::os::Port port_;
  Message message_;
  int number_ = 0;
};

/// The n-th event of a camera that counts: every pixel and polarity in turn.
inline Event counted_event(std::int64_t n) {
  return {0, static_cast<std::uint16_t>(n % 128), static_cast<std::uint16_t>(n / 128 % 128),
          (n + n / 16384) % 2 == 0, 0};
}

/// A camera that sends 5 counted events every millisecond, as long as it lives.
class CountingGrabber {
 public:
  explicit CountingGrabber(const std::string& name)
      : grabber_(name, PacketFormat::packet), thread_([this] { run(); }) {}
  ~CountingGrabber() {
    ending_ = true;
    thread_.join();
  }

 private:
  void run() {
    const auto start = std::chrono::steady_clock::now();
    std::int64_t n = 0;
    for (int tick = 1; !ending_; ++tick) {
      std::this_thread::sleep_until(start + std::chrono::milliseconds(tick));
      EventPacket packet{1000, {}};
      for (int i = 0; i < 5; ++i)
        packet.events.push_back({0, encode_address(counted_event(n++), AddressCodec::ev2)});
      grabber_.send(packet, 5000.0 + 1e-3 * tick);
    }
  }

  std::atomic<bool> ending_ = false;
  Grabber grabber_;
  std::thread thread_;
};

/// A gaze controller with iKinGazeCtrl's ports that remembers what it was told, and streams joints that grow by 1 deg a
/// second, the i-th from i deg on.
class GazeController : private yarp::os::PortReader {
 public:
  explicit GazeController(const std::string& name) : targets_reader_(*this) {
    targets_.setReader(targets_reader_);
    requests_.setReader(*this);
    targets_.open(name + "/xd:i");
    requests_.open(name + "/rpc");
    joints_.open(name + "/q:o");
    thread_ = std::thread([this] { run(); });
  }
  ~GazeController() override {
    ending_ = true;
    thread_.join();
    targets_.close();
    requests_.close();
    joints_.close();
  }

  struct Target {
    std::chrono::steady_clock::time_point came;
    double x, y, z;
  };
  [[nodiscard]] std::vector<Target> targets() const {
    const std::lock_guard lock(mutex_);
    return came_;
  }
  [[nodiscard]] std::vector<std::string> requests() const {
    const std::lock_guard lock(mutex_);
    return asked_;
  }
  void refuse(std::string request) {
    const std::lock_guard lock(mutex_);
    refused_ = std::move(request);
  }

 private:
  struct TargetsReader final : yarp::os::PortReader {
    explicit TargetsReader(GazeController& o) : owner(o) {}
    bool read(yarp::os::ConnectionReader& reader) override {
      yarp::os::Bottle message;
      if (!message.read(reader)) return false;
      const std::lock_guard lock(owner.mutex_);
      owner.came_.push_back({std::chrono::steady_clock::now(), message.get(0).asFloat64(),
                             message.get(1).asFloat64(), message.get(2).asFloat64()});
      return true;
    }
    GazeController& owner;
  };

  bool read(yarp::os::ConnectionReader& reader) override {
    yarp::os::Bottle request;
    if (!request.read(reader)) return false;
    std::string reply = "[ack]";
    {
      const std::lock_guard lock(mutex_);
      asked_.push_back(request.toString());
      if (!refused_.empty() && asked_.back().starts_with(refused_)) reply = "[nack]";
      if (reply == "[ack]" && asked_.back() == "stor") reply += " 7";
      if (reply == "[ack]" && asked_.back() == "status") reply += " running";
    }
    if (yarp::os::ConnectionWriter* writer = reader.getWriter()) yarp::os::Bottle(reply).write(*writer);
    return true;
  }

  void run() {
    const auto start = std::chrono::steady_clock::now();
    for (int tick = 1; !ending_; ++tick) {
      std::this_thread::sleep_until(start + std::chrono::milliseconds(10 * tick));
      yarp::os::Bottle joints;
      for (int i = 0; i < 9; ++i) joints.addFloat64(i + 0.01 * tick);
      yarp::os::Stamp stamp(tick, 900.0 + 0.01 * tick);
      joints_.setEnvelope(stamp);
      joints_.write(joints);
    }
  }

  std::atomic<bool> ending_ = false;
  mutable std::mutex mutex_;
  std::vector<Target> came_;
  std::vector<std::string> asked_;
  std::string refused_;
  TargetsReader targets_reader_;
  yarp::os::Port targets_;
  yarp::os::RpcServer requests_;
  yarp::os::Port joints_;
  std::thread thread_;
};

/// Lowest and highest positions of the tests' head.
inline constexpr const char* robot_limits_deg[2] = {"-29 -19 -44 -29 -29 1", "16 19 44 29 29 49"};

/// YARP's motion control device of six joints, which obeys at once, served as a control board.
class ServedBoard {
 public:
  /// `limits_deg`: the lowest and the highest positions, six numbers each.
  ServedBoard(const std::string& part, const char* const (&limits_deg)[2]) {
    const std::string six = "100 100 100 100 100 100";
    std::string text = "(device fakeMotionControl) (GENERAL (Joints 6)) (LIMITS";
    for (const char* name : {"OverloadCurrents", "MotorNominalCurrents", "MotorPeakCurrents", "RotorMax",
                             "JntVelocityMax", "RotorMin", "MotorPwmLimit"}) {
      text += std::string(" (") + name + " " + six + ")";
    }
    yarp::os::Property motors;
    const bool flat = YARP_VERSION_MINOR < 10;  // which lists the device reads
    const auto list = [&](const char* numbers) { return flat ? numbers : "(" + std::string(numbers) + ")"; };
    motors.fromString(text + " (Min " + list(limits_deg[0]) + ") (Max " + list(limits_deg[1]) + "))");
    yarp::os::Property ports;
    ports.fromString("(device controlBoard_nws_yarp) (period 0.01) (name " + part + ")");
    yarp::dev::IWrapper* wrapper = nullptr;
    open_ = motors_.open(motors) && ports_.open(ports) && ports_.view(wrapper) && wrapper->attach(&motors_);
  }
  [[nodiscard]] bool is_open() const { return open_; }

 private:
  yarp::dev::PolyDriver motors_;
  yarp::dev::PolyDriver ports_;
  bool open_ = false;
};

}  // namespace saccade
