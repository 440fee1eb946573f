#include "sim/world.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "core/error.h"
#include "core/units.h"
#include "sim/model_file.h"

namespace saccade {
namespace {

constexpr std::int64_t settling_us = 500'000;

std::string read_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (!file || !(text << file.rdbuf())) throw InputError(path.string(), "", "a readable MJCF file");
  return text.str();
}

/// The root body as a mocap body, which place_objects() turns.
std::string with_moving_base(std::string mjcf) {
  const std::string root = "<body name=\"root\"";
  const std::size_t at = mjcf.find(root);
  return at == std::string::npos ? mjcf : mjcf.insert(at + root.size(), " mocap=\"true\"");
}

MjModelPtr load_model(const std::filesystem::path& models, const HeadModel& head, const std::string& hand,
                      const std::string& extra_mjcf, bool base_moves) {
  // MuJoCo writes no log file: warnings are counted in mjData, and step() reports them as errors.
  mju_user_warning = [](const char*) {};

  MjVfsPtr vfs(new mjVFS);
  mj_defaultVFS(vfs.get());
  const auto add = [&vfs](const std::string& name, const std::string& text) {
    if (!add_to_vfs(vfs.get(), name, text)) throw RunError("MuJoCo rejects the model file " + name);
  };
  const std::string head_text = head_mjcf(head, models);
  if (!head.mjcf.empty()) static_cast<void>(compile_mjcf_text(head_text, head.mjcf, "a valid MJCF model"));
  add("head.xml", base_moves ? with_moving_base(head_text) : head_text);
  add("ball_in_hand.xml", read_text(models / "ball_in_hand.xml"));
  const std::string includes = "<include file=\"head.xml\"/><include file=\"ball_in_hand.xml\"/>";
  add("hand.xml", read_text(models / hand));  // ball_in_hand.xml includes it
  add("world.xml", "<mujoco model=\"saccade\">" + includes + extra_mjcf + "</mujoco>");

  char error[1000] = "";
  MjModelPtr model(mj_loadXML("world.xml", vfs.get(), error, sizeof error));
  if (!model) throw RunError(std::string("MuJoCo cannot load the world: ") + error);
  return model;
}

/// Throws InputError for every joint that is outside its limits by more than rounding.
JointVector start_pose_rad(const WorldConfig& config, const JointLimits& limits) {
  const HeadModel& head = *limits.head;
  std::vector<Problem> problems;
  for (std::size_t j = 0; j < head.joints.size(); ++j) {
    const double min_deg = limits.min_rad[head.joints[j].slot] / rad_per_deg;
    const double max_deg = limits.max_rad[head.joints[j].slot] / rad_per_deg;
    const double pose_deg = config.initial_pose_deg[j];
    if (pose_deg >= min_deg - 1e-9 && pose_deg <= max_deg + 1e-9) continue;
    problems.push_back({"world.initial_pose_deg", head.joints[j].name + " " + text_of(pose_deg),
                        expectation_of({min_deg, max_deg}, "an angle within the joint's limits")});
  }
  if (!problems.empty()) throw InputError(problems);
  return initial_pose_rad(config, head).cwiseMax(limits.min_rad).cwiseMin(limits.max_rad);
}

BodyShape ball_shape(const BallConfig& ball) {
  return {"", "<geom type=\"sphere\" size=\"" + text_of(0.5 * ball.diameter_m) + "\"/>"};
}

int find(const mjModel& model, mjtObj type, const std::string& name) {
  const int id = mj_name2id(&model, type, name.c_str());
  if (id < 0) throw RunError("the model has no " + std::string(mju_type2Str(type)) + " named " + name);
  return id;
}

}  // namespace

