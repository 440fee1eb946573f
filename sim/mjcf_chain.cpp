#include "sim/mjcf_chain.h"

#include <algorithm>
#include <array>

#include "core/error.h"
#include "sim/mujoco_compat.h"

namespace saccade {
namespace {

class MjcfChain {
 public:
  explicit MjcfChain(const ChainRequest& request) : request_(request) {
    std::array<char, 1024> error{};
    model_.reset(mj_loadXML(request.path.c_str(), nullptr, error.data(), error.size()));
    if (!model_) {
      std::string text = error.data();
      std::ranges::replace(text, '\n', ' ');
      while (text.ends_with(' ')) text.pop_back();
      throw InputError(request.path, text, "a model in MJCF that MuJoCo compiles");
    }
    data_.reset(mj_makeData(model_.get()));
    if (!data_) throw RunError("MuJoCo has no memory for " + request.path);
    find_joints();
    find_cameras();
    throw_if_any();
    require_chain();
    throw_if_any();
    place();
  }

  [[nodiscard]] PlacedChain chain() const { return chain_; }

 private:
  struct Camera {
    int body = 0;
    int id = -1;  // of the <camera>; -1: the body is the camera
  };

  void add(const std::string& element, std::string found, std::string expectation) {
    problems_.push_back(
        {request_.path + (element.empty() ? "" : ": " + element), std::move(found), std::move(expectation)});
  }
  void throw_if_any() const {
    if (!problems_.empty()) throw InputError(problems_);
  }
  [[nodiscard]] std::string name_of(mjtObj type, int id) const {
    const char* const name = mj_id2name(model_.get(), type, id);
    return name != nullptr ? name : "";
  }
  static std::string element_of(const std::string& joint) { return "<joint name=\"" + joint + "\">"; }

  void find_joints() {
    for (const std::string& name : request_.joints) {
      const int joint = mj_name2id(model_.get(), mjOBJ_JOINT, name.c_str());
      joints_.push_back(joint);
      if (joint < 0) {
        add("", "head.chain: " + name, "the name of a joint");
        continue;
      }
      if (model_->jnt_type[joint] != mjJNT_HINGE)
        add(element_of(name), "a joint that is no hinge", "type=\"hinge\" in head.chain");
      for (int e = 0; e < model_->neq; ++e) {
        if (model_->eq_type[e] == mjEQ_JOINT && model_->eq_obj1id[e] == joint)
          add(element_of(name), "a joint that follows another by an equality",
              "a joint of its own in head.chain");
      }
    }
  }

  Camera camera(const std::string& name, const std::string& key) {
    Camera found;
    found.id = mj_name2id(model_.get(), mjOBJ_CAMERA, name.c_str());
    if (found.id >= 0) {
      found.body = model_->cam_bodyid[found.id];
      if (model_->cam_mode[found.id] != mjCAMLIGHT_FIXED)
        add("<camera name=\"" + name + "\">", "a camera that turns to a target", "mode=\"fixed\"");
      return found;
    }
    found.body = mj_name2id(model_.get(), mjOBJ_BODY, name.c_str());
    if (found.body < 0) {
      add("", key + ": " + name, "the name of a camera or body");
      found.body = 0;
    }
    return found;
  }

  void find_cameras() {
    cameras_.push_back(camera(request_.camera, "head.camera"));
    if (request_.right_camera) cameras_.push_back(camera(*request_.right_camera, "head.right_camera"));
    throw_if_any();
    if (request_.base) {
      base_ = mj_name2id(model_.get(), mjOBJ_BODY, request_.base->c_str());
      if (base_ < 0) add("", "head.base: " + *request_.base, "the name of a body");
    } else {
      // The world, or the body that floats in it.
      const int top = model_->body_rootid[cameras_[0].body];
      const int joint = model_->body_jntadr[top];
      base_ = joint >= 0 && model_->jnt_type[joint] == mjJNT_FREE ? top : 0;
    }
    throw_if_any();
    for (const Camera& camera : cameras_) {
      if (!is_on(camera.body, base_))
        add("", "a camera on body " + name_of(mjOBJ_BODY, camera.body),
            "one on the base, body " + name_of(mjOBJ_BODY, base_));
    }
  }

  /// Whether a body is another one or is carried by it.
  [[nodiscard]] bool is_on(int body, int other) const {
    while (body > other) body = model_->body_parentid[body];
    return body == other;
  }
  /// Whether a joint lies between the base and a camera. The base's own joints do not: they carry the base.
  [[nodiscard]] bool turns(int joint, const Camera& camera) const {
    const int body = model_->jnt_bodyid[joint];
    return body != base_ && is_on(body, base_) && is_on(camera.body, body);
  }

