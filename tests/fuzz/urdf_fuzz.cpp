// Any bytes as a robot in URDF: it has the chain of a head, with finite numbers, or gives an InputError, nothing else. The first
// byte chooses what is asked for.
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "config/urdf_head.h"
#include "core/error.h"

namespace saccade {
namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

void require_placed(const PlacedJoint& joint) {
  require(std::abs(joint.axis.norm() - 1.0) < 1e-6);
  require(joint.point_m.allFinite());
  require(!(joint.max_rad <= joint.min_rad));
  for (const double value : {joint.min_rad, joint.max_rad, joint.max_speed_rad_s})
    require(!std::isinf(value));
}

}  // namespace
}  // namespace saccade

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace saccade;
  static const std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("urdf_fuzz_" + std::to_string(getpid()) + ".urdf");
  if (size == 0) return 0;
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(data + 1), static_cast<std::streamsize>(size - 1));
  ChainRequest request{path.string(), {"pan", "tilt"}, "camera"};
  if ((data[0] & 1) != 0) request.right_camera = "right";
  if ((data[0] & 2) != 0) request.base = "base";
  request.optical = (data[0] & 4) == 0;
  PlacedChain chain;
  try {
    chain = chain_of_urdf(request);
  } catch (const InputError&) {
    return 0;
  }
  std::size_t joints = 0;
  for (const auto* part : {&chain.common, &chain.eye[0], &chain.eye[1]}) {
    for (const PlacedJoint& joint : *part) require_placed(joint);
    joints += part->size();
  }
  require(joints == request.joints.size());
  for (const Eigen::Isometry3d& camera : chain.root_from_camera) require(camera.matrix().allFinite());
  const HeadDescription head = description_of(chain, "fuzz");
  require(head.joints.size() == joints);
  return 0;
}
