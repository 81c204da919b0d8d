// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "render/ray_spec_cutaway.hpp"

namespace nav::render {

/// A mesh that cuts, however many triangles it has: the same surfaces as by meeting every triangle,
/// to the last bit of double precision. A tree of balls bounds the cone function of
/// ray_spec_cutaway.hpp (its greatest value over a ball is a closed form), so a search visits only
/// the balls that may hold a better point than the best so far. Immutable; any number of threads.
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
  /// A ball about the triangles [first, first + count); inner nodes: children at first, first + 1.
  struct Node {
    spec::CutawayBall<double> ball;
    std::int32_t first;
    std::int32_t count;  ///< 0: an inner node.
  };
  void build(std::size_t node, std::int32_t first, std::int32_t count);
  [[nodiscard]] spec::CutawayBall<double> ball_about(std::int32_t first, std::int32_t count) const;

  std::vector<spec::CutawayTriangle<double>> triangles_;
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
  /// All pixels, row by row, with threads (0: all cores).
  [[nodiscard]] std::vector<spec::CutawaySpan<float>> meet_all(const spec::View<double>& view,
                                                               int threads) const;
  static constexpr float lowest() { return std::numeric_limits<float>::lowest(); }

 private:
  spec::CutawayObjects<double> closed_forms_;
  Eigen::Vector3d origin_mm_;
  std::vector<std::shared_ptr<const MeshObject>> sources_;  ///< Of meshes_, in the same order.
  std::vector<std::shared_ptr<const CutawayMesh>> meshes_;
};

}  // namespace nav::render
