// Calibration files of OpenCV, ROS and Kalibr.
#include <opencv2/calib3d.hpp>
#include <opencv2/core/persistence.hpp>

#include "config/scenario.h"
#include "tests/config/built_in.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

const cv::Matx33d matrix(201.5, 0, 171.25, 0, 200.75, 128.5, 0, 0, 1);

/// As `camera_calibration_parsers` of ROS writes it.
std::string camera_info(const std::string& model, int coefficients, const std::string& data) {
  return "image_width: 346\nimage_height: 260\ncamera_name: davis\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
         "  data: [201.5, 0, 171.25, 0, 200.75, 128.5, 0, 0, 1]\ndistortion_model: " +
         model + "\ndistortion_coefficients:\n  rows: 1\n  cols: " + std::to_string(coefficients) +
         "\n  data: " + data +
         "\nrectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"
         "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [190, 0, 172, 0, 0, 195, 129, 0, 0, 0, 1, 0]\n";
}

/// A camera of a camchain of Kalibr.
std::string kalibr_camera(const std::string& name, const std::string& model, const std::string& coefficients,
                          const std::string& intrinsics = "[201.5, 200.75, 171.25, 128.5]") {
  return name + ":\n" +
         (name == "cam1" ? "  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, -0.068]\n  - [0.0, 1.0, 0.0, 0.001]\n"
                           "  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n"
                         : "") +
         "  cam_overlaps: []\n  camera_model: pinhole\n  distortion_coeffs: " + coefficients +
         "\n  distortion_model: " + model + "\n  intrinsics: " + intrinsics +
         "\n  resolution: [346, 260]\n  rostopic: /dvs/image_raw\n";
}

/// What cv::FileStorage of OpenCV 2.4 writes.
const std::string opencv_2 = R"(%YAML:1.0
calibration_time: "Fri 27 Nov 2026 10:00:00"
image_Width: 346
image_Height: 260
# flags: +fix_k3
flags: 128
Camera_Matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 2.0150000000000000e+002, 0., 1.7125000000000000e+002, 0.,
       2.0075000000000000e+002, 1.2850000000000000e+002, 0., 0., 1. ]
Distortion_Coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ -3.1000000000000000e-001, 1.1000000000000000e-001, 1.5e-003,
       -2.0e-003, 0. ]
)";

class CalibrationFile : public testing::Test {
 protected:
  [[nodiscard]] Camera read(const std::string& text, int camera = 0) const {
    return read_calibration(folder_.write("camera.yaml", text), camera).camera;
  }
  [[nodiscard]] std::string message(const std::string& text, int camera = 0) const {
    try {
      static_cast<void>(read(text, camera));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }
  /// What cv::FileStorage of the OpenCV here writes.
  [[nodiscard]] Camera read_as_opencv_writes(const cv::Mat& coefficients, int fisheye) const {
    const std::string name = (folder_ / "opencv.yml").string();
    {
      cv::FileStorage file(name, cv::FileStorage::WRITE);
      file << "calibration_time"
           << "Fri Nov 27 10:00:00 2026"
           << "image_width" << 346 << "image_height" << 260;
      file << "flags" << 0 << "fisheye_model" << fisheye;
      file << "camera_matrix" << cv::Mat(matrix) << "distortion_coefficients" << coefficients;
      file << "avg_reprojection_error" << 0.125 << "image_points"
           << cv::Mat(3, 35, CV_32FC2, cv::Scalar(1, 2));
    }
    return read_calibration(name).camera;
  }
  TempFolder folder_;
};

/// The largest distance, px, between the projections of the camera and of OpenCV, for points on the rays of pixels all over
/// the image.
double worst_px(const Camera& camera, const std::vector<double>& coefficients, bool fisheye) {
  std::vector<cv::Point3d> points;
  for (int y = 0; y < 260; y += 3) {
    for (int x = 0; x < 346; x += 3) {
      const Eigen::Vector3d point = (0.2 + 1e-3 * x) * camera.ray(x, y);
      points.emplace_back(point.x(), point.y(), point.z());
    }
  }
  std::vector<cv::Point2d> seen;
  if (fisheye) {
    cv::fisheye::projectPoints(points, seen, cv::Vec3d(), cv::Vec3d(), matrix, coefficients);
  } else {
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), matrix, coefficients, seen);
  }
  double worst = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto pixel = camera.project({points[i].x, points[i].y, points[i].z});
    if (!pixel) return std::numeric_limits<double>::infinity();
    worst = std::max(worst, (*pixel - Eigen::Vector2d(seen[i].x, seen[i].y)).norm());
  }
  return worst;
}

