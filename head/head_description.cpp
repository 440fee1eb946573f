#include "head/head_description.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace saccade {
namespace {

constexpr const char* no_joint = "none";
constexpr std::size_t max_joints = 12;
/// Lengths of links, and places in the root frame. Heads are smaller: millimetres taken for metres lie outside.
constexpr Range link_range_m{-2.0, 2.0};
constexpr Range place_range_m{-3.0, 3.0};
constexpr double least_baseline_m = 1e-3;

std::vector<std::string> joint_choices(const HeadDescription& head) {
  std::vector<std::string> names = {no_joint};
  for (const auto& [name, joint] : head.joints) names.push_back(name);
  return names;
}

Eigen::Matrix3d rotation_of(const std::array<double, 9>& by_rows) {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(by_rows.data());
}

void require_rotation(FieldVisitor& v, std::string_view key, const std::array<double, 9>& by_rows) {
  const Eigen::Matrix3d rotation = rotation_of(by_rows);
  v.require((rotation * rotation.transpose()).isIdentity(1e-6) && rotation.determinant() > 0.0, key,
            "another matrix", "a rotation: orthonormal, with determinant 1");
}

void describe_links(FieldVisitor& v, DescribedLinks& links, const std::vector<std::string>& joints,
                    std::string_view doc) {
  v.section(
      "links",
      [&](FieldVisitor& w) {
        std::vector<std::string> names;
        for (const auto& entry : links) names.push_back(entry.first);
        for (const std::string& name : w.section_keys(names)) {
          if (std::ranges::none_of(links, [&](const auto& entry) { return entry.first == name; }))
            links.emplace_back(name, DescribedLink{});
        }
        for (auto& [name, link] : links) {
          w.section(
              name, [&link = link, &joints](FieldVisitor& u) { describe(u, link, joints); }, "a link");
          w.require(is_name(name), name, "such a name", name_expectation);
        }
      },
      doc);
}

void describe_eye(FieldVisitor& v, DescribedEye& eye, const std::vector<std::string>& joints) {
  describe_links(v, eye.links, joints, "links after those of the neck, by name, in the order of the chain");
  v.optional_section(
      "pose", eye.pose,
      "where the eye is with all joints at 0; without it the frame after the last row of a DH table");
  v.when(!eye.pose, "no pose", [&] {
    v.reals("end_rotation", eye.end_rotation, {-1.0, 1.0},
            "rotation of the eye's frame in the frame after the last link, by rows");
    require_rotation(v, "end_rotation", eye.end_rotation);
    v.reals("end_position_m", eye.end_position_m, link_range_m, "origin of the eye's frame in that frame");
  });
}

/// Collects what is wrong while a chain is made.
class Builder {
 public:
  explicit Builder(const HeadDescription& head) : description_(head) {
    model_->name = head.name;
    model_->mjcf = head.mjcf;
    model_->head_from_imu = rotation_of(head.imu_rotation);
    set_joints();
    Eigen::Isometry3d base = Eigen::Isometry3d::Identity();
    base.linear() = rotation_of(head.base_rotation);
    base.translation() = head.base_position_m;
    HeadChain& chain = model_->chain;
    chain.root_from_base = base;
    Eigen::Isometry3d frame = base;
    chain.common = links(head.links, "head.links.", HeadChain::max_common_links, false, frame);
    chain.eyes = head.right_eye ? 2 : 1;
    add_eye(0, head.left_eye, "head.left_eye.", frame);
    if (head.right_eye) add_eye(1, *head.right_eye, "head.right_eye.", frame);
    check_effects();
    if (!problems_.empty()) throw InputError(problems_);
    chain.complete();
  }

  [[nodiscard]] std::shared_ptr<const HeadModel> model() const { return model_; }

 private:
  void add(std::string place, std::string found, std::string expectation) {
    problems_.push_back({std::move(place), std::move(found), std::move(expectation)});
  }

