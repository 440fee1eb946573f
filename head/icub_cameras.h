#pragma once

#include "core/camera.h"

/// The event cameras of the iCub of the paper: iCubGenova02, DVS128 in both eyes (icubEyes_DVS.ini, 2016).
namespace saccade {

inline constexpr Camera icub_left_2016{{128, 128}, 99.45,   99.75,      64.00,     69.18,
                                       -0.207651,  0.73946, -0.0016571, -0.0059468};
inline constexpr Camera icub_right_2016{{128, 128}, 99.8,     99.8,        59.336,     63.761,
                                        -0.219021,  0.085382, -0.00071211, -0.00171136};

}  // namespace saccade