TEST_F(CalibrationFile, OfOpenCvRosAndKalibrProjectsAsOpenCvProjects) {
  const std::vector<double> radial = {-0.31, 0.11, 0.0015, -0.002, 0.0};
  const std::string list = "[-0.31, 0.11, 0.0015, -0.002";
  const Camera expected{{346, 260}, 201.5, 200.75, 171.25, 128.5, -0.31, 0.11, 0.0015, -0.002};
  for (const Camera& camera : {read_as_opencv_writes(cv::Mat(radial).clone(), 0), read(opencv_2),
                               read(camera_info("plumb_bob", 5, list + ", 0]")),
                               read(camera_info("rational_polynomial", 8, list + ", 0, 0.0, 0, 0]")),
                               read(kalibr_camera("cam0", "radtan", list + "]"))}) {
    EXPECT_EQ(camera, expected);
    EXPECT_LT(worst_px(camera, radial, false), 1e-9);
  }

  const std::vector<double> with_k3 = {-0.31, 0.11, 0.0015, -0.002, -0.01};
  for (const Camera& camera : {read_as_opencv_writes(cv::Mat(with_k3).clone(), 0),
                               read(camera_info("plumb_bob", 5, "[-0.31, 0.11, 0.0015, -0.002, -0.01]"))}) {
    EXPECT_EQ(camera.k3, -0.01);
    EXPECT_LT(worst_px(camera, with_k3, false), 1e-9);
  }

  const std::vector<double> fisheye = {-0.04, 0.012, -0.006, 0.001};
  const Camera wide{{346, 260},         201.5,  200.75, 171.25, 128.5, -0.04, 0.012, 0.0, 0.0,
                    LensModel::fisheye, -0.006, 0.001};
  for (const Camera& camera : {read_as_opencv_writes(cv::Mat(fisheye).clone(), 1),
                               read(camera_info("equidistant", 4, "[-0.04, 0.012, -0.006, 0.001]")),
                               read(camera_info("fisheye", 4, "[-0.04, 0.012, -0.006, 0.001]")),
                               read(kalibr_camera("cam0", "equidistant", "[-0.04, 0.012, -0.006, 0.001]"))}) {
    EXPECT_EQ(camera, wide);
    EXPECT_LT(worst_px(camera, fisheye, true), 1e-9);
  }

  const Camera pinhole = read(kalibr_camera("cam0", "none", "[]"));
  EXPECT_EQ(pinhole, (Camera{{346, 260}, 201.5, 200.75, 171.25, 128.5}));
  EXPECT_LT(worst_px(pinhole, {0.0, 0.0, 0.0, 0.0}, false), 1e-9);
}