void describe(FieldVisitor& v, WorldConfig& c) {
  v.text("target", c.target,
         "what the head is to look at and truth is about: ball, or the name of an object");
  if (v.fills_defaults() && c.target != "ball") c.ball.present = false;
  v.section("ball", c.ball, "the ball and the hand that holds it");
  v.named_sections("objects", c.objects, "other moving objects, by name", "a moving object");
  const bool known =
      c.target == "ball" || std::any_of(c.objects.begin(), c.objects.end(),
                                        [&](const auto& object) { return object.first == c.target; });
  v.require(known, "target", c.target, "ball, or the name of an object of the section objects");
  v.optional_section("board", c.board, "a board with dots, for calibration");
  const auto head = valid_head(c.head);
  v.numbers(
      "initial_pose_deg", std::span(c.initial_pose_deg.data(), head->joints.size()), {-180.0, 180.0},
      "joint positions at the start; of the iCub torso pitch, roll, yaw, neck pitch, roll, yaw, eyes tilt, "
      "version, vergence");
  if (v.fills_defaults() && c.head.model == HeadKind::described) {
    c.plant.encoders.quantisation_deg = c.head.description.encoder_step_deg;
    c.plant.command_delay_ms = c.head.description.command_delay_ms;
  }
  v.section("plant", c.plant, "differences between the simulated head and the model that gaze uses");
  v.optional_section("torso", c.torso, "a motion of the torso's joints that gaze does not command");
  v.optional_section("base", c.base, "a rotation of the whole robot about the root");
  v.optional_section("imu", c.imu, "an inertial measurement unit in the head");
  const bool has_cad = c.head.model == HeadKind::icub && (c.head.version == "2" || c.head.version == "2.8");
  v.require(c.plant.axes == NeckAxes::dh || has_cad, "plant.axes", std::string(word_of(c.plant.axes)),
            "dh: the CAD's axes are those of the iCub's versions 2 and 2.8");
}

JointVector initial_pose_rad(const WorldConfig& config, const HeadModel& head) {
  JointVector pose_rad = JointVector::Zero();
  for (std::size_t j = 0; j < head.joints.size(); ++j) {
    pose_rad[head.joints[j].slot] = config.initial_pose_deg[j] * rad_per_deg;
  }
  return pose_rad;
}

World::World(const WorldConfig& config, const std::string& lab_mjcf, std::uint64_t seed,
             const std::filesystem::path& models)
    : trajectory_(check_config("world", config).ball.trajectory, seed, ball_shape(config.ball),
                  "ball.trajectory"),
      ball_radius_m_(0.5 * config.ball.diameter_m),
      has_ball_(config.ball.present),
      rolls_(config.ball.rolls),
      head_(head_model(config.head)),
      coupling_(*head_),
      board_(config.board),
      command_delay_us_(1000 * config.plant.command_delay_ms) {
  const std::vector<ModelParts> files = load_object_files(config.objects);
  model_ = load_model(models, *head_, hand_file(config.ball),
                      lab_mjcf + pattern_mjcf(config.ball) + objects_mjcf(config.objects, files) +
                          (board_ ? board_mjcf(*board_) : std::string()),
                      config.base.has_value());
  data_.reset(mj_makeData(model_.get()));
  if (!data_) throw RunError("MuJoCo has no memory for the world");
  find_parts();
  if (config.torso) torso_motion_.emplace(*config.torso);
  if (config.base) {
    base_motion_.emplace(*config.base);
    base_mocap_ = model_->body_mocapid[find(*model_, mjOBJ_BODY, "root")];
  }
  set_up_ball(*model_, config.ball);
  set_up_drives(config.plant);
  for (const ModelParts& file : files) paint_textures(file, *model_);
  objects_.emplace(config.objects, files, seed, *model_);
  for (std::size_t i = 0; i < config.objects.size(); ++i) {
    if (config.objects[i].first == config.target) target_ = i;
  }
  if (board_) {
    board_mocap_ = model_->body_mocapid[find(*model_, mjOBJ_BODY, "board")];
    paint_board(*model_, *board_);
  }

  const JointVector plant_rad = coupling_.motors_from_joints(start_pose_rad(config, limits_));
  for (std::size_t j = 0; j < motors_.size(); ++j) {
    data_->qpos[model_->jnt_qposadr[motors_[j].joint]] = plant_rad[static_cast<Eigen::Index>(j)];
    data_->ctrl[motors_[j].actuator] = plant_rad[static_cast<Eigen::Index>(j)];
  }
  joint_rad_ = plant_rad;
  start_rad_ = initial_pose_rad(config, *head_).cwiseMax(limits_.min_rad).cwiseMin(limits_.max_rad);
  place_objects(0, *data_);
  mj_step1(model_.get(), data_.get());
  for (std::int64_t t_us = 0; t_us < settling_us; t_us += tick_us) advance();
  data_->time = 0.0;
  save_last_state();
  encoders_.emplace(config.plant.encoders, seed, motors().rad);
  if (joint_data_) show(0, *joint_data_);
  if (config.imu) {
    head_body_ = find(*model_, mjOBJ_BODY, "head");
    imu_.emplace(*config.imu, seed, world_from_imu());
  }
}