  void require_chain() {
    std::vector<int> order;  // MuJoCo numbers joints along each branch from the base on
    for (std::size_t i = 0; i < joints_.size(); ++i) {
      const bool any = std::ranges::any_of(cameras_, [&](const Camera& c) { return turns(joints_[i], c); });
      if (!any)
        add(element_of(request_.joints[i]), "a joint of head.chain that does not turn the camera",
            "one between body " + name_of(mjOBJ_BODY, base_) + " and " + request_.camera);
    }
    throw_if_any();
    for (const Camera& camera : cameras_) {
      std::vector<int> along;
      for (const int joint : joints_) {
        if (turns(joint, camera) && std::ranges::count(order, joint) == 0) along.push_back(joint);
      }
      std::ranges::sort(along);
      order.insert(order.end(), along.begin(), along.end());
    }
    if (order != joints_) {
      std::string names;
      for (const int joint : order) names += (names.empty() ? "" : ", ") + name_of(mjOBJ_JOINT, joint);
      add("", "head.chain in another order", "that from the base to the cameras: [" + names + "]");
    }
    for (int e = 0; e < model_->neq; ++e) {
      if (model_->eq_type[e] != mjEQ_JOINT || std::ranges::count(joints_, model_->eq_obj2id[e]) == 0)
        continue;
      for (const Camera& camera : cameras_) {
        if (turns(model_->eq_obj1id[e], camera))
          add(element_of(name_of(mjOBJ_JOINT, model_->eq_obj1id[e])),
              "a joint that follows " + name_of(mjOBJ_JOINT, model_->eq_obj2id[e]) + " by an equality",
              "no such joint between base and camera");
      }
    }
  }

  static Eigen::Vector3d vector(const mjtNum* values) { return {values[0], values[1], values[2]}; }
  static Eigen::Isometry3d pose(const mjtNum* position, const mjtNum* rotation) {
    Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
    result.translation() = vector(position);
    result.linear() = Eigen::Map<const Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>>(rotation);
    return result;
  }

  void place() {
    for (const int joint : joints_) data_->qpos[model_->jnt_qposadr[joint]] = 0.0;
    mj_kinematics(model_.get(), data_.get());
    mj_comPos(model_.get(), data_.get());
    mj_camlight(model_.get(), data_.get());
    const Eigen::Isometry3d root_from_world =
        Eigen::Isometry3d(request_.root_from_base) *
        pose(data_->xpos + std::ptrdiff_t{3} * base_, data_->xmat + std::ptrdiff_t{9} * base_).inverse();
    chain_.cameras = static_cast<int>(cameras_.size());
    for (const int joint : joints_) {
      PlacedJoint placed;
      placed.name = name_of(mjOBJ_JOINT, joint);
      placed.place = request_.path + ": " + element_of(placed.name);
      placed.axis = root_from_world.linear() * vector(data_->xaxis + std::ptrdiff_t{3} * joint);
      placed.point_m = root_from_world * vector(data_->xanchor + std::ptrdiff_t{3} * joint);
      if (model_->jnt_limited[joint] != 0) {
        placed.min_rad = model_->jnt_range[2 * joint];
        placed.max_rad = model_->jnt_range[2 * joint + 1];
      }
      const bool left = turns(joint, cameras_[0]);
      if (left && (cameras_.size() == 1 || turns(joint, cameras_[1]))) {
        chain_.common.push_back(std::move(placed));
      } else {
        placed.role = JointRole::eye;
        chain_.eye[left ? 0 : 1].push_back(std::move(placed));
      }
    }
    // A camera of MuJoCo looks along -z with y up.
    Eigen::Matrix3d camera_from_optical = Eigen::Vector3d(1.0, -1.0, -1.0).asDiagonal();
    for (std::size_t e = 0; e < cameras_.size(); ++e) {
      const Camera& camera = cameras_[e];
      Eigen::Isometry3d world_from_camera;
      if (camera.id >= 0) {
        world_from_camera = pose(data_->cam_xpos + std::ptrdiff_t{3} * camera.id,
                                 data_->cam_xmat + std::ptrdiff_t{9} * camera.id);
        world_from_camera.rotate(camera_from_optical);
      } else {
        world_from_camera = pose(data_->xpos + std::ptrdiff_t{3} * camera.body,
                                 data_->xmat + std::ptrdiff_t{9} * camera.body);
        if (!request_.optical) world_from_camera.rotate(body_from_optical());
      }
      chain_.root_from_camera[e] = root_from_world * world_from_camera;
    }
  }

  const ChainRequest& request_;
  MjModelPtr model_;
  MjDataPtr data_;
  std::vector<int> joints_;
  std::vector<Camera> cameras_;
  int base_ = 0;
  PlacedChain chain_;
  std::vector<Problem> problems_;
};

}  // namespace

PlacedChain chain_of_mjcf(const ChainRequest& request) { return MjcfChain(request).chain(); }

}  // namespace saccade
