#include "sim/free_body.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/units.h"
#include "sim/model_file.h"
#include "sim/mujoco_compat.h"

namespace saccade {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

constexpr Range body_metres{-5.0, 5.0};
constexpr int steps_per_ms = 10;
constexpr double contact_s = 0.004;        ///< how long a bounce takes
constexpr double deepest_start_m = 0.002;  ///< a body that begins deeper in the surface is refused
constexpr double resting_m_s = 2e-3;
constexpr double resting_rad_s = 2e-2;
constexpr int resting_ms = 250;
constexpr double rolling_friction_m = 2e-4;

/// A body above a plane.
class FreeBody {
 public:
  FreeBody(const BodyShape& shape, const SurfaceContact& contact, const std::string& place)
      : place_(place), start_turn_(shape.turn) {
    const std::string geoms = shape.geoms.empty() ? "<geom type=\"sphere\" size=\"0.0475\"/>" : shape.geoms;
    model_ = compile_mjcf_text(
        "<mujoco><compiler angle=\"radian\"/><size nconmax=\"500\" njmax=\"3000\"/>"
        "<option timestep=\"0.0001\" cone=\"elliptic\" gravity=\"0 0 -9.81\"/><asset>" +
            shape.assets +
            "</asset><worldbody><geom name=\"surface\" type=\"plane\" size=\"0 0 1\"/><body "
            "name=\"body\"><freejoint/>" +
            geoms + "</body></worldbody></mujoco>",
        place, "a shape that MuJoCo can move");
    mjModel& m = *model_;
    const double angular = pi / contact_s;
    const double ratio = damping_ratio_of_bounce(contact.bounce);
    for (int geom = 0; geom < m.ngeom; ++geom) {
      m.geom_contype[geom] = m.geom_conaffinity[geom] = 1;
      m.geom_condim[geom] = 6;
      m.geom_friction[3 * geom] = contact.friction;
      m.geom_friction[3 * geom + 1] = m.geom_friction[3 * geom + 2] = rolling_friction_m;
      m.geom_solref[mjNREF * geom] = -angular * angular;
      m.geom_solref[mjNREF * geom + 1] = -2.0 * ratio * angular;
      m.geom_solimp[mjNIMP * geom] = m.geom_solimp[mjNIMP * geom + 1] = 0.9999;
    }
    data_.reset(mj_makeData(&m));
    if (!data_) throw RunError("MuJoCo has no memory for a moving body");
  }

  /// Height of the body's origin above the surface when it just touches it.
  double resting_height_m() {
    place_at({0.0, 0.0, 0.0});
    double lowest_m = 0.0;
    for (int i = 0; i < data_->ncon; ++i) lowest_m = std::min(lowest_m, data_->contact[i].dist);
    return -lowest_m;
  }
  void place_at(const Vector3d& above_surface_m) {
    std::copy(above_surface_m.data(), above_surface_m.data() + 3, data_->qpos);
    Eigen::Map<Eigen::Vector4d>(data_->qpos + 3) << start_turn_.w(), start_turn_.vec();
    mj_forward(model_.get(), data_.get());
  }
  void refuse_inside_surface(const std::string& key, double height_m) const {
    for (int i = 0; i < data_->ncon; ++i) {
      if (data_->contact[i].dist > -deepest_start_m) continue;
      throw InputError(place_ + "." + key, text_of(height_m) + " m above the surface",
                       "a body that begins above its surface");
    }
  }
  [[nodiscard]] mjData& data() { return *data_; }
  [[nodiscard]] double mass_kg() const { return model_->body_subtreemass[1]; }

  /// `force_n` acts at the centre of mass during the first push_s.
  MotionTrack run(double lasts_s, const Vector3d& offset_m, const Vector3d& force_n, double push_s) {
    std::vector<MotionSample> samples = {sample(0.0, offset_m)};
    int still_ms = 0;
    const auto last_ms = static_cast<int>(std::lround(1e3 * lasts_s));
    for (int ms = 1; ms <= last_ms && still_ms < resting_ms; ++ms) {
      for (int step = 0; step < steps_per_ms; ++step) {
        const bool pushed = data_->time < push_s;
        for (int i = 0; i < 3; ++i) data_->xfrc_applied[6 + i] = pushed ? force_n[i] : 0.0;
        mj_step(model_.get(), data_.get());
      }
      samples.push_back(sample(1e-3 * ms, offset_m));
      const bool rests = data_->ncon > 0 && data_->time > push_s &&
                         Eigen::Map<const Vector3d>(data_->qvel).norm() < resting_m_s &&
                         Eigen::Map<const Vector3d>(data_->qvel + 3).norm() < resting_rad_s;
      still_ms = rests ? still_ms + 1 : 0;
    }
    return MotionTrack(std::move(samples));
  }

