// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "render/spec/ray_spec_cutaway.hpp"

namespace nav::render {

/// A mesh that cuts, however many triangles it has: the surfaces of ray_spec_cutaway.hpp as by
/// meeting every triangle, up to rounding. A search over a tree visits only what may hold a better
/// point than the best so far, by two bounds of the function f of a cone:
/// - its greatest value over a ball is a closed form;
/// - where a surface is closed, f can be greatest only where its gradient, r - cot(theta) e with e
///   the direction away from the ray, is at right angles to the surface. So nodes also know a cone
///   that holds the normals of their triangles and of all that touch those.
/// Immutable; any number of threads.
class CutawayMesh {
 public:
  /// The last best triangles of a ray: where to look first for its neighbour. Any value is right.
  struct Hint {
    int at1 = 0;
    int at2 = 0;
  };

  /// origin_mm: of the volume's grid, CT mm. Precondition: a validated mesh.
  CutawayMesh(const MeshObject& mesh, const Eigen::Vector3d& origin_mm);

  /// Raises the span of a ray (of other objects; -infinity: none) to that with this mesh.
  void meet(const spec::Ray<double>& ray, double cot1, double cot2, Hint& hint,
            spec::CutawaySpan<double>& span) const;

  [[nodiscard]] std::size_t triangles() const { return triangles_.size(); }
  /// The greatest of at_least and where the surface of one angle meets a ray. hint: as in Hint.
  /// triangles_met: how many it took.
  [[nodiscard]] double greatest(const spec::Ray<double>& ray, double cot, double at_least,
                                int& hint, int* triangles_met = nullptr) const;

 private:
  /// Every normal lies within an angle of an axis or of its opposite. cosine < 0: unknown.
  struct Normals {
    spec::Vec3<double> axis;
    double cosine;  ///< Of the angle, [0, 1].
    double sine;
  };
  /// A ball about the triangles [first, first + count); inner nodes: children at first, first + 1.
  struct Node {
    spec::CutawayBall<double> ball;
    Normals normals;
    std::int32_t first;
    std::int32_t count;  ///< 0: an inner node.
  };
  /// Orders [first, first + count) so that the lower half along an axis comes first.
  void split(std::int32_t first, std::int32_t half, std::int32_t count, Eigen::Index axis);
  void build(std::size_t node, std::int32_t first, std::int32_t count);
  [[nodiscard]] spec::CutawayBall<double> ball_about(std::int32_t first, std::int32_t count) const;
  [[nodiscard]] Normals normals_about(std::int32_t first, std::int32_t count) const;
  /// f of one ray and angle.
  struct Cone {
    const spec::Ray<double>& ray;
    double cot;
    double norm;  ///< Of the gradient of f, hypot(1, cot).
  };
  /// Upper bound of f over a node; -infinity where that is not above best, or its normals rule it
  /// out.
  [[nodiscard]] static double bound(const Node& node, const Cone& cone, double best);

  std::vector<spec::CutawayTriangle<double>> triangles_;
  std::vector<double>
      ring_angles_;  ///< Largest to the normals of touching triangles, rad; pi: open.
  std::vector<Node> nodes_;
};

/// The cutaway of a scene with meshes of any size, ready to meet the rays of a picture.
class CutawayField {
 public:
  /// Whether a scene needs it: it has a cutaway with a mesh of more than spec::kExactTriangles. All
  /// others are cheaper by spec::make_cutaway() alone.
  static bool needed(const Scene& scene);

  /// Meshes of a field before are kept where they are the same (by address) over the same grid.
  explicit CutawayField(const Scene& scene, const CutawayField* before = nullptr);

  /// One row of pixels [x, x + count) of row y, of all objects, in single precision for CPU tiles
  /// and textures alike; t2 = t1 = lowest() where no surface meets the ray in front of its origin.
  void meet_row(const spec::View<double>& view, int x, int y, int count,
                spec::CutawaySpan<float>* spans) const;
  /// All pixels, row by row, with threads (0: all cores). tolerance_mm 0: every pixel by a search
  /// of its own. > 0: squares of 8 pixels that are bilinear within it, at the middles of the square
  /// and of its edges, are interpolated, others divided; elsewhere within a square the error may be
  /// larger (tested: 99 % of pixels within the tolerance, all within ten of it).
  [[nodiscard]] std::vector<spec::CutawaySpan<float>> meet_all(const spec::View<double>& view,
                                                               int threads,
                                                               double tolerance_mm = 0) const;
  static constexpr float lowest() { return std::numeric_limits<float>::lowest(); }

 private:
  friend class CutawaySquare;
  /// One ray; hints: one per mesh.
  [[nodiscard]] spec::CutawaySpan<float> meet(const spec::Ray<double>& ray,
                                              std::vector<CutawayMesh::Hint>& hints) const;
  spec::CutawayObjects<double> closed_forms_;
  Eigen::Vector3d origin_mm_;
  std::vector<std::shared_ptr<const MeshObject>> sources_;  ///< Of meshes_, in the same order.
  std::vector<std::shared_ptr<const CutawayMesh>> meshes_;
};

}  // namespace nav::render
