// The least that uses saccade::control.
#include <saccade/control/head_kinematics.h>

#include <cstdio>

int main() {
  const Eigen::Isometry3d root_from_eye =
      saccade::HeadKinematics(saccade::default_head()->chain, saccade::JointVector::Zero())
          .root_from_eye(saccade::Eye::left);
  std::printf("control: the left eye is %.3f m above the root\n", root_from_eye.translation().z());
}
