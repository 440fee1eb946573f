#pragma once

#include "sim/eye_renderer.h"
#include "sim/scene_renderer.h"