TEST_F(CalibrationFile, OfKalibrHasTheRightCameraInCam1WhereItHasOne) {
  const std::string left = kalibr_camera("cam0", "radtan", "[-0.3, 0.1, 0.001, -0.002]");
  const std::string both = left + kalibr_camera("cam1", "radtan", "[-0.1, 0, 0, 0]", "[202, 203, 170, 129]");
  EXPECT_EQ(read(both, 0).k1, -0.3);
  EXPECT_EQ(read(both, 1).k1, -0.1);
  EXPECT_EQ(read(both, 1).fy_px, 203.0);
  EXPECT_EQ(read(left, 1).k1, -0.3);

  const auto scene =
      folder_.write("scene.yaml",
                    "name: a\nrun: {duration_s: 1}\nball: {trajectory: {kind: hold}}\neyes: both\n"
                    "camera: {preset: davis346}\ndetectors: {paper_full: {}}\n"
                    "gaze: {detector: none}\ncalibration: {file: chain.yaml}\n"
                    "right_calibration: {file: chain.yaml}\n");
  folder_.write("chain.yaml", both);
  const Scenario scenario = read_scenario(scene, {}, std::nullopt, built_in());
  EXPECT_EQ(scenario.calibration.camera, read(both, 0));
  EXPECT_EQ(scenario.right_calibration.camera, read(both, 1));
  EXPECT_EQ(scenario.calibration.mount, CameraMount{});
}

