#pragma once

#include <string>

#include "config/scenario.h"
#include "config/yaml_tree.h"

namespace saccade {

/// Draws the world that the section `world` of a scenario's tree asks for, and sets it as the values that keys which the
/// tree lacks will have. The draw follows what the tree says of seed, world and camera; values that are refused count as
/// absent. `scenario` has its detectors and controllers. Throws InputError for a file that cannot be read.
void draw_defaults(const YamlTree& tree, const std::string& folder, Scenario& scenario);

}  // namespace saccade
