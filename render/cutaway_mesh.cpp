// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cutaway_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "render/parallel.hpp"

namespace nav::render {
namespace {

using Vec3 = spec::Vec3<double>;
constexpr std::int32_t kLeafTriangles = 4;
constexpr double kNowhere = -std::numeric_limits<double>::infinity();

Vec3 middle_of(const spec::CutawayTriangle<double>& t) {
  return (t.vertices[0] + t.vertices[1] + t.vertices[2]) / 3;
}

bool is_large(const std::shared_ptr<const MeshObject>& mesh) {
  return mesh->triangles.size() > spec::kExactTriangles;
}

}  // namespace

CutawayMesh::CutawayMesh(const MeshObject& mesh, const Eigen::Vector3d& origin_mm) {
  triangles_.reserve(mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    std::array<Vec3, 3> v;
    for (std::size_t i = 0; i < 3; ++i) {
      v[i] = mesh.vertices_ct[static_cast<std::size_t>(triangle[i])].mm - origin_mm;
    }
    const auto polygon = spec::make_polygon({v[0], v[1], v[2]});
    triangles_.push_back({v, polygon.normal, polygon.axis_u, polygon.axis_v});
  }
  nodes_.emplace_back();
  build(0, 0, static_cast<std::int32_t>(triangles_.size()));
}

spec::CutawayBall<double> CutawayMesh::ball_about(std::int32_t first, std::int32_t count) const {
  Eigen::AlignedBox3d box;
  for (std::int32_t i = first; i < first + count; ++i) {
    for (const Vec3& v : triangles_[static_cast<std::size_t>(i)].vertices) box.extend(v);
  }
  const Vec3 centre = box.center();
  double square = 0;
  for (std::int32_t i = first; i < first + count; ++i) {
    for (const Vec3& v : triangles_[static_cast<std::size_t>(i)].vertices) {
      square = std::max(square, (v - centre).squaredNorm());
    }
  }
  return {centre, std::sqrt(square)};
}

void CutawayMesh::build(std::size_t node, std::int32_t first, std::int32_t count) {
  nodes_[node] = {ball_about(first, count), first, count};
  if (count <= kLeafTriangles) return;
  const auto begin = triangles_.begin() + first;
  Eigen::AlignedBox3d box;
  for (auto t = begin; t != begin + count; ++t) box.extend(middle_of(*t));
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::int32_t half = count / 2;
  std::nth_element(begin, begin + half, begin + count, [axis](const auto& a, const auto& b) {
    return middle_of(a)[axis] < middle_of(b)[axis];
  });
  const auto child = static_cast<std::int32_t>(nodes_.size());
  nodes_[node].first = child;
  nodes_[node].count = 0;
  nodes_.emplace_back();
  nodes_.emplace_back();
  build(static_cast<std::size_t>(child), first, half);
  build(static_cast<std::size_t>(child) + 1, first + half, count - half);
}

double CutawayMesh::greatest(const spec::Ray<double>& ray, double cot, double at_least, int& hint,
                             int* triangles_met) const {
  double best = at_least;
  int met = 0;
  const auto meet_triangle = [&](int i) {
    ++met;
    const double t = spec::cone_polygon<double>(triangles_[static_cast<std::size_t>(i)], ray, cot);
    if (t > best) {
      best = t;
      hint = i;
    }
  };
  // A hint is only a place to start, so any number may come in.
  if (hint >= 0 && static_cast<std::size_t>(hint) < triangles_.size()) meet_triangle(hint);
  // More than the bound's closed form and the triangles round at 1e7 mm, the largest of scenes.
  constexpr double kSlack = 1e-12;
  const auto bound = [&](std::int32_t node) {
    const double t = spec::cone_ball(nodes_[static_cast<std::size_t>(node)].ball, ray, cot);
    return t + kSlack * (std::abs(t) + (1 + cot) * (1 + std::abs(best)));
  };
  struct Open {
    std::int32_t node;
    double bound;
  };
  // Halving: depth of at most 32, one open node per level and the two of the last.
  std::array<Open, 64> open;
  std::size_t count = 0;
  open[count++] = {0, bound(0)};
  while (count > 0) {
    const Open next = open[--count];
    if (!(next.bound > best)) continue;
    const Node& node = nodes_[static_cast<std::size_t>(next.node)];
    for (std::int32_t i = 0; i < node.count; ++i) meet_triangle(node.first + i);
    if (node.count > 0) continue;
    Open a{node.first, bound(node.first)};
    Open b{node.first + 1, bound(node.first + 1)};
    if (a.bound > b.bound) std::swap(a, b);
    if (a.bound > best) open[count++] = a;
    if (b.bound > best) open[count++] = b;  // The better one is next.
  }
  if (triangles_met != nullptr) *triangles_met = met;
  return best;
}

void CutawayMesh::meet(const spec::Ray<double>& ray, double cot1, double cot2, Hint& hint,
                       spec::CutawaySpan<double>& span) const {
  span.t2 = greatest(ray, cot2, span.t2, hint.at2);
  span.t1 = greatest(ray, cot1, span.t1, hint.at1);
  span.t2 = std::max(span.t2, span.t1);  // Rounding.
}

bool CutawayField::needed(const Scene& scene) {
  return scene.cutaway && scene.projection == Projection::kComposite &&
         std::any_of(scene.cutaway->meshes.begin(), scene.cutaway->meshes.end(), is_large);
}

CutawayField::CutawayField(const Scene& scene, const CutawayField* before)
    : closed_forms_(spec::make_cutaway(scene, false)), origin_mm_(scene.ct->grid().origin_mm) {
  if (!needed(scene)) return;
  for (const auto& mesh : scene.cutaway->meshes) {
    if (!is_large(mesh)) continue;
    std::shared_ptr<const CutawayMesh> ready;
    if (before != nullptr && before->origin_mm_ == origin_mm_) {
      const auto found = std::find(before->sources_.begin(), before->sources_.end(), mesh);
      if (found != before->sources_.end()) {
        ready = before->meshes_[static_cast<std::size_t>(found - before->sources_.begin())];
      }
    }
    if (!ready) ready = std::make_shared<const CutawayMesh>(*mesh, origin_mm_);
    sources_.push_back(mesh);
    meshes_.push_back(std::move(ready));
  }
}

void CutawayField::meet_row(const spec::View<double>& view, int x, int y, int count,
                            spec::CutawaySpan<float>* spans) const {
  std::vector<CutawayMesh::Hint> hints(meshes_.size());
  for (int i = 0; i < count; ++i) {
    const spec::Ray<double> ray = spec::ray_of(view, x + i, y);
    auto span = spec::meet_cutaway(closed_forms_, ray);
    // Where nothing reaches past the eye, how far behind it everything ends is of no consequence.
    double deepest = std::max(span.t2, 0.0);
    for (std::size_t m = 0; m < meshes_.size(); ++m) {
      deepest = meshes_[m]->greatest(ray, closed_forms_.cot2, deepest, hints[m].at2);
    }
    if (!(deepest > 0)) {
      spans[i] = {lowest(), lowest()};
      continue;
    }
    for (std::size_t m = 0; m < meshes_.size(); ++m) {
      span.t1 = meshes_[m]->greatest(ray, closed_forms_.cot1, span.t1, hints[m].at1);
    }
    spans[i] = {static_cast<float>(std::max(deepest, span.t1)), static_cast<float>(span.t1)};
  }
}

std::vector<spec::CutawaySpan<float>> CutawayField::meet_all(const spec::View<double>& view,
                                                             int threads) const {
  const auto width = static_cast<std::size_t>(view.width);
  std::vector<spec::CutawaySpan<float>> spans(width * static_cast<std::size_t>(view.height));
  for_each_index(view.height, threads, [&](int y) {
    meet_row(view, 0, y, view.width, spans.data() + static_cast<std::size_t>(y) * width);
  });
  return spans;
}

}  // namespace nav::render
