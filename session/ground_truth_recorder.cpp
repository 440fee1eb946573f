#include "session/ground_truth_recorder.h"

#include <algorithm>
#include <cmath>

#include "recording/run_file_names.h"

namespace saccade {
namespace {

constexpr std::array<const char*, 2> eye_names = {"left", "right"};

using RowMajor4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;

template <class Matrix>
void append(ArrayFile& file, std::size_t array, const Matrix& values) {
  file.append(array, std::span<const double>(values.data(), static_cast<std::size_t>(values.size())));
}

}  // namespace

GroundTruthRecorder::GroundTruthRecorder(const std::filesystem::path& folder, const Scenario& scenario,
                                         SimRobot& robot)
    : scenario_(scenario),
      config_(*scenario.output.ground_truth),
      robot_(robot),
      file_(create_array_file(folder / (config_.format == ArrayFormat::npz ? run_file::ground_truth_npz
                                                                           : run_file::ground_truth_hdf5))),
      eyes_(scenario.sim.both_eyes() ? 2 : 1),
      pixels_(static_cast<std::size_t>(scenario.sim.camera.size.pixels())),
      noise_(static_cast<std::uint64_t>(scenario.seed), "frames of the ground truth") {
  if (config_.segmentation || config_.poses) objects_ = object_table(robot.world());
  flow_.resize(2 * pixels_);
  camera_flow_.resize(2 * pixels_);
  for (std::size_t eye = 0; eye < eyes_; ++eye) {
    luminance_.at(eye).resize(pixels_);
    exposed_.at(eye).assign(pixels_, 0.0);
  }
  add_arrays();
}

void GroundTruthRecorder::add_arrays() {
  const auto height = static_cast<std::size_t>(scenario_.sim.camera.size.height);
  const auto width = static_cast<std::size_t>(scenario_.sim.camera.size.width);
  t_ = file_->add("t_us", ArrayType::i64, {});
  for (std::size_t eye = 0; eye < eyes_; ++eye) {
    const std::string group = std::string(eye_names.at(eye)) + "/";
    EyeArrays& arrays = arrays_.at(eye);
    if (config_.images) arrays.image = file_->add(group + "image", ArrayType::f32, {height, width});
    if (config_.frames) arrays.frame = file_->add(group + "frame", ArrayType::u8, {height, width});
    if (config_.depth) arrays.depth = file_->add(group + "depth_m", ArrayType::f32, {height, width});
    if (config_.flow) {
      arrays.flow = file_->add(group + "flow_px_s", ArrayType::f32, {height, width, 2});
      arrays.camera_flow = file_->add(group + "camera_flow_px_s", ArrayType::f32, {height, width, 2});
    }
    if (config_.segmentation)
      arrays.segmentation = file_->add(group + "segmentation", ArrayType::u8, {height, width});
    if (config_.poses) arrays.pose = file_->add(group + "root_from_camera", ArrayType::f64, {4, 4});
  }
  if (config_.segmentation) file_->put("objects", objects_.names);
  if (config_.poses) {
    const HeadModel& head = *robot_.limits().head;
    std::vector<std::string> names;
    for (const HeadJoint& joint : head.joints) names.push_back(joint.name);
    file_->put("poses/bodies", objects_.body_names);
    file_->put("poses/joints", names);
    bodies_ = file_->add("poses/root_from_body", ArrayType::f64, {objects_.body_names.size(), 4, 4});
    target_ = file_->add("poses/target_m", ArrayType::f64, {3});
    joints_ = file_->add("poses/joints_rad", ArrayType::f64, {names.size()});
  }
  if (config_.imu) {
    imu_t_ = file_->add("imu/t_us", ArrayType::i64, {});
    gyroscope_ = file_->add("imu/gyroscope_rad_s", ArrayType::f64, {3});
    accelerometer_ = file_->add("imu/accelerometer_m_s2", ArrayType::f64, {3});
  }
  if (config_.camera) {
    add_camera("left", {scenario_.sim.camera, scenario_.sim.mount});
    if (eyes_ > 1) add_camera("right", scenario_.sim.right);
  }
}

void GroundTruthRecorder::add_camera(const std::string& eye, const MountedCamera& mounted) {
  const Camera& c = mounted.camera;
  const std::string group = eye + "/camera/";
  const auto put = [&](const std::string& name, const std::vector<double>& values,
                       const std::vector<std::size_t>& shape) {
    const std::size_t array = file_->add(group + name, ArrayType::f64, shape);
    file_->append(array, std::span<const double>(values));
  };
  put("matrix", {c.fx_px, 0.0, c.cx_px, 0.0, c.fy_px, c.cy_px, 0.0, 0.0, 1.0}, {3});
  if (c.lens == LensModel::fisheye) {
    put("distortion", {c.k1, c.k2, c.k3, c.k4}, {});
  } else {
    put("distortion", {c.k1, c.k2, c.p1, c.p2, c.k3}, {});
  }
  file_->put(group + "lens", {std::string(word_of(c.lens))});
  put("size_px", {static_cast<double>(c.size.width), static_cast<double>(c.size.height)}, {});
  const RowMajor4 pose = mounted.mount.eye_from_camera().matrix();
  put("eye_from_camera", std::vector<double>(pose.data(), pose.data() + pose.size()), {4});
}

void GroundTruthRecorder::on_tick(const Tick& tick) {
  const auto begin = std::chrono::steady_clock::now();
  if (config_.imu) {
    ImuReading reading;
    robot_.read_imu(reading);
    file_->append(imu_t_, std::span<const std::int64_t>(&reading.t_us, 1));
    append(*file_, gyroscope_, reading.angular_velocity_rad_s);
    append(*file_, accelerometer_, reading.acceleration_m_s2);
  }
  if (config_.flow) {
    WorldPoses now = poses_of(robot_.world());
    if (instant_) write_flow(now);
    if (is_instant(tick.t_us)) {
      before_ = last_ ? last_ : now;
      instant_ = now;
    }
    last_ = std::move(now);
  }
  if (config_.frames) expose(tick.t_us);
  if (is_instant(tick.t_us)) write_instant();
  wall_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void GroundTruthRecorder::write_instant() {
  const std::int64_t t_us = robot_.now_us();
  file_->append(t_, std::span<const std::int64_t>(&t_us, 1));
  for (std::size_t eye = 0; eye < eyes_; ++eye) {
    const EyeArrays& arrays = arrays_.at(eye);
    if (config_.images) {
      if (!config_.frames) robot_.draw_luminance(eye, luminance_.at(eye));  // else expose() has drawn it
      file_->append(arrays.image, std::span<const float>(luminance_.at(eye)));
    }
    TrueImage& image = images_.at(eye);
    if (config_.depth || config_.flow || config_.segmentation) robot_.draw_truth(eye, image);
    if (config_.depth) file_->append(arrays.depth, std::span<const float>(image.depth_m));
    if (!config_.segmentation) continue;
    std::vector<std::uint8_t> numbers(pixels_);
    std::ranges::transform(image.geom, numbers.begin(), [&](std::int32_t geom) {
      return geom < 0 ? std::uint8_t{0} : objects_.number_of_geom[static_cast<std::size_t>(geom)];
    });
    file_->append(arrays.segmentation, std::span<const std::uint8_t>(numbers));
  }
  if (config_.frames) write_frames();
  if (config_.poses) write_poses();
}

void GroundTruthRecorder::write_poses() {
  const WorldPoses poses = poses_of(robot_.world());
  for (std::size_t eye = 0; eye < eyes_; ++eye)
    append(*file_, arrays_.at(eye).pose, RowMajor4(poses.root_from_camera.at(eye).matrix()));
  std::vector<double> bodies;
  for (const Eigen::Isometry3d& pose : poses.root_from_body) {
    const RowMajor4 matrix = pose.matrix();
    bodies.insert(bodies.end(), matrix.data(), matrix.data() + matrix.size());
  }
  file_->append(bodies_, std::span<const double>(bodies));
  append(*file_, target_, robot_.world().target_position_m());
  append(*file_, joints_, robot_.limits().head->in_order(robot_.world().joints_rad()));
}

void GroundTruthRecorder::write_flow(const WorldPoses& after) {
  for (std::size_t eye = 0; eye < eyes_; ++eye) {
    const Camera& camera = eye == 0 ? scenario_.sim.camera : scenario_.sim.right.camera;
    optical_flow(camera, images_.at(eye), robot_.world().model(), eye, *before_, *instant_, after, flow_,
                 camera_flow_);
    file_->append(arrays_.at(eye).flow, std::span<const float>(flow_));
    file_->append(arrays_.at(eye).camera_flow, std::span<const float>(camera_flow_));
  }
  instant_.reset();
}

/// Adds the luminance of now to the frames that end within the exposure from now.
void GroundTruthRecorder::expose(std::int64_t t_us) {
  const std::int64_t period_us = config_.period_us();
  const std::int64_t to_end_us = (period_us - t_us % period_us) % period_us;
  if (to_end_us >= 1000 * config_.frames->exposure_ms) return;
  for (std::size_t eye = 0; eye < eyes_; ++eye) {
    robot_.draw_luminance(eye, luminance_.at(eye));
    for (std::size_t i = 0; i < pixels_; ++i)
      exposed_.at(eye)[i] += static_cast<double>(luminance_.at(eye)[i]);
  }
  ++exposures_;
}

void GroundTruthRecorder::write_frames() {
  constexpr double white = 255.0;
  for (std::size_t eye = 0; eye < eyes_; ++eye) {
    std::vector<std::uint8_t> frame(pixels_);
    for (std::size_t i = 0; i < pixels_; ++i) {
      const double luminance = exposed_.at(eye)[i] / static_cast<double>(exposures_);
      const double shot = config_.frames->shot_noise * std::sqrt(std::max(luminance, 0.0) / white);
      const double deviation = std::hypot(shot, config_.frames->read_noise);
      const double grey = luminance + deviation * noise_.normal(2 * i + eye, frames_);
      frame[i] = static_cast<std::uint8_t>(std::lround(std::clamp(grey, 0.0, white)));
      exposed_.at(eye)[i] = 0.0;
    }
    file_->append(arrays_.at(eye).frame, std::span<const std::uint8_t>(frame));
  }
  exposures_ = 0;
  ++frames_;
}

void GroundTruthRecorder::commit() {
  if (instant_) write_flow(*instant_);  // of the last millisecond
  file_->commit();
}

}  // namespace saccade
