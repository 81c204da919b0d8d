// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cutaway_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "render/parallel.hpp"

namespace nav::render {
namespace {

using Vec3 = spec::Vec3<double>;
constexpr std::int32_t kLeafTriangles = 1;  // Testing a bound costs less than meeting a triangle.
constexpr double kNoHit = -std::numeric_limits<double>::infinity();

Vec3 middle_of(const spec::CutawayTriangle<double>& t) {
  return (t.vertices[0] + t.vertices[1] + t.vertices[2]) / 3;
}

/// Merges vertices at the same position, because files of loose triangles repeat them.
std::vector<std::array<int, 3>> welded(const MeshObject& mesh) {
  std::vector<int> order(mesh.vertices_ct.size());
  std::iota(order.begin(), order.end(), 0);
  const auto at = [&](int i) -> const Eigen::Vector3d& {
    return mesh.vertices_ct[static_cast<std::size_t>(i)].mm;
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return std::lexicographical_compare(at(a).begin(), at(a).end(), at(b).begin(), at(b).end());
  });
  std::vector<int> first(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && at(order[i]) == at(order[i - 1]);
    first[static_cast<std::size_t>(order[i])] =
        same ? first[static_cast<std::size_t>(order[i - 1])] : order[i];
  }
  auto triangles = mesh.triangles;
  for (auto& triangle : triangles) {
    for (int& i : triangle) i = first[static_cast<std::size_t>(i)];
  }
  return triangles;
}

/// Marks the vertices where the surface ends, branches, turns inside out or has no normal.
std::vector<bool> open_vertices(const std::vector<std::array<int, 3>>& triangles,
                                const std::vector<spec::CutawayTriangle<double>>& shapes,
                                std::size_t vertices) {
  std::vector<bool> open(vertices, false);
  std::vector<std::array<int, 3>> edges;  // Lower and higher vertex; 1 if the edge runs from lower
                                          // to higher.
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = triangles[i][k];
      const int b = triangles[i][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : 0});
      if (!(shapes[i].normal.squaredNorm() > 0)) open[static_cast<std::size_t>(a)] = true;
    }
  }
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i;
    while (end < edges.size() && edges[end][0] == edges[i][0] && edges[end][1] == edges[i][1])
      ++end;
    if (end - i != 2 || edges[i][2] == edges[i + 1][2]) {
      open[static_cast<std::size_t>(edges[i][0])] = true;
      open[static_cast<std::size_t>(edges[i][1])] = true;
    }
    i = end;
  }
  return open;
}

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// For each triangle: the largest angle between its normal and those of the triangles that touch
/// it, rad; pi if the surface is open there.
std::vector<double> ring_angles(const MeshObject& mesh,
                                const std::vector<spec::CutawayTriangle<double>>& shapes) {
  const auto triangles = welded(mesh);
  std::vector<bool> open = open_vertices(triangles, shapes, mesh.vertices_ct.size());
  // Per vertex: a normal, and its largest angle to the normals of the triangles around the vertex.
  std::vector<Vec3> sum(mesh.vertices_ct.size(), Vec3::Zero());
  std::vector<double> widest(mesh.vertices_ct.size(), 0);
  const auto for_corners = [&](const auto& visit) {
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (const int v : triangles[i]) visit(shapes[i].normal, static_cast<std::size_t>(v), i);
    }
  };
  for_corners([&](const Vec3& normal, std::size_t v, std::size_t) { sum[v] += normal; });
  // Opposite normals that cancel out leave no direction from which to measure.
  for (std::size_t v = 0; v < sum.size(); ++v) open[v] = open[v] || !(sum[v].norm() > 1e-6);
  for_corners([&](const Vec3& normal, std::size_t v, std::size_t) {
    widest[v] = std::max(widest[v], angle_between(sum[v], normal));
  });
  std::vector<double> angles(triangles.size(), 0);
  for_corners([&](const Vec3& normal, std::size_t v, std::size_t i) {
    const double here = open[v] ? M_PI : angle_between(sum[v], normal) + widest[v];
    angles[i] = std::max(angles[i], here);
  });
  return angles;
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
  ring_angles_ = ring_angles(mesh, triangles_);
  nodes_.emplace_back();
  nodes_.reserve(triangles_.size());
  build(0, 0, static_cast<std::int32_t>(triangles_.size()));
}