  void set_joints() {
    std::array<int, 3> next = {0, torso_slots, torso_slots};  // slot of the next joint of a role
    for (const auto& [name, joint] : description_.joints) {
      if (joint.role == JointRole::neck) ++next[2];
    }
    JointRole last = JointRole::torso;
    for (const auto& [name, joint] : description_.joints) {
      if (joint.role < last)
        add("head.joints." + name + ".role", std::string(word_of(joint.role)),
            "an order of the joints with the torso's first, then the neck's, then the eyes'");
      last = joint.role;
      int& slot = next[static_cast<std::size_t>(joint.role)];
      model_->joints.push_back({name, joint.role, slot++, joint.min_deg * rad_per_deg,
                                joint.max_deg * rad_per_deg, joint.max_speed_deg_s * rad_per_deg,
                                joint.bandwidth_hz});
    }
    for (const HeadJoint& known : model_->joints) {
      if (known.role == JointRole::torso) model_->torso_motors.push_back(known.slot);
    }
    if (next[0] > torso_slots)
      add("head.joints", std::to_string(next[0]) + " joints of the torso",
          "at most " + std::to_string(torso_slots));
    if (model_->gaze_joints() == 0) add("head.joints", "no joint of neck or eyes", "one at least");
  }

  [[nodiscard]] const HeadJoint* joint(const std::string& name) const {
    for (const HeadJoint& known : model_->joints) {
      if (known.name == name) return &known;
    }
    return nullptr;
  }

  /// The links of one part of the chain. `frame`: root from the frame before them, with all joints at 0; then that after.
  std::vector<ChainLink> links(const DescribedLinks& described, const std::string& place, std::size_t most,
                               bool of_eye, Eigen::Isometry3d& frame) {
    std::vector<ChainLink> made;
    if (described.size() > most)
      add(place.substr(0, place.size() - 1), std::to_string(described.size()) + " links",
          "at most " + std::to_string(most));
    for (const auto& [name, link] : described) {
      ChainLink result;
      if (link.kind == LinkKind::axis) {
        Eigen::Isometry3d on_axis = Eigen::Isometry3d::Identity();
        on_axis.linear() =
            Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), link.axis).toRotationMatrix();
        on_axis.translation() = link.point_m;
        result = ChainLink{}.after(frame.inverse() * on_axis);
      } else {
        result = ChainLink::dh(link.a_m, link.d_m, link.alpha_deg, link.offset_deg);
        if (!link.before_m.isZero(0.0)) {
          Eigen::Isometry3d before = Eigen::Isometry3d::Identity();
          before.translation() = link.before_m;
          result = result.after(before);
        }
      }
      result.name = name;
      turn(result, link.joint, link.share, place + name + ".joint", of_eye);
      turn(result, link.second_joint, link.second_share, place + name + ".second_joint", of_eye);
      if (!result.moves()) result.name.clear();
      if (result.moves() && !hinges_.insert_name(name))
        add(place + name, name, "a name that no other link of the head has");
      apply_before(result, frame);
      apply_turn(result, 0.0, frame);
      made.push_back(std::move(result));
    }
    return made;
  }

  void turn(ChainLink& link, const std::string& name, double share, const std::string& place, bool of_eye) {
    if (name == no_joint || link.joints == 2) return;
    const HeadJoint* const by = joint(name);
    if (by == nullptr) return;
    if (of_eye && by->role != JointRole::eye) add(place, name, "a joint with role: eye in a link of an eye");
    link = link.turned_by(by->slot, share);
  }

  void add_eye(std::size_t e, const DescribedEye& eye, const std::string& place, Eigen::Isometry3d frame) {
    HeadChain& chain = model_->chain;
    chain.eye[e] = links(eye.links, place + "links.", HeadChain::max_eye_links, true, frame);
    const DescribedLinks& last_of = eye.links.empty() ? description_.links : eye.links;
    const bool after_axis = !last_of.empty() && last_of.back().second.kind == LinkKind::axis;
    Eigen::Isometry3d& to = chain.eye_from_last[e];
    if (eye.pose) {
      const Eigen::Vector3d z = eye.pose->forward.normalized();
      const Eigen::Vector3d x = z.cross(eye.pose->up).normalized();
      Eigen::Isometry3d at = Eigen::Isometry3d::Identity();
      at.linear() << x, z.cross(x), z;
      at.translation() = eye.pose->position_m;
      to = frame.inverse() * at;
      chain.has_eye_from_last = true;
    } else if (after_axis) {
      add(place + "pose", "missing", "position_m, forward and up of the eye: its last link is an axis");
    }
    if (!eye.pose) {
      to.linear() = rotation_of(eye.end_rotation);
      to.translation() = eye.end_position_m;
      chain.has_eye_from_last = chain.has_eye_from_last || !to.isApprox(Eigen::Isometry3d::Identity(), 0.0);
    }
    place_m_[e] = (frame * to).translation();
    if (e == 1 && (place_m_[1] - place_m_[0]).norm() < least_baseline_m)
      add(place.substr(0, place.size() - 1), "an eye at the place of the left one",
          "links of its own, or its pose");
  }

  /// Each joint turns something, and no two of them the same.
  void check_effects() {
    std::vector<const ChainLink*> moving;
    const HeadChain& chain = model_->chain;
    for (const auto* part : {&chain.common, &chain.eye[0], &chain.eye[1]}) {
      for (const ChainLink& link : *part) {
        if (link.moves()) moving.push_back(&link);
      }
    }
    if (moving.size() > static_cast<std::size_t>(joint_slots))
      add("head.links", std::to_string(moving.size()) + " links that joints turn",
          "at most " + std::to_string(joint_slots));
    Eigen::MatrixXd shares = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(moving.size()), joint_slots);
    for (std::size_t i = 0; i < moving.size(); ++i) {
      for (int j = 0; j < moving[i]->joints; ++j) {
        const JointShare& by = moving[i]->turns[static_cast<std::size_t>(j)];
        shares(static_cast<Eigen::Index>(i), by.slot) += by.share;
      }
    }
    bool all = true;
    for (const HeadJoint& known : model_->joints) {
      if (known.slot < joint_slots && shares.col(known.slot).isZero(0.0)) {
        add("head.joints." + known.name, "a joint that turns no link", "a link with joint: " + known.name);
        all = false;
      }
    }
    if (all && !moving.empty() && problems_.empty() &&
        Eigen::FullPivLU<Eigen::MatrixXd>(shares).rank() < static_cast<Eigen::Index>(model_->joints.size()))
      add("head.links", "joints that turn the same links by the same shares",
          "joints that can be told apart");
  }

  struct Names {
    std::vector<std::string> known;
    bool insert_name(const std::string& name) {
      if (std::ranges::count(known, name) > 0) return false;
      known.push_back(name);
      return true;
    }
  };

  const HeadDescription& description_;
  std::shared_ptr<HeadModel> model_ = std::make_shared<HeadModel>();
  std::vector<Problem> problems_;
  Names hinges_;
  std::array<Eigen::Vector3d, 2> place_m_;  // of the eyes, with all joints at 0, root frame
};

}  // namespace