void World::find_parts() {
  const mjModel& m = *model_;
  motors_ = find_motors(*head_, m, "the model of " + head_->name);
  limits_.head = head_;
  for (const HeadJoint& joint : head_->joints) {
    limits_.min_rad[joint.slot] = joint.min_rad;
    limits_.max_rad[joint.slot] = joint.max_rad;
    limits_.max_speed_rad_s[joint.slot] = joint.max_speed_rad_s;
  }
  ball_mocap_ = m.body_mocapid[find(m, mjOBJ_BODY, "ball_hand")];
  left_eye_ = find(m, mjOBJ_CAMERA, "left_eye");
  right_eye_ = head_->chain.eyes > 1 ? find(m, mjOBJ_CAMERA, "right_eye") : left_eye_;
}

void World::set_up_drives(const PlantConfig& config) {
  mjModel& m = *model_;
  if (config.axes == NeckAxes::cad) {
    move_neck_axes_to_cad(m);
    mj_setConst(&m, data_.get());
    mj_resetData(&m, data_.get());
  }
  for (std::size_t j = 0; j < motors_.size(); ++j) {
    const HeadMotor& motor = motors_[j];
    if (motor.role == JointRole::torso) continue;
    const DriveConfig& drive = motor.role == JointRole::neck ? config.neck : config.eyes;
    const double largest_nm = m.actuator_forcerange[2 * motor.actuator + 1];
    if (drive.friction_share > 0.0) set_friction(m, motor.joint, drive.friction_share * largest_nm);
    backlash_half_width_rad_[static_cast<Eigen::Index>(j)] = 0.5 * drive.backlash_deg * rad_per_deg;
  }
  if (backlash_half_width_rad_.isZero(0.0)) return;
  joint_data_.reset(mj_makeData(&m));
  if (!joint_data_) throw RunError("MuJoCo has no memory for the joints behind their backlash");
}

int World::target_body() const {
  const int mocap = target_ ? objects_->mocap(*target_) : ball_mocap_;
  int body = 0;
  while (model_->body_mocapid[body] != mocap) ++body;
  return body;
}

std::optional<double> World::target_radius_m() const {
  return target_ ? objects_->sphere_radius_m(*target_) : ball_radius_m_;
}

std::int64_t World::first_motion_us() const {
  return target_ ? objects_->trajectory(*target_).first_motion_us() : trajectory_.first_motion_us();
}

std::vector<std::uint8_t> World::scene_objects() const {
  const mjModel& m = *model_;
  const auto name_of = [&m](mjtObj type, int id) {
    const char* name = mj_id2name(&m, type, id);
    return std::string_view(name != nullptr ? name : "");
  };
  const std::string target_bodies = target_ ? object_body_prefix(*target_) : "";
  std::vector<std::uint8_t> objects;
  for (int geom = 0; geom < m.ngeom; ++geom) {
    const std::string_view name = name_of(mjOBJ_GEOM, geom);
    const std::string_view body = name_of(mjOBJ_BODY, m.geom_bodyid[geom]);
    SceneObject object = SceneObject::background;
    if (name == "ball") object = target_ ? SceneObject::distractor : SceneObject::ball;
    if (body == "hand") object = SceneObject::hand;
    if (body == "arm") object = SceneObject::arm;
    if (name.starts_with("distractor") || body.starts_with("distractor")) object = SceneObject::distractor;
    if (target_ && body.starts_with(target_bodies)) object = SceneObject::ball;
    objects.push_back(static_cast<std::uint8_t>(object));
  }
  return objects;
}

void World::step() {
  apply_due_commands();
  if (torso_motion_) move_torso();
  save_last_state();
  now_us_ += tick_us;
  place_objects(now_us_, *data_);
  advance();
  const Motors now = motors();
  encoders_->read(now.rad, now.rad_s);
  if (joint_data_) show(now_us_, *joint_data_);
  if (imu_) imu_->step(now_us_, world_from_imu());
}