 private:
  [[nodiscard]] MotionSample sample(double t_s, const Vector3d& offset_m) const {
    const mjtNum* q = data_->qpos;
    const Eigen::Quaterniond turn(q[3], q[4], q[5], q[6]);
    return {t_s, Vector3d(q[0], q[1], q[2]) + offset_m, turn.normalized() * start_turn_.inverse()};
  }

  std::string place_;
  Eigen::Quaterniond start_turn_;
  MjModelPtr model_;
  MjDataPtr data_;
};

}  // namespace

void describe(FieldVisitor& v, BallisticConfig& c) {
  v.reals("from_m", c.from_m, body_metres, "where the object is thrown from, root frame");
  v.reals("velocity_m_s", c.velocity_m_s, {-15.0, 15.0}, "its velocity then");
  v.reals("spin_deg_s", c.spin_deg_s, {-5000.0, 5000.0}, "its rotation then, a rotation vector");
  v.real("surface_m", c.surface_m, body_metres,
         "height of the surface on which it bounces, root frame; the floor is at -0.62");
  v.real("bounce", c.contact.bounce, {0.05, 0.95}, "speed after a straight bounce over the speed before");
  v.real("friction", c.contact.friction, {0.0, 2.0}, "coefficient of friction with the surface");
  v.real("lasts_s", c.lasts_s, {0.1, 120.0}, "from the throw until the object is held where it is");
}

void describe(FieldVisitor& v, PushConfig& c) {
  v.reals("from_m", c.from_m, body_metres,
          "where the object rests, root frame; the surface is just below it");
  v.reals("push_m_s", c.push_m_s, {-5.0, 5.0},
          "velocity along x and y that the push gives to an object without friction");
  v.real("push_s", c.push_s, {0.001, 5.0}, "how long the push lasts");
  v.real("friction", c.friction, {0.0, 2.0}, "coefficient of friction with the surface");
  v.real("lasts_s", c.lasts_s, {0.1, 120.0}, "from the push until the object is held where it is");
}

double damping_ratio_of_bounce(double bounce) {
  const auto bounce_of = [](double ratio) {
    const double damped = std::sqrt(1.0 - ratio * ratio);
    return std::exp(-ratio / damped *
                    (pi - std::atan2(2.0 * ratio * damped, damped * damped - ratio * ratio)));
  };
  double low = 0.0;
  double high = 0.9999;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (bounce_of(middle) > bounce ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

MotionTrack ballistic_motion(const BallisticConfig& config, const BodyShape& shape,
                             const std::string& place) {
  FreeBody body(shape, config.contact, place);
  const Vector3d surface(0.0, 0.0, config.surface_m);
  body.place_at(config.from_m - surface);
  body.refuse_inside_surface("from_m", config.from_m.z() - config.surface_m);
  Eigen::Map<Vector3d>(body.data().qvel) = config.velocity_m_s;
  const Vector3d spin(config.spin_deg_s[0], config.spin_deg_s[1], config.spin_deg_s[2]);
  Eigen::Map<Vector3d>(body.data().qvel + 3) = rad_per_deg * spin;
  return body.run(config.lasts_s, surface, Vector3d::Zero(), 0.0);
}

MotionTrack pushed_motion(const PushConfig& config, const BodyShape& shape, const std::string& place) {
  constexpr double no_bounce = 0.05;
  FreeBody body(shape, {no_bounce, config.friction}, place);
  const double height_m = body.resting_height_m();
  body.place_at({config.from_m.x(), config.from_m.y(), height_m});
  const Vector3d push(config.push_m_s.x(), config.push_m_s.y(), 0.0);
  return body.run(config.lasts_s, {0.0, 0.0, config.from_m.z() - height_m},
                  body.mass_kg() / config.push_s * push, config.push_s);
}

}  // namespace saccade
