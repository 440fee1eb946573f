#include "sim/triangle_mesh.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>

#include "core/config.h"
#include "core/error.h"

namespace saccade {
namespace {

using Eigen::Vector3d;

constexpr double least_cosine_of_smooth_edges = 0.766;  // of 40 degrees

/// The index of the first point at the same place, for each point.
std::vector<int> welded(const std::vector<Vector3d>& points_m) {
  const auto key = [&](int i) {
    const Vector3d& p = points_m[static_cast<std::size_t>(i)];
    return std::array<double, 3>{p.x(), p.y(), p.z()};
  };
  std::vector<int> order(points_m.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    const auto ka = key(a);
    const auto kb = key(b);
    return ka != kb ? ka < kb : a < b;
  });
  std::vector<int> first(points_m.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    first[static_cast<std::size_t>(order[i])] =
        same ? first[static_cast<std::size_t>(order[i - 1])] : order[i];
  }
  return first;
}

/// The three points of each triangle, those at the same place as one; without triangles that have no area because two are.
std::vector<std::array<int, 3>> welded_triangles(const TriangleMesh& mesh) {
  const std::vector<int> first = welded(mesh.points_m);
  std::vector<std::array<int, 3>> triangles;
  triangles.reserve(mesh.triangles.size());
  for (const auto& corners : mesh.triangles) {
    std::array<int, 3> t{};
    for (std::size_t k = 0; k < 3; ++k) t[k] = first[static_cast<std::size_t>(corners[k].point)];
    if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) triangles.push_back(t);
  }
  return triangles;
}

std::string in_words(const Vector3d& p) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "(%.4g, %.4g, %.4g)", p.x(), p.y(), p.z());
  return text.data();
}

/// An edge as one triangle passes it.
struct Edge {
  std::array<int, 2> points;  ///< the smaller first
  bool forward;               ///< from the smaller to the larger
  friend auto operator<=>(const Edge&, const Edge&) = default;
};

/// Counts of edges that a closed manifold has not, each with the first of its kind.
struct EdgeFaults {
  std::size_t open = 0;
  std::size_t crowded = 0;
  std::size_t reversed = 0;
  std::array<std::array<int, 2>, 3> first{};
};

EdgeFaults faults_of(std::vector<Edge> edges) {
  std::sort(edges.begin(), edges.end());
  EdgeFaults faults;
  for (std::size_t begin = 0; begin < edges.size();) {
    std::size_t end = begin;
    while (end < edges.size() && edges[end].points == edges[begin].points) ++end;
    const std::size_t triangles = end - begin;
    const auto count = [&](std::size_t& counter, std::size_t kind) {
      if (counter++ == 0) faults.first[kind] = edges[begin].points;
    };
    if (triangles == 1) count(faults.open, 0);
    if (triangles > 2) count(faults.crowded, 1);
    if (triangles == 2 && edges[begin].forward == edges[begin + 1].forward) count(faults.reversed, 2);
    begin = end;
  }
  return faults;
}

Vector3d area_normal(const TriangleMesh& mesh, const std::array<TriangleMesh::Corner, 3>& t) {
  const auto at = [&](std::size_t k) -> const Vector3d& {
    return mesh.points_m[static_cast<std::size_t>(t[k].point)];
  };
  return (at(1) - at(0)).cross(at(2) - at(0));
}

}  // namespace

void check_surface(const TriangleMesh& mesh, const std::string& place) {
  if (mesh.triangles.size() > most_triangles) {
    throw InputError(place, std::to_string(mesh.triangles.size()) + " triangles",
                     "at most " + std::to_string(most_triangles));
  }
  const auto triangles = welded_triangles(mesh);
  if (triangles.empty())
    throw InputError(place, std::to_string(triangles.size()) + " triangles", "a surface");
  std::vector<Edge> edges;
  double volume_m3 = 0.0;
  const auto at = [&](int i) -> const Vector3d& { return mesh.points_m[static_cast<std::size_t>(i)]; };
  for (const auto& t : triangles) {
    volume_m3 += at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6.0;
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t[k];
      const int b = t[(k + 1) % 3];
      edges.push_back({{std::min(a, b), std::max(a, b)}, a < b});
    }
  }
  const EdgeFaults faults = faults_of(std::move(edges));
  const auto refuse = [&](std::size_t count, std::size_t kind, const std::string& what,
                          const char* expectation) {
    if (count == 0) return;
    const auto& [a, b] = faults.first[kind];
    throw InputError(place,
                     std::to_string(count) + " edges " + what + ", the first from " + in_words(at(a)) +
                         " to " + in_words(at(b)),
                     expectation);
  };
  refuse(faults.crowded, 1, "of three triangles or more",
         "a manifold surface, with two triangles at every edge");
  refuse(faults.open, 0, "of one triangle", "a closed surface, with two triangles at every edge");
  refuse(faults.reversed, 2, "whose two triangles face opposite sides",
         "triangles counterclockwise from outside");
  if (!(volume_m3 > 0.0)) {
    throw InputError(place, "a surface that is inside out or flat",
                     "triangles counterclockwise from outside");
  }
}