/// Pitch, roll and yaw are the first three slots.
void World::move_torso() {
  JointVector wanted_rad = start_rad_;
  wanted_rad.head<torso_slots>() += torso_motion_->angles_rad(now_us_);
  const JointVector motor_rad =
      coupling_.motors_from_joints(wanted_rad.cwiseMax(limits_.min_rad).cwiseMin(limits_.max_rad));
  for (std::size_t j = 0; j < motors_.size(); ++j) {
    if (motors_[j].role == JointRole::torso)
      data_->ctrl[motors_[j].actuator] = motor_rad[static_cast<Eigen::Index>(j)];
  }
}

Eigen::Isometry3d World::world_from_imu() const {
  using RowMajor = Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::Map<const RowMajor>(data().xmat + 9 * head_body_);
  pose.translation() = Eigen::Map<const Eigen::Vector3d>(data().xpos + 3 * head_body_);
  return pose;
}

void World::apply_due_commands() {
  for (; !commands_.empty() && commands_.front().due_us <= now_us_; commands_.pop_front()) {
    for (std::size_t j = 0; j < motors_.size(); ++j) {
      if (motors_[j].role == JointRole::torso) continue;
      data_->ctrl[motors_[j].actuator] = commands_.front().motor_rad[static_cast<Eigen::Index>(j)];
    }
  }
}

void World::save_last_state() {
  last_joint_rad_ = joint_rad_;
  last_qpos_.assign(data_->qpos, data_->qpos + model_->nq);
  last_qvel_.assign(data_->qvel, data_->qvel + model_->nv);
}

/// The second half of a MuJoCo step and the first half of the next, so that everything derived from the positions is up
/// to date in between.
void World::advance() {
  mj_step2(model_.get(), data_.get());
  mj_step1(model_.get(), data_.get());
  for (int i = 0; i < mjNWARNING; ++i) {
    const mjWarningStat& warning = data_->warning[i];
    if (warning.number > 0) {
      throw RunError("the simulation failed at " + std::to_string(now_us_) +
                     " us: " + mju_warningText(i, warning.lastinfo));
    }
  }
  const JointVector motor_rad = motors().rad;
  for (int j = 0; j < joint_slots; ++j) {
    joint_rad_[j] = joint_behind_backlash(motor_rad[j], joint_rad_[j], backlash_half_width_rad_[j]);
  }
}

World::Motors World::motors() const {
  Motors motors;
  for (std::size_t j = 0; j < motors_.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    motors.rad[row] = data_->qpos[model_->jnt_qposadr[motors_[j].joint]];
    motors.rad_s[row] = data_->qvel[model_->jnt_dofadr[motors_[j].joint]];
  }
  return motors;
}

HeadState World::head_state() const {
  return {now_us_, coupling_.joints_from_motors(encoders_->position_rad()),
          coupling_.joints_from_motors(encoders_->velocity_rad_s())};
}

JointVector World::joints_rad() const { return coupling_.joints_from_motors(joint_rad_); }

bool World::set_reference(const HeadJointVector& reference_rad) {
  const auto min = limits_.min_rad.tail<gaze_slots>().array();
  const auto max = limits_.max_rad.tail<gaze_slots>().array();
  if (!(reference_rad.array() >= min && reference_rad.array() <= max).all()) return false;
  JointVector joints = JointVector::Zero();
  joints.tail<gaze_slots>() = reference_rad;
  commands_.push_back({now_us_ + command_delay_us_, coupling_.motors_from_joints(joints)});
  return true;
}

Eigen::Isometry3d World::root_from_camera(const mjData& data, int camera_id) {
  using RowMajor = Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>;
  // MuJoCo's cameras have y up and look along -z.
  Eigen::Matrix3d rotation = Eigen::Map<const RowMajor>(data.cam_xmat + 9 * camera_id);
  rotation.rightCols<2>() *= -1.0;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = rotation;
  pose.translation() = Eigen::Map<const Eigen::Vector3d>(data.cam_xpos + 3 * camera_id);
  return pose;
}

