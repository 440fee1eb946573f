#pragma once

#include <filesystem>

#include "config/yaml_tree.h"

namespace saccade {

/// Reads a calibration file as the tree of one of `saccade calibrate`. Files of other programs, told apart by their keys, give
/// the section `calibration` without a mount; each value keeps the place of the one that it comes from:
///   OpenCV    cv::FileStorage in YAML: camera_matrix (cameraMatrix, Camera_Matrix), distortion_coefficients (distCoeffs,
///             dist_coeffs, Distortion_Coefficients), image_width, image_height; fisheye where `fisheye_model` is 1
///   ROS       sensor_msgs/CameraInfo as camera_calibration_parsers writes it: the same keys and distortion_model, plumb_bob,
///             rational_polynomial, equidistant or fisheye; matrices of the rectified image are left out, as events are of the
///             raw one
///   Kalibr    camchain: cam0, cam1, each with camera_model pinhole, distortion_model radtan, equidistant or none, intrinsics,
///             distortion_coeffs, resolution; T_cn_cnm1 and T_cam_imu are left out. `camera` is 0 for the left, 1 for the right
///             camera, which is cam1 where the file has one
/// Camera has k1, k2, p1, p2, k3 of the radial-tangential lens: other coefficients, a skew, or values for the wrong model are
/// problems of the tree. Throws InputError for a file that is none of these.
[[nodiscard]] YamlTree read_calibration_file(const std::filesystem::path& path, int camera);

}  // namespace saccade