double sphere_radius_m(const TriangleMesh& mesh) {
  constexpr double tolerance = 0.03;
  if (mesh.triangles.empty()) return 0.0;
  double sum_m = 0.0;
  for (const auto& triangle : mesh.triangles) {
    for (const auto& corner : triangle) sum_m += mesh.points_m[static_cast<std::size_t>(corner.point)].norm();
  }
  const double radius_m = sum_m / (3.0 * static_cast<double>(mesh.triangles.size()));
  const auto is_on_sphere = [&](const Vector3d& p) {
    return std::abs(p.norm() - radius_m) <= tolerance * radius_m;
  };
  for (const auto& triangle : mesh.triangles) {
    Vector3d middle_m = Vector3d::Zero();
    for (const auto& corner : triangle) {
      const Vector3d& p = mesh.points_m[static_cast<std::size_t>(corner.point)];
      if (!is_on_sphere(p)) return 0.0;
      middle_m += p / 3.0;
    }
    if (!is_on_sphere(middle_m)) return 0.0;
  }
  return radius_m;
}

std::string mesh_mjcf(const TriangleMesh& mesh, const std::string& name) {
  const std::vector<int> first = welded(mesh.points_m);
  std::vector<Vector3d> area_normals;
  std::vector<std::vector<std::size_t>> triangles_at(mesh.points_m.size());
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    area_normals.push_back(area_normal(mesh, mesh.triangles[i]));
    if (!(area_normals.back().norm() > 0.0)) continue;
    kept.push_back(i);
    for (const auto& corner : mesh.triangles[i]) {
      triangles_at[static_cast<std::size_t>(first[static_cast<std::size_t>(corner.point)])].push_back(i);
    }
  }
  // A vertex of its own for every corner: MJCF has one normal and one texel for each vertex.
  std::string points;
  std::string normals;
  std::string texels;
  std::string faces;
  std::array<char, 96> text{};
  const auto print = [&text](std::string& to, const Vector3d& v) {
    to.append(text.data(), static_cast<std::size_t>(std::snprintf(text.data(), text.size(), "%.7g %.7g %.7g ",
                                                                  v.x(), v.y(), v.z())));
  };
  int count = 0;
  for (const std::size_t i : kept) {
    for (const auto& corner : mesh.triangles[i]) {
      const auto point = static_cast<std::size_t>(corner.point);
      Vector3d normal = Vector3d::Zero();
      for (const std::size_t other : triangles_at[static_cast<std::size_t>(first[point])]) {
        const double cosine = area_normals[i].normalized().dot(area_normals[other].normalized());
        if (cosine >= least_cosine_of_smooth_edges) normal += area_normals[other];
      }
      print(points, mesh.points_m[point]);
      print(normals, normal.normalized());
      if (mesh.has_texels()) {
        const Eigen::Vector2d texel = corner.texel < 0 ? Eigen::Vector2d(0.0, 0.0)
                                                       : mesh.texels[static_cast<std::size_t>(corner.texel)];
        texels.append(text.data(), static_cast<std::size_t>(std::snprintf(
                                       text.data(), text.size(), "%.7g %.7g ", texel.x(), texel.y())));
      }
    }
    faces += std::to_string(count) + " " + std::to_string(count + 1) + " " + std::to_string(count + 2) + " ";
    count += 3;
  }
  return "<mesh name=\"" + name + "\" vertex=\"" + points + "\" normal=\"" + normals + "\"" +
         (mesh.has_texels() ? " texcoord=\"" + texels + "\"" : "") + " face=\"" + faces + "\"/>\n";
}

}  // namespace saccade
