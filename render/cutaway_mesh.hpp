// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "render/spec/ray_spec_cutaway.hpp"

namespace nav::render {

/// A mesh of any number of triangles that cuts. Gives the surfaces of ray_spec_cutaway.hpp as if
/// every triangle was met, up to rounding. A search over a tree visits only nodes that may hold a
/// better point than the best so far. It uses two bounds of the function f of a cone:
/// - The greatest value of f over a ball has a closed form.
/// - On a closed surface f can be greatest only where its gradient is at right angles to the
///   surface. The gradient is r - cot(theta) e; e is the direction away from the ray. So nodes also
///   store a cone that holds the normals of their triangles and of all triangles that touch those.
/// Immutable; any number of threads.
class CutawayMesh {
 public:
  /// The last best triangles of a ray, where the search for its neighbour starts. Any value is
  /// correct.
  struct Hint {
    int at1 = 0;
    int at2 = 0;
  };

  /// \p origin_mm: origin of the volume's grid, CT mm. Precondition: a validated mesh.
  CutawayMesh(const MeshObject& mesh, const Eigen::Vector3d& origin_mm);

  /// Extends the span of a ray, which other objects gave (-infinity: none), by this mesh.
  void meet(const spec::Ray<double>& ray, double cot1, double cot2, Hint& hint,
            spec::CutawaySpan<double>& span) const;

  [[nodiscard]] std::size_t triangles() const { return triangles_.size(); }
  /// The greatest t at which the surface of one angle meets a ray, mm; not less than at_least.
  /// \p hint: see Hint. \p triangles_met: receives the number of triangles tested.
  [[nodiscard]] double greatest(const spec::Ray<double>& ray, double cot, double at_least,
                                int& hint, int* triangles_met = nullptr) const;

 private:
  /// A cone of normals: each normal lies within an angle of the axis or of its opposite.
  /// cosine < 0: unknown.
  struct Normals {
    spec::Vec3<double> axis;
    double cosine;  ///< Cosine of the angle, [0, 1].
    double sine;
  };
  /// A ball around the triangles [first, first + count). Inner nodes have their children at first
  /// and first + 1.
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
  /// The function f for one ray and one angle.
  struct Cone {
    const spec::Ray<double>& ray;
    double cot;
    double norm;  ///< Norm of the gradient of f, hypot(1, cot).
  };
  /// An upper bound of f over a node; -infinity if the bound is not above best, or if the normals
  /// rule the node out.
  [[nodiscard]] static double bound(const Node& node, const Cone& cone, double best);

  std::vector<spec::CutawayTriangle<double>> triangles_;
  std::vector<double>
      ring_angles_;  ///< Largest angle to normals of touching triangles, rad; pi: open.
  std::vector<Node> nodes_;
};

/// The cutaway of a scene with meshes of any size, ready to meet the rays of an image.
class CutawayField {
 public:
  /// True if a scene has a cutaway with a mesh of more than spec::kExactTriangles. For all other
  /// scenes spec::make_cutaway() alone is cheaper.
  static bool needed(const Scene& scene);

  /// Reuses the meshes of an earlier field that are the same (by address) over the same grid.
  explicit CutawayField(const Scene& scene, const CutawayField* before = nullptr);

  /// Meets all objects with the rays of the pixels [x, x + count) of row y. The spans are in single
  /// precision, for CPU tiles and for textures. t2 = t1 = lowest() where no surface meets the ray
  /// in front of its origin.
  void meet_row(const spec::View<double>& view, int x, int y, int count,
                spec::CutawaySpan<float>* spans) const;
  /// Meets all pixels, row by row; threads 0: all cores. tolerance_mm 0: a separate search for
  /// every pixel. tolerance_mm > 0: squares of 8 pixels are interpolated if they are bilinear
  /// within the tolerance at the middles of the square and of its edges; other squares are divided.
  /// Elsewhere in a square the error may be larger (tested: 99 % of pixels within the tolerance,
  /// all within ten times the tolerance).
  [[nodiscard]] std::vector<spec::CutawaySpan<float>> meet_all(const spec::View<double>& view,
                                                               int threads,
                                                               double tolerance_mm = 0) const;
  static constexpr float lowest() { return std::numeric_limits<float>::lowest(); }

 private:
  friend class CutawaySquare;
  /// Meets one ray. hints: one per mesh.
  [[nodiscard]] spec::CutawaySpan<float> meet(const spec::Ray<double>& ray,
                                              std::vector<CutawayMesh::Hint>& hints) const;
  spec::CutawayObjects<double> closed_forms_;
  Eigen::Vector3d origin_mm_;
  std::vector<std::shared_ptr<const MeshObject>> sources_;  ///< In the order of meshes_.
  std::vector<std::shared_ptr<const CutawayMesh>> meshes_;
};

}  // namespace nav::render