CutawayMesh::Normals CutawayMesh::normals_about(std::int32_t first, std::int32_t count) const {
  Vec3 sum = Vec3::Zero();
  for (std::int32_t i = first; i < first + count; ++i) {
    sum += triangles_[static_cast<std::size_t>(i)].normal;
  }
  double widest = 1e-6;  // Larger than the rounding of normals and angles.
  for (std::int32_t i = first; i < first + count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    widest = std::max(widest, angle_between(sum, triangles_[at].normal) + ring_angles_[at] + 1e-6);
  }
  if (!(widest < M_PI / 2) || !(sum.norm() > 0)) return {Vec3::Zero(), -1, 0};
  return {sum.normalized(), std::cos(widest), std::sin(widest)};
}

double CutawayMesh::bound(const Node& node, const Cone& cone, double best) {
  const Vec3 m = node.ball.centre - cone.ray.origin;
  const double along = m.dot(cone.ray.direction);
  const Vec3 across = m - along * cone.ray.direction;
  const double square = across.squaredNorm();
  const double distance = std::sqrt(square);
  const double radius = node.ball.radius;
  // Like spec::cone_ball(), with a slack above the rounding of it and of the triangles.
  double t = distance * cone.norm >= radius * cone.cot
                 ? along - cone.cot * distance + radius * cone.norm
                 : along + std::sqrt(std::max(radius * radius - square, 0.0));
  constexpr double kSlack = 1e-12;
  t += kSlack * (std::abs(along) + cone.norm * (1 + distance + radius));
  if (!(t > best)) return kNoHit;
  if (node.normals.cosine < 0 || !(distance > radius)) return t;
  // The gradient at the ball's centre, and how far it turns within the ball: its part across the
  // ray has the length cot and turns by asin(radius / distance).
  const Vec3 gradient = cone.ray.direction - (cone.cot / distance) * across;
  const double turn_across = std::sqrt(1 - radius * radius / square);  // The cosine of that turn.
  const double chord_square =
      cone.cot * cone.cot / (cone.norm * cone.norm) * (2 - 2 * turn_across);  // (2 sin(turn/2))^2
  if (chord_square > 1) return t;
  // cos(normals + turn), with sin(turn) <= chord.
  const double limit =
      node.normals.cosine * (1 - 0.5 * chord_square) - node.normals.sine * std::sqrt(chord_square);
  const bool ruled_out = limit > 0 && std::abs(gradient.dot(node.normals.axis)) < limit * cone.norm;
  return ruled_out ? kNoHit : t;
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

void CutawayMesh::split(std::int32_t first, std::int32_t half, std::int32_t count,
                        Eigen::Index axis) {
  std::vector<std::int32_t> order(static_cast<std::size_t>(count));
  std::iota(order.begin(), order.end(), first);
  std::nth_element(order.begin(), order.begin() + half, order.end(),
                   [&](std::int32_t a, std::int32_t b) {
                     return middle_of(triangles_[static_cast<std::size_t>(a)])[axis] <
                            middle_of(triangles_[static_cast<std::size_t>(b)])[axis];
                   });
  std::vector<spec::CutawayTriangle<double>> triangles;
  std::vector<double> angles;
  for (const std::int32_t i : order) {
    triangles.push_back(triangles_[static_cast<std::size_t>(i)]);
    angles.push_back(ring_angles_[static_cast<std::size_t>(i)]);
  }
  std::copy(triangles.begin(), triangles.end(), triangles_.begin() + first);
  std::copy(angles.begin(), angles.end(), ring_angles_.begin() + first);
}

void CutawayMesh::build(std::size_t node, std::int32_t first, std::int32_t count) {
  nodes_[node] = {ball_about(first, count), normals_about(first, count), first, count};
  if (count <= kLeafTriangles) return;
  const auto begin = triangles_.begin() + first;
  Eigen::AlignedBox3d box;
  for (auto t = begin; t != begin + count; ++t) box.extend(middle_of(*t));
  Eigen::Index axis = 0;
  box.sizes().maxCoeff(&axis);
  const std::int32_t half = count / 2;
  split(first, half, count, axis);
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
  // A hint only says where to start, so any number is allowed.
  if (hint >= 0 && static_cast<std::size_t>(hint) < triangles_.size()) meet_triangle(hint);
  const Cone cone{ray, cot, std::hypot(1.0, cot)};
  const auto bound_of = [&](std::int32_t node) {
    return bound(nodes_[static_cast<std::size_t>(node)], cone, best);
  };
  struct Open {
    std::int32_t node;
    double bound;
  };
  // Halving limits the depth to 32: one open node per level, and two on the last.
  std::array<Open, 64> open;
  std::size_t count = 0;
  open[count++] = {0, bound_of(0)};
  while (count > 0) {
    const Open next = open[--count];
    if (!(next.bound > best)) continue;
    const Node& node = nodes_[static_cast<std::size_t>(next.node)];
    for (std::int32_t i = 0; i < node.count; ++i) meet_triangle(node.first + i);
    if (node.count > 0) continue;
    Open a{node.first, bound_of(node.first)};
    Open b{node.first + 1, bound_of(node.first + 1)};
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
  span.t2 = std::max(span.t2, span.t1);  // Guards against rounding.
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

spec::CutawaySpan<float> CutawayField::meet(const spec::Ray<double>& ray,
                                            std::vector<CutawayMesh::Hint>& hints) const {
  auto span = spec::meet_cutaway(closed_forms_, ray);
  // If no surface reaches past the eye, it does not matter how far behind the eye they end.
  double deepest = std::max(span.t2, 0.0);
  for (std::size_t m = 0; m < meshes_.size(); ++m) {
    deepest = meshes_[m]->greatest(ray, closed_forms_.cot2, deepest, hints[m].at2);
  }
  if (!(deepest > 0)) return {lowest(), lowest()};
  for (std::size_t m = 0; m < meshes_.size(); ++m) {
    span.t1 = meshes_[m]->greatest(ray, closed_forms_.cot1, span.t1, hints[m].at1);
  }
  return {static_cast<float>(std::max(deepest, span.t1)), static_cast<float>(span.t1)};
}

void CutawayField::meet_row(const spec::View<double>& view, int x, int y, int count,
                            spec::CutawaySpan<float>* spans) const {
  std::vector<CutawayMesh::Hint> hints(meshes_.size());
  for (int i = 0; i < count; ++i) spans[i] = meet(spec::ray_of(view, x + i, y), hints);
}

/// A square of pixels that is divided until it can be interpolated.
class CutawaySquare {
 public:
  static constexpr int kSize = 8;

  CutawaySquare(const CutawayField& field, const spec::View<double>& view, double tolerance_mm)
      : field_(field),
        view_(view),
        tolerance_(static_cast<float>(tolerance_mm)),
        hints_(field.meshes_.size()) {}

  /// Meets the pixels from (x, y) on. The square's corners may lie outside the image.
  void meet(int x, int y, int width, int height, spec::CutawaySpan<float>* image) {
    const bool next = y == y_ && x == x_ + kSize;
    x_ = x;
    y_ = y;
    begin(next);
    divide(0, 0, kSize);
    for (int j = 0; j < std::min(kSize, height - y); ++j) {
      for (int i = 0; i < std::min(kSize, width - x); ++i) {
        image[static_cast<std::size_t>(y + j) * static_cast<std::size_t>(width) +
              static_cast<std::size_t>(x + i)] = at(i, j);
      }
    }
  }

 private:
  static constexpr std::size_t kSide = kSize + 1;
  /// Forgets all but the right edge, which is the left edge of the next square.
  void begin(bool next) {
    for (std::size_t row = 0; row < kSide * kSide; row += kSide) {
      const bool known = next && known_[row + kSide - 1];
      if (known) spans_[row] = spans_[row + kSide - 1];
      std::fill_n(known_.begin() + static_cast<std::ptrdiff_t>(row), kSide, false);
      known_[row] = known;
    }
  }
  spec::CutawaySpan<float>& at(int i, int j) {
    return spans_[static_cast<std::size_t>(j) * kSide + static_cast<std::size_t>(i)];
  }
  const spec::CutawaySpan<float>& exact(int i, int j) {
    bool& known = known_[static_cast<std::size_t>(j) * kSide + static_cast<std::size_t>(i)];
    if (!known) at(i, j) = field_.meet(spec::ray_of(view_, x_ + i, y_ + j), hints_);
    known = true;
    return at(i, j);
  }

  using Corners = std::array<spec::CutawaySpan<float>, 4>;
  Corners corners_of(int i, int j, int size) {
    return {exact(i, j), exact(i + size, j), exact(i, j + size), exact(i + size, j + size)};
  }

  /// Tests whether the middles of a square and of its edges agree with the interpolation of its
  /// corners.
  bool is_even(int i, int j, int half, const Corners& corners) {
    for (const Corners::value_type& corner : corners) {
      if (!(corner.t2 > CutawayField::lowest())) return false;
    }
    for (const auto& [u, v] : {std::pair(1, 1), {1, 0}, {0, 1}, {2, 1}, {1, 2}}) {
      const auto found = exact(i + u * half, j + v * half);
      const auto guess =
          between(corners, 0.5F * static_cast<float>(u), 0.5F * static_cast<float>(v));
      if (!(std::abs(guess.t1 - found.t1) <= tolerance_)) return false;
      if (!(std::abs(guess.t2 - found.t2) <= tolerance_)) return false;
    }
    return true;
  }

  void divide(int i, int j, int size) {
    const int half = size / 2;
    const bool even = is_even(i, j, half, corners_of(i, j, size));
    for (const int dj : {0, half}) {
      for (const int di : {0, half}) {
        if (even) {
          interpolate(i + di, j + dj, half, corners_of(i + di, j + dj, half));
        } else if (half > 1) {
          divide(i + di, j + dj, half);
        } else {
          exact(i + di, j + dj);
        }
      }
    }
  }

  void interpolate(int i, int j, int size, const Corners& corners) {
    const float step = 1.0F / static_cast<float>(size);
    for (int dj = 0; dj < size; ++dj) {
      for (int di = 0; di < size; ++di) {
        const std::size_t index =
            static_cast<std::size_t>(j + dj) * kSide + static_cast<std::size_t>(i + di);
        if (known_[index]) continue;
        spans_[index] =
            between(corners, step * static_cast<float>(di), step * static_cast<float>(dj));
      }
    }
  }

  static spec::CutawaySpan<float> between(const Corners& corners, float u, float v) {
    const auto mix = [&](float a, float b, float c, float d) {
      const float top = a + u * (b - a);
      return top + v * (c + u * (d - c) - top);
    };
    return {mix(corners[0].t2, corners[1].t2, corners[2].t2, corners[3].t2),
            mix(corners[0].t1, corners[1].t1, corners[2].t1, corners[3].t1)};
  }

  const CutawayField& field_;
  const spec::View<double>& view_;
  float tolerance_;
  std::vector<CutawayMesh::Hint> hints_;
  int x_ = 0;
  int y_ = -1;
  std::array<spec::CutawaySpan<float>, kSide * kSide> spans_{};
  std::array<bool, kSide * kSide> known_{};
};

std::vector<spec::CutawaySpan<float>> CutawayField::meet_all(const spec::View<double>& view,
                                                             int threads,
                                                             double tolerance_mm) const {
  const auto width = static_cast<std::size_t>(view.width);
  std::vector<spec::CutawaySpan<float>> spans(width * static_cast<std::size_t>(view.height));
  if (!(tolerance_mm > 0)) {
    for_each_index(view.height, threads, [&](int y) {
      meet_row(view, 0, y, view.width, spans.data() + static_cast<std::size_t>(y) * width);
    });
    return spans;
  }
  constexpr int kSize = CutawaySquare::kSize;
  for_each_index((view.height + kSize - 1) / kSize, threads, [&](int row) {
    CutawaySquare square(*this, view, tolerance_mm);
    for (int x = 0; x < view.width; x += kSize) {
      square.meet(x, row * kSize, view.width, view.height, spans.data());
    }
  });
  return spans;
}

}  // namespace nav::render
