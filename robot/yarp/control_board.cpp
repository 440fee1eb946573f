#include "robot/yarp/control_board.h"

#include <yarp/dev/ControlBoardInterfaces.h>
#include <yarp/dev/DeviceDriver.h>
#include <yarp/dev/IAxisInfo.h>
#include <yarp/dev/IControlLimits.h>
#include <yarp/dev/IControlMode.h>
#include <yarp/dev/IEncodersTimed.h>
#include <yarp/dev/IInteractionMode.h>
#include <yarp/dev/IPositionControl.h>
#include <yarp/dev/IPositionDirect.h>
#include <yarp/dev/IVelocityControl.h>
#include <yarp/dev/IWrapper.h>
#include <yarp/dev/PolyDriver.h>
#include <yarp/os/Property.h>
#include <yarp/os/Time.h>

#include <mutex>
#include <optional>

#include "core/error.h"
#include "core/units.h"
#include "robot/yarp/checked_port.h"
#include "robot/yarp/yarp_network.h"

namespace saccade {
namespace {

constexpr double longest_step_s = 0.2;

int vocab_of(JointMode mode) {
  switch (mode) {
    case JointMode::idle:
      return VOCAB_CM_IDLE;
    case JointMode::position:
      return VOCAB_CM_POSITION;
    case JointMode::direct:
      return VOCAB_CM_POSITION_DIRECT;
    case JointMode::velocity:
      return VOCAB_CM_VELOCITY;
    case JointMode::mixed:
      return VOCAB_CM_MIXED;
  }
  return VOCAB_CM_UNKNOWN;
}

}  // namespace

/// The interfaces that controlBoard_nws_yarp looks for, over a JointBoard. Its methods are called from YARP's threads.
class YarpControlBoard::Device final : public yarp::dev::DeviceDriver,
                                       public yarp::dev::IPositionControl,
                                       public yarp::dev::IPositionDirect,
                                       public yarp::dev::IVelocityControl,
                                       public yarp::dev::IControlMode,
                                       public yarp::dev::IInteractionMode,
                                       public yarp::dev::IEncodersTimed,
                                       public yarp::dev::IControlLimits,
                                       public yarp::dev::IAxisInfo {
 public:
  Device(std::vector<std::string> names, const JointBoard& board)
      : names_(std::move(names)),
        board_(board),
        position_rad_(Eigen::VectorXd::Zero(board.size())),
        velocity_rad_s_(position_rad_),
        acceleration_rad_s2_(position_rad_),
        interaction_(names_.size(), yarp::dev::VOCAB_IM_STIFF),
        stamp_s_(yarp::os::Time::now()) {
    for (int j = 0; j < board.size(); ++j) position_rad_[j] = board.reference_rad(j);
  }

  Eigen::VectorXd step(const Eigen::VectorXd& position_rad, const Eigen::VectorXd& velocity_rad_s,
                       double dt_s) {
    const std::scoped_lock lock(mutex_);
    stamp_s_ = yarp::os::Time::now();
    if (dt_s > 0.0) acceleration_rad_s2_ = (velocity_rad_s - velocity_rad_s_) / dt_s;
    position_rad_ = position_rad;
    velocity_rad_s_ = velocity_rad_s;
    return board_.step(position_rad, dt_s);
  }
  void drive(const Eigen::VectorXd& reference_rad) {
    const std::scoped_lock lock(mutex_);
    for (int j = 0; j < board_.size(); ++j) {
      board_.set_mode(j, JointMode::direct);
      board_.set_reference(j, reference_rad[j]);
    }
  }
  void hold() { stop(); }
  Use use() const {
    const std::scoped_lock lock(mutex_);
    return use_;
  }

  bool getAxes(int* axes) override {
    *axes = board_.size();
    return true;
  }

  // IPositionControl
  bool positionMove(int j, double deg) override { return one(j, deg, &JointBoard::move_to); }
  bool positionMove(const double* deg) override { return all(deg, &JointBoard::move_to); }
  bool positionMove(const int n, const int* joints, const double* deg) override {
    return some(n, joints, deg, &JointBoard::move_to);
  }
  bool relativeMove(int j, double deg) override { return one(j, deg, &Device::move_by); }
  bool relativeMove(const double* deg) override { return all(deg, &Device::move_by); }
  bool relativeMove(const int n, const int* joints, const double* deg) override {
    return some(n, joints, deg, &Device::move_by);
  }
  bool checkMotionDone(int j, bool* done) override { return ask(j, done, &Device::is_done); }
  bool checkMotionDone(bool* done) override {
    const std::scoped_lock lock(mutex_);
    *done = true;
    for (int j = 0; j < board_.size(); ++j) *done = *done && !board_.moving(j);
    return true;
  }
  bool checkMotionDone(const int n, const int* joints, bool* done) override {
    const std::scoped_lock lock(mutex_);
    *done = true;
    for (int i = 0; i < n; ++i) {
      if (!has(joints[i])) return false;
      *done = *done && !board_.moving(joints[i]);
    }
    return true;
  }
  bool setRefSpeed(int j, double deg_s) override { return set(j, deg_s, &JointBoard::set_speed); }
  bool setRefSpeeds(const double* deg_s) override { return set_all(deg_s, &JointBoard::set_speed); }
  bool setRefSpeeds(const int n, const int* joints, const double* deg_s) override {
    return set_some(n, joints, deg_s, &JointBoard::set_speed);
  }
  bool getRefSpeed(int j, double* deg_s) override { return get(j, deg_s, &JointBoard::speed_rad_s); }
  bool getRefSpeeds(double* deg_s) override { return get_all(deg_s, &JointBoard::speed_rad_s); }
  bool getRefSpeeds(const int n, const int* joints, double* deg_s) override {
    return get_some(n, joints, deg_s, &JointBoard::speed_rad_s);
  }
  bool setRefAcceleration(int j, double deg_s2) override {
    return set(j, deg_s2, &JointBoard::set_acceleration);
  }
  bool setRefAccelerations(const double* deg_s2) override {
    return set_all(deg_s2, &JointBoard::set_acceleration);
  }
  bool setRefAccelerations(const int n, const int* joints, const double* deg_s2) override {
    return set_some(n, joints, deg_s2, &JointBoard::set_acceleration);
  }
  bool getRefAcceleration(int j, double* deg_s2) override {
    return get(j, deg_s2, &JointBoard::acceleration_rad_s2);
  }
  bool getRefAccelerations(double* deg_s2) override {
    return get_all(deg_s2, &JointBoard::acceleration_rad_s2);
  }
  bool getRefAccelerations(const int n, const int* joints, double* deg_s2) override {
    return get_some(n, joints, deg_s2, &JointBoard::acceleration_rad_s2);
  }
  bool stop(int j) override {
    const std::scoped_lock lock(mutex_);
    if (!has(j)) return false;
    board_.stop(j);
    return true;
  }
  bool stop() override {
    const std::scoped_lock lock(mutex_);
    for (int j = 0; j < board_.size(); ++j) board_.stop(j);
    return true;
  }
  bool stop(const int n, const int* joints) override {
    bool ok = true;
    for (int i = 0; i < n; ++i) ok = stop(joints[i]) && ok;
    return ok;
  }
  bool getTargetPosition(const int j, double* deg) override { return get(j, deg, &JointBoard::target_rad); }
  bool getTargetPositions(double* deg) override { return get_all(deg, &JointBoard::target_rad); }
  bool getTargetPositions(const int n, const int* joints, double* deg) override {
    return get_some(n, joints, deg, &JointBoard::target_rad);
  }

  // IPositionDirect
  bool setPosition(int j, double deg) override { return one(j, deg, &JointBoard::set_reference); }
  bool setPositions(const int n, const int* joints, const double* deg) override {
    return some(n, joints, deg, &JointBoard::set_reference);
  }
  bool setPositions(const double* deg) override { return all(deg, &JointBoard::set_reference); }
  bool getRefPosition(const int j, double* deg) override { return get(j, deg, &JointBoard::reference_rad); }
  bool getRefPositions(double* deg) override { return get_all(deg, &JointBoard::reference_rad); }
  bool getRefPositions(const int n, const int* joints, double* deg) override {
    return get_some(n, joints, deg, &JointBoard::reference_rad);
  }

  // IVelocityControl
  bool velocityMove(int j, double deg_s) override { return one(j, deg_s, &JointBoard::set_velocity); }
  bool velocityMove(const double* deg_s) override { return all(deg_s, &JointBoard::set_velocity); }
  bool velocityMove(const int n, const int* joints, const double* deg_s) override {
    return some(n, joints, deg_s, &JointBoard::set_velocity);
  }
  bool getRefVelocity(const int j, double* deg_s) override {
    return get(j, deg_s, &JointBoard::velocity_rad_s);
  }
  bool getRefVelocities(double* deg_s) override { return get_all(deg_s, &JointBoard::velocity_rad_s); }
  bool getRefVelocities(const int n, const int* joints, double* deg_s) override {
    return get_some(n, joints, deg_s, &JointBoard::velocity_rad_s);
  }

  // IControlMode
  bool getControlMode(int j, int* mode) override {
    const std::scoped_lock lock(mutex_);
    if (!has(j)) return false;
    *mode = vocab_of(board_.mode(j));
    return true;
  }
  bool getControlModes(int* modes) override {
    bool ok = true;
    for (int j = 0; j < board_.size(); ++j) ok = getControlMode(j, modes + j) && ok;
    return ok;
  }
  bool getControlModes(const int n, const int* joints, int* modes) override {
    bool ok = true;
    for (int i = 0; i < n; ++i) ok = getControlMode(joints[i], modes + i) && ok;
    return ok;
  }
  bool setControlMode(const int j, const int vocab) override {
    const std::scoped_lock lock(mutex_);
    if (!has(j)) return false;
    // iKinGazeCtrl moves the eyes in mixed mode: saccades by positions, all else by velocities.
    for (const JointMode mode :
         {JointMode::idle, JointMode::position, JointMode::direct, JointMode::velocity, JointMode::mixed}) {
      const bool asked = vocab == vocab_of(mode) || (mode == JointMode::idle && vocab == VOCAB_CM_FORCE_IDLE);
      if (!asked) continue;
      if (!board_.set_mode(j, mode)) return false;
      if (mode != JointMode::idle && mode != JointMode::position) ++use_.modes;
      return true;
    }
    return false;
  }
  bool setControlModes(const int n, const int* joints, int* modes) override {
    bool ok = true;
    for (int i = 0; i < n; ++i) ok = setControlMode(joints[i], modes[i]) && ok;
    return ok;
  }
  bool setControlModes(int* modes) override {
    bool ok = true;
    for (int j = 0; j < board_.size(); ++j) ok = setControlMode(j, modes[j]) && ok;
    return ok;
  }

  // IInteractionMode: every joint is stiff.
  bool getInteractionMode(int j, yarp::dev::InteractionModeEnum* mode) override {
    if (!has(j)) return false;
    *mode = interaction_[static_cast<std::size_t>(j)];
    return true;
  }
  bool getInteractionModes(int n, int* joints, yarp::dev::InteractionModeEnum* modes) override {
    bool ok = true;
    for (int i = 0; i < n; ++i) ok = getInteractionMode(joints[i], modes + i) && ok;
    return ok;
  }
  bool getInteractionModes(yarp::dev::InteractionModeEnum* modes) override {
    std::copy(interaction_.begin(), interaction_.end(), modes);
    return true;
  }
  bool setInteractionMode(int j, yarp::dev::InteractionModeEnum mode) override {
    return has(j) && mode == yarp::dev::VOCAB_IM_STIFF;
  }
  bool setInteractionModes(int n, int* joints, yarp::dev::InteractionModeEnum* modes) override {
    bool ok = true;
    for (int i = 0; i < n; ++i) ok = setInteractionMode(joints[i], modes[i]) && ok;
    return ok;
  }
  bool setInteractionModes(yarp::dev::InteractionModeEnum* modes) override {
    bool ok = true;
    for (int j = 0; j < board_.size(); ++j) ok = setInteractionMode(j, modes[j]) && ok;
    return ok;
  }

  // IEncodersTimed
  bool resetEncoder(int) override { return false; }
  bool resetEncoders() override { return false; }
  bool setEncoder(int, double) override { return false; }
  bool setEncoders(const double*) override { return false; }
  bool getEncoder(int j, double* deg) override { return read(j, deg, position_rad_); }
  bool getEncoders(double* deg) override { return read_all(deg, position_rad_); }
  bool getEncoderSpeed(int j, double* deg_s) override { return read(j, deg_s, velocity_rad_s_); }
  bool getEncoderSpeeds(double* deg_s) override { return read_all(deg_s, velocity_rad_s_); }
  bool getEncoderAcceleration(int j, double* deg_s2) override {
    return read(j, deg_s2, acceleration_rad_s2_);
  }
  bool getEncoderAccelerations(double* deg_s2) override { return read_all(deg_s2, acceleration_rad_s2_); }
  bool getEncoderTimed(int j, double* deg, double* stamp_s) override {
    const std::scoped_lock lock(mutex_);
    if (!has(j)) return false;
    *deg = position_rad_[j] / rad_per_deg;
    *stamp_s = reading_s();
    return true;
  }
  bool getEncodersTimed(double* deg, double* stamps_s) override {
    const std::scoped_lock lock(mutex_);
    for (int j = 0; j < board_.size(); ++j) {
      deg[j] = position_rad_[j] / rad_per_deg;
      stamps_s[j] = reading_s();
    }
    return true;
  }

  // IControlLimits
  bool setLimits(int, double, double) override { return false; }
  bool getLimits(int j, double* min_deg, double* max_deg) override {
    if (!has(j)) return false;
    *min_deg = board_.joint(j).min_rad / rad_per_deg;
    *max_deg = board_.joint(j).max_rad / rad_per_deg;
    return true;
  }
  bool setVelLimits(int, double, double) override { return false; }
  bool getVelLimits(int j, double* min_deg_s, double* max_deg_s) override {
    if (!has(j)) return false;
    *min_deg_s = 0.0;
    *max_deg_s = board_.joint(j).max_speed_rad_s / rad_per_deg;
    return true;
  }

  // IAxisInfo
  bool getAxisName(int j, std::string& name) override {
    if (!has(j)) return false;
    name = names_[static_cast<std::size_t>(j)];
    return true;
  }
  bool getJointType(int j, yarp::dev::JointTypeEnum& type) override {
    type = yarp::dev::VOCAB_JOINTTYPE_REVOLUTE;
    return has(j);
  }

 private:
  [[nodiscard]] bool has(int j) const { return j >= 0 && j < board_.size(); }
  /// Time of a reading: between two steps the simulated time stands still, so the position is that of now. A simulation that
  /// hangs has old readings.
  [[nodiscard]] double reading_s() const {
    const double now_s = yarp::os::Time::now();
    return now_s - stamp_s_ < longest_step_s ? now_s : stamp_s_;
  }

  bool move_by(int j, double rad) { return board_.move_to(j, board_.reference_rad(j) + rad); }
  [[nodiscard]] bool is_done(int j) const { return !board_.moving(j); }

  // A command, degrees, by a method of the board or of this device; locked.
  template <class... Args>
  bool call(bool (JointBoard::*method)(Args...), int j, double rad) {
    return (board_.*method)(j, rad);
  }
  template <class... Args>
  bool call(bool (Device::*method)(Args...), int j, double rad) {
    return (this->*method)(j, rad);
  }
  template <class Method>
  bool command(int j, double deg, Method method) {
    const bool taken = has(j) && call(method, j, deg * rad_per_deg);
    ++(taken ? use_.commands : use_.refused);
    return taken;
  }
  template <class Method>
  bool one(int j, double deg, Method method) {
    const std::scoped_lock lock(mutex_);
    return command(j, deg, method);
  }
  template <class Method>
  bool all(const double* deg, Method method) {
    const std::scoped_lock lock(mutex_);
    bool ok = true;
    for (int j = 0; j < board_.size(); ++j) ok = command(j, deg[j], method) && ok;
    return ok;
  }
  template <class Method>
  bool some(int n, const int* joints, const double* deg, Method method) {
    const std::scoped_lock lock(mutex_);
    bool ok = true;
    for (int i = 0; i < n; ++i) ok = command(joints[i], deg[i], method) && ok;
    return ok;
  }
  using Setter = bool (JointBoard::*)(int, double);
  bool set(int j, double deg, Setter method) {
    const std::scoped_lock lock(mutex_);
    return has(j) && (board_.*method)(j, deg * rad_per_deg);
  }
  bool set_all(const double* deg, Setter method) {
    bool ok = true;
    for (int j = 0; j < board_.size(); ++j) ok = set(j, deg[j], method) && ok;
    return ok;
  }
  bool set_some(int n, const int* joints, const double* deg, Setter method) {
    bool ok = true;
    for (int i = 0; i < n; ++i) ok = set(joints[i], deg[i], method) && ok;
    return ok;
  }
  using Getter = double (JointBoard::*)(int) const;
  bool get(int j, double* deg, Getter method) const {
    const std::scoped_lock lock(mutex_);
    if (!has(j)) return false;
    *deg = (board_.*method)(j) / rad_per_deg;
    return true;
  }
  bool get_all(double* deg, Getter method) const {
    bool ok = true;
    for (int j = 0; j < board_.size(); ++j) ok = get(j, deg + j, method) && ok;
    return ok;
  }
  bool get_some(int n, const int* joints, double* deg, Getter method) const {
    bool ok = true;
    for (int i = 0; i < n; ++i) ok = get(joints[i], deg + i, method) && ok;
    return ok;
  }
  template <class T>
  bool ask(int j, T* answer, T (Device::*method)(int) const) const {
    const std::scoped_lock lock(mutex_);
    if (!has(j)) return false;
    *answer = (this->*method)(j);
    return true;
  }
  bool read(int j, double* deg, const Eigen::VectorXd& rad) const {
    const std::scoped_lock lock(mutex_);
    if (!has(j)) return false;
    *deg = rad[j] / rad_per_deg;
    return true;
  }
  bool read_all(double* deg, const Eigen::VectorXd& rad) const {
    const std::scoped_lock lock(mutex_);
    for (int j = 0; j < board_.size(); ++j) deg[j] = rad[j] / rad_per_deg;
    return true;
  }

  YarpNetwork network_{name_server_timeout_s};
  mutable std::mutex mutex_;
  std::vector<std::string> names_;
  JointBoard board_;
  Eigen::VectorXd position_rad_, velocity_rad_s_, acceleration_rad_s2_;
  std::vector<yarp::dev::InteractionModeEnum> interaction_;
  double stamp_s_;
  Use use_;
};

struct YarpControlBoard::Ports {
  yarp::dev::PolyDriver device;   // lends the Device
  yarp::dev::PolyDriver wrapper;  // controlBoard_nws_yarp
  yarp::dev::IWrapper* attached = nullptr;
  std::optional<CheckedPort> requests, commands;