void describe(FieldVisitor& v, DescribedJoint& joint) {
  v.choice("role", joint.role,
           "part of the head that the joint belongs to; the torso is measured and not commanded");
  v.real("min_deg", joint.min_deg, {-360.0, 360.0}, "lowest position");
  v.real("max_deg", joint.max_deg, {-360.0, 360.0}, "highest position");
  // NaN: not known yet; a checker refuses it.
  v.require(!(joint.min_deg >= joint.max_deg), "max_deg", text_of(joint.max_deg), "more than min_deg");
  v.require(!(joint.min_deg > 0.0) && !(joint.max_deg < 0.0), "min_deg",
            text_of(joint.min_deg) + " to " + text_of(joint.max_deg), "a range with 0, the neutral position");
  v.real("max_speed_deg_s", joint.max_speed_deg_s, {0.1, 5000.0}, "highest speed");
  v.real("bandwidth_hz", joint.bandwidth_hz, {0.5, 60.0},
         "natural frequency of the joint's critically damped servo in the simulator");
}

void describe(FieldVisitor& v, DescribedLink& link, const std::vector<std::string>& joints) {
  v.choice("kind", link.kind, "axis: a line in the root frame with all joints at 0; dh: a row of a DH table");
  v.when(link.kind == LinkKind::axis, "kind: axis", [&] {
    v.reals("axis", link.axis, {-1e3, 1e3}, "direction of the axis; a positive turn is right-handed");
    v.require(link.axis.norm() > 1e-6, "axis", "[0, 0, 0]", "a direction");
    v.reals("point_m", link.point_m, place_range_m, "a point on the axis");
  });
  v.when(link.kind == LinkKind::dh, "kind: dh", [&] {
    v.real("a_m", link.a_m, link_range_m, "length of the link, A");
    v.real("d_m", link.d_m, link_range_m, "offset along the axis, D");
    v.real("alpha_deg", link.alpha_deg, {-360.0, 360.0}, "twist of the link");
    v.real("offset_deg", link.offset_deg, {-360.0, 360.0}, "angle of the link with its joints at 0");
    v.reals("before_m", link.before_m, link_range_m,
            "displacement before the row, in the frame of the link before");
  });
  v.choice("joint", link.joint, joints, "joint that turns the link; none: it is fixed");
  v.when(link.joint != no_joint, "joint: a joint", [&] {
    v.real("share", link.share, {-100.0, 100.0}, "rotation of the link per rotation of the joint");
    v.require(link.share != 0.0, "share", "0", "another number, or joint: none");
    v.choice("second_joint", link.second_joint, joints,
             "a second joint that turns the link as well, such as vergence");
    v.when(link.second_joint != no_joint, "second_joint: a joint", [&] {
      v.real("second_share", link.second_share, {-100.0, 100.0},
             "rotation of the link per rotation of that joint");
      v.require(link.second_share != 0.0, "second_share", "0", "another number, or second_joint: none");
      v.require(link.second_joint != link.joint, "second_joint", link.second_joint, "another joint");
    });
  });
}

