#include "shape/hull.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace polhode {
namespace {

using Points = std::span<const Eigen::Vector3d>;

// Least distance of a point from a face that it sees, relative to the cloud's size. Chosen: 5e4
// times the rounding of a double, so that rounding does not tear the surface, and far below any
// tolerance.
constexpr double kRounding = 1e-11;
// Passes at most. A point can be missed when faces move; the next pass finds it. Chosen: the loop
// ends with the first pass without such a point.
constexpr int kPasses = 4;

double distance(const HullWork::Facet& facet, const Eigen::Vector3d& point_T) {
  return facet.normal.dot(point_T) - facet.offset;
}

HullWork::Facet facet_through(Points points_T, std::uint16_t a, std::uint16_t b, std::uint16_t c) {
  HullWork::Facet facet{.corners = {a, b, c}, .used = true};
  const Eigen::Vector3d normal = (points_T[b] - points_T[a]).cross(points_T[c] - points_T[a]);
  // Collinear corners give a face without a normal, which no point lies beyond.
  if (normal.norm() > 0.0) {
    facet.normal = normal.normalized();
    facet.offset = facet.normal.dot(points_T[a]);
  }
  return facet;
}

/// Index of the point for which `measure` is greatest, the first of equals.
template <typename Measure>
std::uint16_t farthest(Points points_T, const Measure& measure) {
  std::size_t best = 0;
  double most = -1.0;
  for (std::size_t i = 0; i < points_T.size(); ++i) {
    const double value = measure(points_T[i]);
    if (value > most) {
      most = value;
      best = i;
    }
  }
  return static_cast<std::uint16_t>(best);
}

/// Four points that enclose a volume. False where all lie within `tolerance` of a plane.
bool first_corners(Points points_T, double tolerance, std::array<std::uint16_t, 4>* corners) {
  const Eigen::Vector3d start = points_T[0];
  std::uint16_t& a = (*corners)[0];
  std::uint16_t& b = (*corners)[1];
  std::uint16_t& c = (*corners)[2];
  std::uint16_t& d = (*corners)[3];
  a = farthest(points_T, [&](const Eigen::Vector3d& p) { return (p - start).norm(); });
  b = farthest(points_T, [&](const Eigen::Vector3d& p) { return (p - points_T[a]).norm(); });
  const Eigen::Vector3d along = points_T[b] - points_T[a];
  if (!(along.norm() > tolerance)) {
    return false;
  }
  const auto off_line = [&](const Eigen::Vector3d& p) {
    return along.normalized().cross(p - points_T[a]).norm();
  };
  c = farthest(points_T, off_line);
  if (!(off_line(points_T[c]) > tolerance)) {
    return false;
  }
  const Eigen::Vector3d normal = along.cross(points_T[c] - points_T[a]).normalized();
  const auto off_plane = [&](const Eigen::Vector3d& p) {
    return std::abs(normal.dot(p - points_T[a]));
  };
  d = farthest(points_T, off_plane);
  if (normal.dot(points_T[d] - points_T[a]) > 0.0) {
    std::swap(b, c);  // the first face looks away from the fourth corner
  }
  return off_plane(points_T[d]) > tolerance;
}

/// Stores for a point the facet beyond which it lies farthest.
template <typename Facets>
void assign(Points points_T, std::size_t i, const Facets& facets, HullWork& work) {
  work.outside_of[i] = HullWork::kNoFacet;
  work.beyond[i] = 0.0;
  for (const std::size_t f : facets) {
    const double beyond = work.facets[f].used ? distance(work.facets[f], points_T[i]) : 0.0;
    if (beyond > work.beyond[i]) {
      work.beyond[i] = beyond;
      work.outside_of[i] = static_cast<std::uint16_t>(f);
    }
  }
}

std::array<std::size_t, Hull::kFaces> all_facets() {
  std::array<std::size_t, Hull::kFaces> all{};
  for (std::size_t f = 0; f < all.size(); ++f) {
    all[f] = f;
  }
  return all;
}

void start(Points points_T, const std::array<std::uint16_t, 4>& corners, HullWork& work) {
  const auto [a, b, c, d] = corners;
  for (HullWork::Facet& facet : work.facets) {
    facet.used = false;
  }
  work.facets[0] = facet_through(points_T, a, b, c);
  work.facets[1] = facet_through(points_T, a, d, b);
  work.facets[2] = facet_through(points_T, b, d, c);
  work.facets[3] = facet_through(points_T, c, d, a);
  work.facets_used = 4;
}

void assign_all(Points points_T, HullWork& work) {
  const auto all = all_facets();
  for (std::size_t i = 0; i < points_T.size(); ++i) {
    assign(points_T, i, all, work);
  }
}

/// Marks the faces visible from the point and collects their horizon: edges with one visible face
/// only.
std::size_t find_horizon(const Eigen::Vector3d& point_T, double rounding, HullWork& work) {
  work.edges.clear();
  std::size_t visible = 0;
  for (HullWork::Facet& facet : work.facets) {
    facet.visible = facet.used && distance(facet, point_T) > rounding;
    if (facet.visible) {
      ++visible;
      for (std::size_t k = 0; k < 3; ++k) {
        POLHODE_ASSERT(
            work.edges.push_back({.from = facet.corners[k], .to = facet.corners[(k + 1) % 3]}),
            work.edges.size());
      }
    }
  }
  const auto key = [](const HullWork::Edge& e) {
    return std::pair(std::min(e.from, e.to), std::max(e.from, e.to));
  };
  std::sort(work.edges.begin(), work.edges.end(), [&](const auto& x, const auto& y) {
    return key(x) != key(y) ? key(x) < key(y) : x.from < y.from;
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < work.edges.size();) {
    const bool shared = i + 1 < work.edges.size() && key(work.edges[i]) == key(work.edges[i + 1]);
    if (!shared) {
      work.edges[kept++] = work.edges[i];
    }
    i += shared ? 2 : 1;
  }
  while (work.edges.size() > kept) {
    work.edges.pop_back();
  }
  return visible;
}

/// Replaces the visible faces by a cone from the horizon to the new corner, and assigns their
/// points again.
void add_cone(Points points_T, std::uint16_t corner, std::size_t visible, HullWork& work) {
  for (HullWork::Facet& facet : work.facets) {
    facet.used = facet.used && !facet.visible;
  }
  work.facets_used += work.edges.size() - visible;
  work.fresh.clear();
  std::size_t slot = 0;
  for (const HullWork::Edge& edge : work.edges) {
    while (work.facets[slot].used) {
      ++slot;
    }
    work.facets[slot] = facet_through(points_T, edge.from, edge.to, corner);
    POLHODE_ASSERT(work.fresh.push_back(static_cast<std::uint16_t>(slot)), slot);
  }
  // A reused slot still has the points of its former facet: they are assigned again, too.
  for (std::size_t i = 0; i < points_T.size(); ++i) {
    const std::size_t f = work.outside_of[i];
    const bool gone = f != HullWork::kNoFacet &&
                      (!work.facets[f].used ||
                       std::find(work.fresh.begin(), work.fresh.end(), f) != work.fresh.end());
    if (gone) {
      assign(points_T, i, work.fresh, work);
    }
  }
}

/// Adds the outermost points as corners. False when the tables are full.
bool grow(
    Points points_T, double tolerance, double rounding, std::size_t* corners, HullWork& work) {
  while (true) {
    const auto* outermost = std::max_element(work.beyond.begin(), work.beyond.end());
    if (*outermost <= tolerance) {
      return true;
    }
    const auto corner = static_cast<std::uint16_t>(outermost - work.beyond.begin());
    const std::size_t visible = find_horizon(points_T[corner], rounding, work);
    if (*corners >= Hull::kVertices ||
        work.facets_used - visible + work.edges.size() > Hull::kFaces) {
      return false;
    }
    ++*corners;
    add_cone(points_T, corner, visible, work);
  }
}

/// Corners numbered in the order of the cloud, faces in that of their slots.
Result<Hull> describe(Points points_T, const HullWork& work) {
  FixedVector<std::uint16_t, limits::kCloudPoints> number;
  number.resize(points_T.size());
  for (const HullWork::Facet& facet : work.facets) {
    for (const std::uint16_t corner : facet.corners) {
      number[corner] = facet.used ? 1 : number[corner];
    }
  }
  Hull hull;
  for (std::size_t i = 0; i < points_T.size(); ++i) {
    if (number[i] != 0) {
      number[i] = static_cast<std::uint16_t>(hull.vertices_T.size());
      POLHODE_ASSERT(hull.vertices_T.push_back(points_T[i]), i);
    }
  }
  const Eigen::Vector3d inside_T = hull.vertices_T[0];
  for (const HullWork::Facet& facet : work.facets) {
    if (!facet.used) {
      continue;
    }
    const auto [a, b, c] = facet.corners;
    POLHODE_ASSERT(hull.faces.push_back({number[a], number[b], number[c]}), hull.faces.size());
    const Eigen::Vector3d twice_area = (points_T[b] - points_T[a]).cross(points_T[c] - points_T[a]);
    hull.area += 0.5 * twice_area.norm();
    hull.volume += twice_area.dot(points_T[a] - inside_T) / 6.0;
  }
  hull.outside = *std::max_element(work.beyond.begin(), work.beyond.end());
  // Euler's formula for a closed surface without holes.
  if (2 * hull.vertices_T.size() != hull.faces.size() + 4 || !(hull.volume > 0.0)) {
    return ErrorCode::kDegenerate;
  }
  return hull;
}

}  // namespace

Result<Hull> convex_hull(Points points_T, double tolerance, HullWork& work) {
  POLHODE_ASSERT(tolerance > 0.0, tolerance);
  POLHODE_ASSERT(points_T.size() <= limits::kCloudPoints, points_T.size());
  if (points_T.size() < 4) {
    return ErrorCode::kTooFewObservations;
  }
  std::array<std::uint16_t, 4> corners{};
  if (!first_corners(points_T, tolerance, &corners)) {
    return ErrorCode::kDegenerate;
  }
  work.outside_of.clear();
  work.outside_of.resize(points_T.size());
  work.beyond.clear();
  work.beyond.resize(points_T.size());
  start(points_T, corners, work);
  const double rounding = kRounding * (points_T[corners[1]] - points_T[corners[0]]).norm();
  std::size_t count = corners.size();
  for (int pass = 0; pass < kPasses; ++pass) {
    assign_all(points_T, work);
    if (*std::max_element(work.beyond.begin(), work.beyond.end()) <= tolerance ||
        !grow(points_T, tolerance, rounding, &count, work)) {
      break;
    }
  }
  return describe(points_T, work);
}

}  // namespace polhode
