#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/camera.h"
#include "evaluation/calibration/calibration_views.h"
#include "evaluation/calibration/grid_finder.h"

namespace saccade {

/// The least that a calibration must reach; calibrate() throws where it does not.
struct CalibrationLimits {
  std::size_t min_views = 15;
  std::size_t max_views = 100;   ///< of those found, the slowest and best spread
  double max_speed_px_s = 10.0;  ///< of the fastest dot in a view that counts
  double min_covered = 0.7;      ///< share of the cells of a 5 x 5 raster over the image with a dot in them
  double min_tilt_spread_deg = 20.0;  ///< largest angle between the board's normals in two views
  double max_rms_px = 0.5;            ///< of the distance between dots and their projection
  double max_focal_deviation = 0.01;  ///< standard deviation of fx and fy against their value
  double max_centre_deviation_px = 1.0;
  double max_translation_deviation_mm = 1.0;
  double max_rotation_deviation_deg = 0.2;
  std::size_t min_rests = 3;  ///< poses at which the board rested, each with min_views_of_rest views
  std::size_t min_views_of_rest = 4;
};

/// Standard deviations, in the units of Camera and CameraMount.
struct CalibrationDeviations {
  double fx_px = 0.0, fy_px = 0.0, cx_px = 0.0, cy_px = 0.0, k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0;
  double k3 = 0.0, k4 = 0.0;
  std::array<double, 3> translation_mm{};
  std::array<double, 3> rotation_deg{};
};

/// The data of a calibration and how well it fits.
struct CalibrationQuality {
  std::int64_t views = 0;
  double rms_px = 0.0;   ///< of the distance between dots and their projection, each view with its own pose
  double covered = 0.0;  ///< share of a 5 x 5 raster over the image
  double max_angle_deg = 0.0;  ///< between a dot and the optical axis
  std::int64_t held =
      0;  ///< the last of k1 to k4 of a fisheye that the dots do not tell from 0, and which are 0
  double tilt_spread_deg = 0.0;
  std::int64_t rests = 0;  ///< poses of the resting board; 0: the mount was not calibrated
  double rms_at_rest_px =
      0.0;  ///< the same, with one pose for each rest, the head's joints and eye_from_camera
};

struct Calibration {
  MountedCamera camera;  ///< its mount is the identity where quality.rests is 0
  CalibrationDeviations deviations;
  CalibrationQuality quality;
};

/// Keys: calibration with those of MountedCamera, deviations and quality with their members'.
void describe(FieldVisitor& v, Calibration& calibration);

/// Calibrates a camera and, where the views have the eye's pose and `with_mount`, its mount in the eye.
///
/// Lens: least squares (BoardFit) over the dots of all views, each view with a pose of its own, from
/// start_of_lens(); a dot is compared with the centroid of the projected disc. A fisheye's k4, then k3, k2, k1 are held at 0
/// where they are within three deviations of it, or the lens would turn back inside the image. Mount: least squares over mount
/// and one pose of the board in the root frame for each rest, a series of views in which the board stays where it is;
/// first with that lens, then with the lens free too. The second result is taken where its rms is at most 1.5 times
/// that of free poses. Deviations (BoardFit::deviations()) do not contain errors that all views share, such as a lag of
/// the events. Throws RunError with what was found and what is missing where a limit is not kept.
[[nodiscard]] Calibration calibrate(const std::vector<CalibrationView>& views, const DotGrid& grid,
                                    ImageSize size, LensModel lens, bool with_mount,
                                    const CalibrationLimits& limits = {});

}  // namespace saccade