void describe(FieldVisitor& v, DescribedPose& pose) {
  v.reals("position_m", pose.position_m, place_range_m, "centre of the eye, root frame");
  v.reals("forward", pose.forward, {-1e3, 1e3}, "direction of the optical axis, root frame");
  v.reals("up", pose.up, {-1e3, 1e3}, "direction that is up in the image, root frame");
  v.require(
      pose.forward.norm() > 1e-6 && pose.forward.normalized().cross(pose.up).norm() > 1e-3 * pose.up.norm(),
      "up", "[" + text_of(pose.up[0]) + ", " + text_of(pose.up[1]) + ", " + text_of(pose.up[2]) + "]",
      "a direction across forward");
}

void describe(FieldVisitor& v, HeadDescription& head) {
  v.text("name", head.name, "name of the head, for messages");
  v.named_sections("joints", head.joints,
                   "joints, by name, in the order of tables: those of the torso, the neck, the eyes",
                   "a joint");
  v.require(!head.joints.empty() && head.joints.size() <= max_joints, "joints",
            std::to_string(head.joints.size()) + " joints", "1 to " + std::to_string(max_joints));
  v.reals("base_rotation", head.base_rotation, {-1.0, 1.0},
          "rotation of the frame before the first row of a DH table, by rows, root frame");
  require_rotation(v, "base_rotation", head.base_rotation);
  v.reals("base_position_m", head.base_position_m, place_range_m, "origin of that frame, root frame");
  const std::vector<std::string> joints = joint_choices(head);
  describe_links(v, head.links, joints,
                 "links from the root to where the eyes branch off, by name, in the order of the chain");
  v.section(
      "left_eye", [&](FieldVisitor& w) { describe_eye(w, head.left_eye, joints); },
      "the left eye, or the only one");
  if (v.has_section("right_eye", head.right_eye.has_value())) {
    if (!head.right_eye) head.right_eye.emplace();
    v.section(
        "right_eye", [&](FieldVisitor& w) { describe_eye(w, *head.right_eye, joints); },
        "the right eye, where there is one, with the keys of left_eye");
  }
  v.real("encoder_step_deg", head.encoder_step_deg, {0.0, 1.0},
         "step of the encoders' readings: the default of plant.encoders.quantisation_deg");
  v.integer("command_delay_ms", head.command_delay_ms, {0, 200},
            "delay from a command to the servos: the default of plant.command_delay_ms");
  v.reals("imu_rotation", head.imu_rotation, {-1.0, 1.0},
          "orientation of the head's inertial sensor with all joints at 0, by rows, root frame; for a "
          "robot's sensor port");
  require_rotation(v, "imu_rotation", head.imu_rotation);
  v.path("mjcf", head.mjcf,
         "MJCF model of the head with this chain; empty: a model is made from the description");
}

std::shared_ptr<const HeadModel> described_head(const HeadDescription& head) { return Builder(head).model(); }

}  // namespace saccade
