#include "tests/robot/yarp/faults/yarp_trial.h"

#include <unistd.h>
#include <yarp/dev/ControlBoardVocabs.h>
#include <yarp/os/Property.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <iterator>
#include <set>
#include <stdexcept>
#include <utility>

#include "tests/robot/yarp/peers.h"

namespace saccade {
namespace {

constexpr const char* camera_port = "/zynqGrabber/AE:o";
constexpr const char* part = "/icub/head";
constexpr std::uint64_t enough_references = 50;
constexpr int joint_of_others = 1;
constexpr std::int64_t longest_until_rest_ns = 250'000'000;  // from the stop: docs/safety.md

double ms(std::int64_t from_ns, std::int64_t to_ns) { return 1e-6 * static_cast<double>(to_ns - from_ns); }
void sleep_ms(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

/// Whether the fault must not stop the head.
bool is_harmless(YarpFaultKind kind) {
  return kind == YarpFaultKind::strangers || kind == YarpFaultKind::name_server_halted;
}
/// Whether the board cannot see what deploy sends after the fault.
bool hides_the_board(YarpFaultKind kind) {
  return kind == YarpFaultKind::board_halted || kind == YarpFaultKind::board_killed ||
         kind == YarpFaultKind::commands_cut;
}
bool is_of_deploy(YarpFaultKind kind) {
  return kind == YarpFaultKind::deploy_killed || kind == YarpFaultKind::deploy_halted;
}

/// A connection whose message never ends, to a port that reads numbers or events.
class HalfMessage {
 public:
  explicit HalfMessage(const std::string& port) {
    const yarp::os::Contact contact = yarp::os::Network::queryName(port);
    socket_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(static_cast<std::uint16_t>(contact.getPort()));
    const std::string text = "CONNECT /half\r\nd\r\n1.0 2.0 3.";
    if (::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0)
      (void)!::write(socket_, text.data(), text.size());
  }
  HalfMessage(const HalfMessage&) = delete;
  HalfMessage& operator=(const HalfMessage&) = delete;
  ~HalfMessage() { ::close(socket_); }

 private:
  int socket_;
};

}  // namespace

const std::vector<YarpFault>& yarp_faults() {
  using enum YarpFaultKind;
  const std::vector<std::string> silent = {"no packet from the camera"};
  const std::vector<std::string> no_camera = {"lost the connection to the event camera",
                                              "no packet from the camera"};
  const std::vector<std::string> no_joints = {"lost the connection to the head", "no reading of the joints"};
  const std::vector<std::string> no_guard = {"no sign of the guard"};
  static const std::vector<YarpFault> faults = {
      {camera_silent, "camera silent", silent},
      {camera_broken, "camera's messages broken", silent},
      {camera_halted, "camera's program halted", silent},
      {camera_killed, "camera's program killed", no_camera},
      {camera_cut, "camera disconnected", no_camera},
      {state_cut, "joint readings disconnected", no_joints},
      {commands_cut, "references disconnected", no_joints},
      {board_halted, "control board halted", no_joints},
      {board_killed, "control board killed", no_joints},
      {encoder_not_a_number, "encoder not a number", {"is not a number"}},
      {joint_outside, "joint outside its limits", {"outside its limits"}},
      {joint_stuck, "joint stuck", {"has not followed its reference"}},
      {joint_off, "joint switched off", {"was switched off"}},
      {joint_taken, "joint's mode changed", {"no longer follows references"}},
      {strangers, "strangers on every port", {}},
      {name_server_halted, "name server halted", {}},
      {guard_killed, "guard killed", no_guard},
      {guard_halted, "guard halted", no_guard},
      {deploy_killed, "deploy killed", {}},
      {deploy_halted, "deploy halted, then continued", {}},
      {interrupted, "Ctrl-C", {"by a signal"}},
  };
  return faults;
}

Program::Program(const std::vector<std::string>& words, const std::filesystem::path& log) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  std::fflush(nullptr);  // the child has a copy of what is not written yet
  pid_ = ::fork();
  if (pid_ != 0) return;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  (void)!std::freopen(log.c_str(), "w", stdout);
  ::dup2(STDOUT_FILENO, STDERR_FILENO);
  ::close_range(3, ~0U, 0);  // the sockets of the ports here
  (void)!std::freopen("/dev/null", "r", stdin);
  ::execv(arguments[0], arguments.data());
  ::_exit(127);
}

Program::~Program() {
  if (status_) return;
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}

std::optional<int> Program::wait(double timeout_s) {
  std::signal(SIGCHLD,
              SIG_DFL);  // each port of YARP that opens sets a handler that takes the status of every child
  (void)eventually(timeout_s, [this] {
    int status = 0;
    if (!status_ && ::waitpid(pid_, &status, WNOHANG) == pid_)
      status_ = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return status_.has_value();
  });
  return status_;
}

YarpTrials::YarpTrials(std::string saccade, std::string robot)
    : saccade_(std::move(saccade)),
      robot_(std::move(robot)),
      world_(YarpWorld::get()),
      memory_("faults-" + std::to_string(::getpid()), sizeof(RobotFacts)),
      facts_(*static_cast<RobotFacts*>(memory_.data())) {}

std::string YarpTrials::log(const char* name) const {
  std::ifstream stream(world_ / name);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string YarpTrials::stop_line() const {
  const std::string text = log("deploy.txt");
  const auto at = text.find("stopped");
  return at == std::string::npos ? std::string() : text.substr(at, text.find('\n', at) - at);
}

void YarpTrials::start_board() {
  client_.reset();
  const std::string memory = "faults-" + std::to_string(::getpid());
  const auto start = [&] {
    board_ = std::make_unique<Program>(std::vector<std::string>{SACCADE_FAULTY_ROBOT, memory, "board", part},
                                       world_ / "board.txt");
  };
  start();
  yarp::os::Property options;
  options.put("device", yarp::os::Value("remote_controlboard"));
  options.put("remote", yarp::os::Value(part));
  options.put("local", yarp::os::Value("/observer"));
  const bool open = eventually(20.0, [&] {
    // YARP 3.12 can end a program that looks up names in several threads at once.
    if (board_->wait(0.0)) start();
    client_ = std::make_unique<yarp::dev::PolyDriver>();
    return client_->open(options) && client_->view(modes_);
  });
  if (!open) throw std::runtime_error("no control board\n" + log("board.txt"));
}

void YarpTrials::start_what_is_missing() {
  facts_.camera = RobotFacts::sends;
  facts_.joints = RobotFacts::are_read;
  if (!camera_) {
    const std::string memory = "faults-" + std::to_string(::getpid());
    camera_ = std::make_unique<Program>(
        std::vector<std::string>{SACCADE_FAULTY_ROBOT, memory, "camera", camera_port}, world_ / "camera.txt");
    if (!eventually(10.0, [] { return yarp::os::Network::exists(camera_port, true); }))
      throw std::runtime_error("no camera");
  }
  if (!board_) {
    start_board();
    guard_.reset();
  }
  if (guard_) return;
  guard_ =
      std::make_unique<Program>(std::vector<std::string>{saccade_, "guard", robot_}, world_ / "guard.txt");
  const auto connected = [this] {
    return log("guard.txt").find("connected to the head") != std::string::npos;
  };
  if (!eventually(20.0, connected)) throw std::runtime_error("no guard\n" + log("guard.txt"));
}

std::vector<int> YarpTrials::modes() {
  std::vector<int> modes(6);
  return modes_->getControlModes(modes.data()) ? modes : std::vector<int>{};
}

void YarpTrials::talk_as_a_stranger() const {
  const HalfMessage state("/saccade/head/state:i");
  const HalfMessage events("/saccade/AE:i");
  yarp::os::Port stranger;
  stranger.open("/stranger");
  for (const char* port : {"/saccade/head/state:i", "/saccade/AE:i"})
    yarp::os::Network::connect("/stranger", port);
  yarp::os::Bottle numbers("99.0 99.0 99.0 99.0 99.0 99.0");
  Grabber camera("/stranger/AE:o", PacketFormat::packet);
  yarp::os::Network::connect("/stranger/AE:o", "/saccade/AE:i");
  EventPacket packet{1000, {{0, 77}}};
  for (int i = 0; i < 300; ++i) {
    stranger.write(numbers);
    camera.send(packet);
    sleep_ms(1);
  }
}

std::int64_t YarpTrials::inject(YarpFaultKind kind, Program& deploy) {
  const std::int64_t fault_ns = machine_ns();
  switch (kind) {
    case YarpFaultKind::camera_silent:
      facts_.camera = RobotFacts::is_silent;
      break;
    case YarpFaultKind::camera_broken:
      facts_.camera = RobotFacts::sends_broken_messages;
      break;
    case YarpFaultKind::camera_halted:
      camera_->send_signal(SIGSTOP);
      break;
    case YarpFaultKind::camera_killed:
      camera_->send_signal(SIGKILL);
      break;
    case YarpFaultKind::camera_cut:
      yarp::os::Network::disconnect(camera_port, "/saccade/AE:i");
      break;
    case YarpFaultKind::state_cut:
      yarp::os::Network::disconnect(std::string(part) + "/state:o", "/saccade/head/state:i");
      break;
    case YarpFaultKind::commands_cut:
      yarp::os::Network::disconnect("/saccade/head/command:o", std::string(part) + "/command:i");
      break;
    case YarpFaultKind::board_halted:
      board_->send_signal(SIGSTOP);
      break;
    case YarpFaultKind::board_killed:
      board_->send_signal(SIGKILL);
      break;
    case YarpFaultKind::encoder_not_a_number:
      facts_.joints = RobotFacts::one_is_not_a_number;
      break;
    case YarpFaultKind::joint_outside:
      facts_.joints = RobotFacts::one_is_outside;
      break;
    case YarpFaultKind::joint_stuck:
      facts_.joints = RobotFacts::one_is_stuck;
      break;
    case YarpFaultKind::joint_off:
      modes_->setControlMode(joint_of_others, VOCAB_CM_IDLE);
      break;
    case YarpFaultKind::joint_taken:
      modes_->setControlMode(joint_of_others, VOCAB_CM_VELOCITY);
      break;
    case YarpFaultKind::strangers:
      talk_as_a_stranger();
      break;
    case YarpFaultKind::name_server_halted:
      world_.signal_name_server(SIGSTOP);
      sleep_ms(1500);
      world_.signal_name_server(SIGCONT);
      break;
    case YarpFaultKind::guard_killed:
      guard_->send_signal(SIGKILL);
      break;
    case YarpFaultKind::guard_halted:
      guard_->send_signal(SIGSTOP);
      break;
    case YarpFaultKind::deploy_killed:
      deploy.send_signal(SIGKILL);
      break;
    case YarpFaultKind::deploy_halted:
      deploy.send_signal(SIGSTOP);
      break;
    case YarpFaultKind::interrupted:
      deploy.send_signal(SIGINT);
      break;
  }
  return fault_ns;
}

YarpTrialResult YarpTrials::run(const YarpFault& fault, double wait_s) {
  using enum YarpFaultKind;
  YarpTrialResult result;
  start_what_is_missing();
  const std::uint64_t before = facts_.references;
  Program deploy(
      {saccade_, "deploy", robot_, "--activate", "--force", "--out", (world_ / "run").string(), "--set",
       "deploy.guard=required", "--set", "deploy.ramp_in_s=0.1", "--set", "gaze.start_s=0"},
      world_ / "deploy.txt");
  const auto problem = [&](const std::string& text) {
    if (result.problem.empty()) result.problem = text + "\n" + log("deploy.txt");
  };
  const auto moves = [&] { return facts_.references > before + enough_references; };
  (void)eventually(30.0, [&] { return moves() || deploy.wait(0.0); });
  if (moves()) std::this_thread::sleep_for(std::chrono::duration<double>(wait_s));
  if (const auto status = deploy.wait(0.0)) {
    result.stopped_before = true;
    const std::string text = log("deploy.txt");
    const bool refused = text.find("saccade: not ready") != std::string::npos;  // a check, before it moved
    if (*status != 1 || (!refused && text.find("stopped: ") == std::string::npos))
      problem("deploy ended with status " + std::to_string(*status));
    (void)eventually(1.0, [this] { return modes() == std::vector<int>(6, VOCAB_CM_POSITION); });
    return result;
  }
  if (!moves()) {
    problem("deploy does not move the head");
    return result;
  }
  const std::int64_t fault_ns = inject(fault.kind, deploy);

  if (is_harmless(fault.kind)) {
    sleep_ms(100);
    if (const std::string stop = stop_line(); !stop.empty())
      problem("the head was " + stop);
    else if (deploy.wait(0.0))
      problem("deploy ended");
    deploy.send_signal(SIGINT);
  }
  if (is_of_deploy(fault.kind)) {
    if (!eventually(1.0, [&] { return facts_.held_ns > fault_ns + 20'000'000; }))
      problem("no stop by the guard; deploy: " + stop_line());
    sleep_ms(200);
    result.stop_ms = ms(fault_ns, facts_.held_ns);
    if (fault.kind == deploy_halted) deploy.send_signal(SIGCONT);
  }
  const auto status = deploy.wait(10.0);
  const std::uint64_t references = facts_.references;
  if (!status) problem("deploy does not end");
  const int expected = is_harmless(fault.kind) || fault.kind == interrupted ? 0 : 1;
  if (status && fault.kind != deploy_killed && *status != expected)
    problem("deploy ended with status " + std::to_string(*status));

  const std::string text = log("deploy.txt");
  const bool right =
      fault.causes.empty() || std::ranges::any_of(fault.causes, [&](const std::string& cause) {
        return text.find("stopped: " + cause) != std::string::npos ||
               (text.find("stopped: ") != std::string::npos && text.find(cause) != std::string::npos);
      });
  if (!right) problem("another cause in the log");
  if (hides_the_board(fault.kind)) {
    const auto at = text.find("stop command after ");
    if (at != std::string::npos) result.stop_ms = std::strtod(text.c_str() + at + 19, nullptr);
  } else if (!is_harmless(fault.kind)) {
    // A head at rest gets no other reference than the one before.
    if (!is_of_deploy(fault.kind) && facts_.referenced_ns > fault_ns)
      result.stop_ms = ms(fault_ns, facts_.referenced_ns);
    sleep_ms(150);
    const std::int64_t rest_ns =
        fault_ns + std::llround(1e6 * result.stop_ms.value_or(0.0)) + longest_until_rest_ns;
    while (machine_ns() < rest_ns + 100'000'000) sleep_ms(1);
    if (facts_.moved_ns > fault_ns) result.rest_ms = ms(fault_ns, facts_.moved_ns);
    if (facts_.references != references) problem("a reference after the end");
    if (facts_.moved_ns > rest_ns) problem("a joint still moves");
  }

  const bool board_is_gone = fault.kind == board_halted || fault.kind == board_killed;
  if (!board_is_gone) {
    std::vector<int> wanted(6, VOCAB_CM_POSITION);
    if (fault.kind == joint_off) wanted[joint_of_others] = VOCAB_CM_IDLE;
    if (fault.kind == joint_taken) wanted[joint_of_others] = VOCAB_CM_VELOCITY;
    if (!eventually(1.0, [&] { return modes() == wanted; })) problem("joints are not released");
  }
  if (fault.kind == camera_halted || fault.kind == camera_killed || fault.kind == camera_broken)
    camera_.reset();
  if (fault.kind == guard_killed || fault.kind == guard_halted) guard_.reset();
  if (board_is_gone || (fault.kind >= encoder_not_a_number && fault.kind <= joint_taken)) board_.reset();
  return result;
}

}  // namespace saccade
