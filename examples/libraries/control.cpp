// The least that uses saccade::control.
#include <saccade/control/head_kinematics.h>

#include <cstdio>

int main() {
  const Eigen::Isometry3d root_from_eye = saccade::root_from_left_cam(saccade::JointVector::Zero());
  std::printf("control: the left eye is %.3f m above the root\n", root_from_eye.translation().z());
}
