#include <numbers>

#include "core/units.h"
#include "head/head_model.h"

namespace saccade {
namespace {

struct TableRow {
  double a_m;
  double d_m;
};

/// In what the versions differ: rows 2 to 5 of the eye chain (torso yaw to neck yaw), and how far the camera's frame lies
/// before the eye's centre.
struct Dimensions {
  std::string_view version;
  TableRow torso_yaw, neck_pitch, neck_roll, neck_yaw;
  double camera_ahead_m;
};

constexpr std::array<Dimensions, 5> versions = {{
    {"1", {0.00231, -0.1933}, {0.033, 0.0}, {0.0, 0.001}, {-0.054, 0.0825}, 0.0},
    {"2", {0.0, -0.2233}, {0.0095, 0.0}, {0.0, 0.0}, {-0.0509, 0.08205}, 0.0},
    // With the virtual image plane of the event cameras.
    {"2.8", {0.0, -0.2233}, {0.0095, 0.0}, {0.0, 0.0}, {-0.0509, 0.08205}, -0.010},
    {"2.10", {0.0053, -0.2233}, {0.0110, 0.0}, {0.0, 0.0}, {-0.0510, 0.08052}, -0.00983},
    {"3", {-0.00486151, -0.26377}, {0.0095, 0.0}, {0.0, 0.0}, {-0.0509, 0.08205}, 0.0},
}};

struct Limits {
  std::string_view name;
  JointRole role;
  double min_deg, max_deg, max_speed_rad_s;
};

/// Limits of iCubGenova02, 2016 (robots-configuration). The speeds are those of models/icub_head.xml.
constexpr std::array<Limits, 9> limits_v2 = {{
    {"torso_pitch", JointRole::torso, -20.0, 70.0, 0.7},
    {"torso_roll", JointRole::torso, -30.0, 30.0, 0.7},
    {"torso_yaw", JointRole::torso, -50.0, 50.0, 0.7},
    {"neck_pitch", JointRole::neck, -30.0, 17.0, 1.75},
    {"neck_roll", JointRole::neck, -20.0, 20.0, 1.75},
    {"neck_yaw", JointRole::neck, -45.0, 45.0, 2.1},
    {"eyes_tilt", JointRole::eye, -30.0, 30.0, 5.2},
    {"eyes_version", JointRole::eye, -30.0, 30.0, 7.0},
    {"eyes_vergence", JointRole::eye, 0.0, 50.0, 7.0},
}};

std::array<Limits, 9> limits_of(std::string_view version) {
  std::array<Limits, 9> limits = limits_v2;
  if (version != "3") return limits;
  const auto set = [&](Joint joint, double min_deg, double max_deg) {
    Limits& limit = limits[static_cast<std::size_t>(joint)];
    limit.min_deg = min_deg;
    limit.max_deg = max_deg;
  };
  set(torso_pitch, -15.0, 40.0);
  set(torso_roll, -20.0, 20.0);
  set(torso_yaw, -40.0, 40.0);
  set(neck_pitch, -30.0, 22.0);
  return limits;
}

Eigen::Isometry3d rotation(const Eigen::Matrix3d& r) {
  Eigen::Isometry3d t = Eigen::Isometry3d::Identity();
  t.linear() = r;
  return t;
}

ChainLink hinge(const ChainLink& link, Joint joint) {
  return link.named(std::string(joint_names[static_cast<std::size_t>(joint)])).turned_by(joint);
}

HeadChain chain_of(const Dimensions& size) {
  HeadChain chain;
  Eigen::Matrix3d base;
  const ChainLink yaw = ChainLink::dh(size.torso_yaw.a_m, size.torso_yaw.d_m, -90.0, -90.0);
  if (size.version == "3") {
    base << 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, 0.0;
    ChainLink last = ChainLink::dh(size.torso_yaw.a_m, size.torso_yaw.d_m, -90.0, 0.0);
    last.offset_rad = std::numbers::pi;
    chain.common = {hinge(ChainLink::dh(0.0725, 0.0, -90.0, 0.0), torso_roll),
                    hinge(ChainLink::dh(0.0, 0.0, 90.0, -90.0), torso_pitch), hinge(last, torso_yaw)};
  } else {
    base << 0.0, -1.0, 0.0, 0.0, 0.0, -1.0, 1.0, 0.0, 0.0;
    chain.common = {hinge(ChainLink::dh(0.032, 0.0, 90.0, 0.0), torso_pitch),
                    hinge(ChainLink::dh(0.0, -0.0055, 90.0, -90.0), torso_roll), hinge(yaw, torso_yaw)};
  }
  chain.root_from_base = rotation(base);
  const auto neck = [&](const TableRow& row, double alpha_deg, double offset_deg, Joint joint) {
    chain.common.push_back(hinge(ChainLink::dh(row.a_m, row.d_m, alpha_deg, offset_deg), joint));
  };
  neck(size.neck_pitch, 90.0, 90.0, neck_pitch);
  neck(size.neck_roll, -90.0, -90.0, neck_roll);
  neck(size.neck_yaw, -90.0, 90.0, neck_yaw);
  // iKin's row of the tilt has D = -/+34 mm for the left and right eye. Here the eyes' pans lie that far aside of it.
  neck({0.0, 0.0}, -90.0, 0.0, eyes_tilt);
  constexpr double half_baseline_m = 0.034;
  for (const std::size_t e : {std::size_t{0}, std::size_t{1}}) {
    Eigen::Isometry3d aside = Eigen::Isometry3d::Identity();
    aside.translation().y() = e == 0 ? half_baseline_m : -half_baseline_m;
    chain.eye[e] = {ChainLink::dh(0.0, 0.0, 90.0, -90.0)
                        .named(e == 0 ? "l_eye_pan" : "r_eye_pan")
                        .turned_by(eyes_version)
                        .turned_by(eyes_vergence, e == 0 ? 0.5 : -0.5)
                        .after(aside)};
    chain.eye_from_last[e].translation().z() = size.camera_ahead_m;
  }
  chain.has_eye_from_last = size.camera_ahead_m != 0.0;
  chain.complete();
  return chain;
}

std::shared_ptr<const HeadModel> made(const Dimensions& size) {
  auto head = std::make_shared<HeadModel>();
  head->name = "icub version " + std::string(size.version);
  int slot = 0;
  for (const Limits& limit : limits_of(size.version)) {
    head->joints.push_back({std::string(limit.name), limit.role, slot++, limit.min_deg * rad_per_deg,
                            limit.max_deg * rad_per_deg, limit.max_speed_rad_s,
                            limit.role == JointRole::eye ? 27.0 : 10.0});
  }
  head->chain = chain_of(size);
  head->is_icub = true;
  head->torso_motors = size.version == "3" ? std::vector<int>{torso_roll, torso_pitch, torso_yaw}
                                           : std::vector<int>{torso_yaw, torso_roll, torso_pitch};
  return head;
}

}  // namespace

std::shared_ptr<const HeadModel> icub_head(std::string_view version) {
  for (const Dimensions& size : versions) {
    if (size.version == version) return made(size);
  }
  return nullptr;
}

const std::vector<std::string>& icub_versions() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const Dimensions& size : versions) list.emplace_back(size.version);
    return list;
  }();
  return names;
}

const std::shared_ptr<const HeadModel>& default_head() {
  static const std::shared_ptr<const HeadModel> head = icub_head("2");
  return head;
}

}  // namespace saccade