  ~Ports() {
    requests.reset();
    commands.reset();
    if (attached != nullptr) attached->detach();
    wrapper.close();
  }
};

YarpControlBoard::YarpControlBoard(const Config& config, const JointBoard& board)
    : device_(std::make_unique<Device>(config.names, board)), ports_(std::make_unique<Ports>()) {
  SACCADE_CHECK(static_cast<int>(config.names.size()) == board.size());
  yarp::os::Property options;
  options.put("device", yarp::os::Value("controlBoard_nws_yarp"));
  options.put("name", yarp::os::Value(config.part));
  options.put("period", yarp::os::Value(config.state_period_s));
  yarp::dev::IWrapper* wrapper = nullptr;
  if (!ports_->wrapper.open(options) || !ports_->wrapper.view(wrapper)) {
    throw RunError("YARP cannot open the control board " + config.part +
                   ": is the name in use, or YARP's plugin controlBoard_nws_yarp not found "
                   "(YARP_DATA_DIRS)?");
  }
  ports_->device.give(device_.get(), false);
  if (!wrapper->attach(&ports_->device)) throw RunError("YARP cannot attach a device to " + config.part);
  ports_->attached = wrapper;
  ports_->requests.emplace(config.part + "/rpc:i", CheckedPort::Kind::requests);
  ports_->commands.emplace(config.part + "/command:i", CheckedPort::Kind::commands);
}

YarpControlBoard::~YarpControlBoard() = default;

Eigen::VectorXd YarpControlBoard::step(const Eigen::VectorXd& position_rad,
                                       const Eigen::VectorXd& velocity_rad_s, double dt_s) {
  return device_->step(position_rad, velocity_rad_s, dt_s);
}

YarpControlBoard::Use YarpControlBoard::use() const { return device_->use(); }

void YarpControlBoard::drive(const Eigen::VectorXd& reference_rad) { device_->drive(reference_rad); }

void YarpControlBoard::stop() { device_->hold(); }

}  // namespace saccade