void World::mount_camera(int camera_id, const Eigen::Isometry3d& eye_from_camera) {
  // MuJoCo's cameras have y up and look along -z; in the model file the camera has the eye's frame.
  const Eigen::Vector3d to = eye_from_camera.translation().cwiseProduct(Eigen::Vector3d(1.0, -1.0, -1.0));
  const Eigen::Quaterniond turn(eye_from_camera.linear());
  const std::array<mjtNum, 4> quat = {turn.w(), turn.x(), -turn.y(), -turn.z()};
  mjtNum* const camera_pos = model_->cam_pos + 3 * camera_id;
  mjtNum* const camera_quat = model_->cam_quat + 4 * camera_id;
  std::array<mjtNum, 3> moved{};
  mju_rotVecQuat(moved.data(), to.data(), camera_quat);
  mju_addTo3(camera_pos, moved.data());
  const std::array<mjtNum, 4> before = {camera_quat[0], camera_quat[1], camera_quat[2], camera_quat[3]};
  mju_mulQuat(camera_quat, before.data(), quat.data());
  mj_camlight(model_.get(), &data());
}

Eigen::Vector3d World::target_position_m(const mjData& data) const {
  return Eigen::Map<const Eigen::Vector3d>(data.mocap_pos +
                                           3 * (target_ ? objects_->mocap(*target_) : ball_mocap_));
}

void World::show(std::int64_t t_us, mjData& data) const {
  SACCADE_CHECK(t_us >= now_us_ - tick_us && t_us <= now_us_);
  const double tick_s = model_->opt.timestep;
  const double u = 1.0 - static_cast<double>(now_us_ - t_us) / static_cast<double>(tick_us);
  const double end = u * u * (3.0 - 2.0 * u);
  const double start_slope = tick_s * u * (1.0 - u) * (1.0 - u);
  const double end_slope = tick_s * u * u * (u - 1.0);
  for (std::size_t i = 0; i < last_qpos_.size(); ++i) {
    data.qpos[i] = (1.0 - end) * last_qpos_[i] + end * data_->qpos[i] + start_slope * last_qvel_[i] +
                   end_slope * data_->qvel[i];
  }
  for (std::size_t j = 0; j < motors_.size(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    mjtNum& q = data.qpos[model_->jnt_qposadr[motors_[j].joint]];
    q = joint_behind_backlash(q, last_joint_rad_[row], backlash_half_width_rad_[row]);
  }
  place_objects(t_us, data);
  mj_kinematics(model_.get(), &data);
  mj_comPos(model_.get(), &data);
  mj_camlight(model_.get(), &data);
}

void World::pose(std::int64_t t_us, const JointVector& position_rad, mjData& data) const {
  const JointVector joints = coupling_.motors_from_joints(position_rad);
  for (std::size_t j = 0; j < motors_.size(); ++j) {
    data.qpos[model_->jnt_qposadr[motors_[j].joint]] = joints[static_cast<Eigen::Index>(j)];
  }
  place_objects(t_us, data);
  mj_kinematics(model_.get(), &data);
  mj_comPos(model_.get(), &data);
  mj_camlight(model_.get(), &data);
}

void World::place_objects(std::int64_t t_us, mjData& data) const {
  const Eigen::Vector3d ball_m = trajectory_.position_m(t_us);
  Eigen::Map<Eigen::Vector3d>(data.mocap_pos + 3 * ball_mocap_) = ball_m;
  if (rolls_ || trajectory_.turns()) {
    Eigen::Quaterniond turn = trajectory_.turn(t_us);
    if (rolls_) turn = rolled(ball_m - trajectory_.position_m(0), ball_radius_m_);
    Eigen::Map<Eigen::Vector4d>(data.mocap_quat + 4 * ball_mocap_) << turn.w(), turn.vec();
  }
  objects_->place(t_us, data);
  if (base_motion_) {
    const Eigen::Quaterniond turn = base_rotation(base_motion_->angles_rad(t_us));
    Eigen::Map<Eigen::Vector4d>(data.mocap_quat + 4 * base_mocap_) << turn.w(), turn.vec();
  }
  if (!board_) return;
  const Eigen::Isometry3d board = root_from_board(*board_, t_us);
  const Eigen::Quaterniond turn(board.linear());
  Eigen::Map<Eigen::Vector3d>(data.mocap_pos + 3 * board_mocap_) = board.translation();
  Eigen::Map<Eigen::Vector4d>(data.mocap_quat + 4 * board_mocap_) << turn.w(), turn.vec();
}

}  // namespace saccade
