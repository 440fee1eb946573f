#pragma once

#include <string>

#include "sim/triangle_mesh.h"

namespace saccade {

/// Reads a mesh from a file, by its extension: OBJ (triangles and polygons, which become fans; texture coordinates;
/// materials and groups are skipped) or STL (binary and text). Coordinates are multiplied by `scale` to give metres.
/// Throws InputError, with the line of a text file: for a missing file, other extensions, files above 64 MB, indices
/// and numbers that are wrong, a mesh smaller than 1 mm or larger than 5 m, and as check_surface().
[[nodiscard]] TriangleMesh read_mesh_file(const std::string& path, double scale);

}  // namespace saccade