std::string with(std::string text, const std::string& what, const std::string& by) {
  const std::size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

TEST_F(CalibrationFile, WithALensThatSaccadeDoesNotHaveIsRefusedWithItsPlace) {
  const std::string list = "[-0.3, 0.1, 0.001, -0.002";
  EXPECT_THAT(message(camera_info("rational_polynomial", 8, list + ", 0, 0, 0.5, 0]")),
              AllOf(HasSubstr("camera.yaml:12: distortion_coefficients: found k5 of 0.5, expected 0: "),
                    Not(HasSubstr("\n"))));
  EXPECT_THAT(message(camera_info("thin_prism", 4, list + "]")),
              HasSubstr("camera.yaml:8: distortion_model: found thin_prism, expected plumb_bob, "));
  EXPECT_THAT(message(camera_info("equidistant", 5, list + ", 0]")),
              HasSubstr("camera.yaml:9: distortion_coefficients: found 5 numbers, expected 4"));
  EXPECT_THAT(message(with(opencv_2, "flags: 128", "xi: 0.8")),
              HasSubstr("camera.yaml:6: xi: found 0.8, expected no such key"));
  EXPECT_THAT(message(with(opencv_2, "flags: 128", "fisheye_model: yes")),
              HasSubstr("camera.yaml:6: fisheye_model: found yes, expected 0 or 1"));
  EXPECT_THAT(message(with(opencv_2, "data: [ 2.0150000000000000e+002, 0.,",
                           "data: [ 2.0150000000000000e+002, 0.25,")),
              HasSubstr("camera.yaml:11: Camera_Matrix: found 0.25, expected a skew of 0"));
  const std::string chain = kalibr_camera("cam0", "radtan", list + "]");
  for (const char* model : {"omni", "ds", "eucm"}) {
    EXPECT_THAT(
        message(with(chain, "camera_model: pinhole", std::string("camera_model: ") + model)),
        HasSubstr(std::string("camera.yaml:3: cam0.camera_model: found ") + model + ", expected pinhole"));
  }
  EXPECT_THAT(
      message(with(chain, "radtan", "fov")),
      HasSubstr("camera.yaml:5: cam0.distortion_model: found fov, expected radtan, equidistant or none"));
  EXPECT_THAT(message(with(chain, list + "]", list + ", 0.0]")),
              HasSubstr("camera.yaml:4: cam0.distortion_coeffs: found 5 numbers, expected 4"));
}

TEST_F(CalibrationFile, WithAValueThatIsWrongOrMissingIsRefusedWithItsPlace) {
  EXPECT_THAT(
      message(with(opencv_2, "2.0150000000000000e+002", ".Nan")),
      HasSubstr("camera.yaml:11: calibration.fx_px: found .Nan (not finite), expected a finite number"));
  EXPECT_THAT(message(with(opencv_2, "-3.1000000000000000e-001", "-.Inf")),
              HasSubstr("camera.yaml:17: calibration.k1: found -.Inf (not finite)"));
  EXPECT_THAT(message(with(opencv_2, "image_Width: 346\n", "")),
              AllOf(HasSubstr("camera.yaml:2: image_width: found no such key, expected the width"),
                    Not(HasSubstr("calibration"))));
  EXPECT_THAT(
      message(with(opencv_2, "   cols: 3", "   cols: 2")),
      HasSubstr("camera.yaml:7: Camera_Matrix: found 9 numbers, expected 3 x 2, as rows and cols say"));
  EXPECT_THAT(message(with(opencv_2, "0., 0., 1. ]", "0., 0. ]")),
              HasSubstr("Camera_Matrix: found 8 numbers, expected 3 x 3"));
  EXPECT_THAT(message(with(opencv_2, "0., 0., 1. ]", "0., 0., 2. ]")),
              HasSubstr("camera.yaml:12: Camera_Matrix: found 2., expected [fx 0 cx; 0 fy cy; 0 0 1]"));
  EXPECT_THAT(message(with(opencv_2, "Distortion_Coefficients", "Distortion")),
              HasSubstr("distortion_coefficients: found no such key"));
  EXPECT_THAT(
      message(with(camera_info("plumb_bob", 3, "[0, 0, 0]"), "image_width: 346", "image_width: 3460")),
      AllOf(
          HasSubstr("camera.yaml:1: calibration.width_px: found 3460, expected a whole number in [8, 2048]"),
          HasSubstr("distortion_coefficients: found 3 numbers, expected 4, 5, 8")));
  EXPECT_THAT(message(with(camera_info("plumb_bob", 4, "[0, 0, 0, 0]"), "  data: [0, 0, 0, 0]", "  data: 0")),
              AllOf(HasSubstr("distortion_coefficients: found a block of keys, expected a list of numbers"),
                    Not(HasSubstr("\n"))));
  EXPECT_THAT(
      message(camera_info("plumb_bob", 4, "[-9, 0, 0, 0]")),
      HasSubstr(
          "camera.yaml:12: calibration.k1: found -9, expected with k2, k3, p1 and p2 a lens that can be"));
  const std::string chain = kalibr_camera("cam0", "radtan", "[0, 0, 0, 0]");
  EXPECT_THAT(message(with(chain, "[346, 260]", "[346]")),
              HasSubstr("camera.yaml:7: cam0.resolution: found 1 number, expected 2"));
  EXPECT_THAT(message(with(chain, "200.75", "wide")),
              HasSubstr("camera.yaml:6: calibration.fy_px: found wide, expected a finite number"));
  EXPECT_THAT(message(with(chain, "pinhole", "[pinhole]")),
              HasSubstr("camera.yaml:3: cam0.camera_model: found a list, expected pinhole"));
  EXPECT_THAT(message(with(chain, "[0, 0, 0, 0]", "0")),
              AllOf(HasSubstr("camera.yaml:4: cam0.distortion_coeffs: found 0, expected a list of numbers"),
                    Not(HasSubstr("\n"))));
  for (const char* key :
       {"camera_model", "distortion_model", "distortion_coeffs", "intrinsics", "resolution"}) {
    EXPECT_THAT(message(with(chain, key, std::string("no_") + key)),
                AllOf(HasSubstr(std::string("camera.yaml:1: cam0.") + key + ": found no such key"),
                      Not(HasSubstr("\n"))));
  }
  EXPECT_THAT(message(kalibr_camera("cam1", "radtan", "[0, 0, 0, 0]")),
              HasSubstr("camera.yaml:1: cam0: found no such key"));
  EXPECT_THAT(
      message("M1: {rows: 3}\nD1: [0]\n"),
      HasSubstr("camera.yaml: found the keys M1, D1, expected calibration (a file of saccade calibrate), "));
  EXPECT_THAT(message("<?xml version=\"1.0\"?>\n<opencv_storage>\n"), HasSubstr("camera.yaml:1"));
}

}  // namespace
}  // namespace saccade
