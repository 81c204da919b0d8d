// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/cpu_rays.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/cpu/cpu_inputs.hpp"

namespace nav::render {
namespace {

/// Distance in front of which no ray of a view meets the volume, mm; from the ball around the
/// volume.
double nearest_mm(const spec::View<double>& view, const VoxelGrid& grid) {
  const Eigen::Vector3d to = grid.centre().mm - grid.origin_mm - view.eye;
  const double along = view.orthographic ? to.dot(view.forward) : to.norm();
  // One voxel more, for axes with only one voxel.
  return std::max(0.0, along - 0.5 * grid.extent_mm().norm() - grid.spacing_mm.norm());
}

}  // namespace

CpuRays::CpuRays(const Scene& scene, const MarchSet& marches, const CutPlan& cutaway,
                 const CutawayField* field, double first_sample, float overlay_cells)
    : marches_(marches),
      cutaway_(cutaway),
      field_(field),
      surfaces_(scene),
      view_(spec::make_view<double>(scene.camera, scene.width, scene.height, scene.ct->grid())),
      cut_view_(cut_view(view_, cutaway.centre())),
      bounds_(scene),
      step_(spec::step_mm(scene.quality, scene.ct->grid())),
      inputs_(ray_inputs(scene, first_sample)),
      near_mm_(nearest_mm(view_, scene.ct->grid())),
      overlay_cells_(overlay_cells < 1e29F ? static_cast<double>(overlay_cells) : 0) {}

PacketPixels block_pixels(int x0, int y0) {
  PacketPixels pixels;
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    pixels.x[lane] = x0 + lane % kPacketWidth;
    pixels.y[lane] = y0 + lane / kPacketWidth;
  }
  return pixels;
}

bool CpuRays::cull(int x0, int y0, int size, const CutChoice& from, CutChoice& to) const {
  const CutBlock block = cut_block(view_, cutaway_.centre(), x0, y0, size);
  const double most = marches_.cull(cutaway_.objects(), block, from, to);
  // The foot of another ray may lie farther because of its angle and its shift.
  const double to_centre = (cutaway_.centre() - view_.eye).norm();
  return most + block.foot + block.angle * to_centre + block.shift > near_mm_;
}

void CpuRays::keep_spans(CpuPacket& p) const {
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    // An empty span may lie at infinity, which a lane beside others must not use.
    const VisibleSpan span = p.spans[lane].empty() ? VisibleSpan{0, 0} : p.spans[lane];
    const double near = span.near / step_;
    const double far = span.far / step_;
    // Whole cells, so that no further cell is cut. Rounding takes less than the spare cell.
    p.from[lane] = static_cast<float>(std::floor(near - p.starts.base[lane]) - 1);
    p.until[lane] = static_cast<float>(std::ceil(far - p.starts.base[lane]) + 1);
    p.rays.begin[lane] = std::max(p.rays.begin[lane], p.from[lane]);
    p.rays.end[lane] = std::min(p.rays.end[lane], p.until[lane]);
  }
}

void CpuRays::start(int x0, int y0, const SurfaceReach& reach, const CutChoice* choice,
                    const VisibleSpan& span, CpuPacket& p) const {
  p.pixels = block_pixels(x0, y0);
  std::fill_n(p.spans, kPacketLanes, span);
  start(reach, choice, p);
}

void CpuRays::start(const SurfaceReach& reach, const CutChoice* choice, CpuPacket& p) const {
  marches_.start(inputs_, p.pixels, p.rays, p.starts);
  keep_spans(p);
  p.most_hits = 0;
  p.cut = 0;
  for (auto& hits : p.hits) hits.clear();
  if (reach.any()) meet_surfaces(reach, p);
  if (choice != nullptr && p.starts.any) cut(*choice, p);
  if (field_ != nullptr && p.starts.any) cut_by_field(p);
}

void CpuRays::meet_surfaces(const SurfaceReach& reach, CpuPacket& p) const {
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    surfaces_.meet(spec::ray_of(view_, p.pixels.x[lane], p.pixels.y[lane]), reach, p.hits[lane]);
    p.most_hits = std::max(p.most_hits, p.hits[lane].size());
  }
}

void CpuRays::cut(const CutChoice& choice, CpuPacket& p) const {
  marches_.aim(inputs_, cut_view_, p.pixels, p.cut_rays, p.foot);
  marches_.meet(cutaway_.objects(), choice, p.cut_rays);
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    if (!(p.starts.end[lane] > p.starts.begin[lane])) continue;
    cut_lane(p.foot[lane] + static_cast<double>(p.cut_rays.t1[lane]),
             p.foot[lane] + static_cast<double>(p.cut_rays.t2[lane]), lane, p);
  }
}

void CpuRays::cut_by_field(CpuPacket& p) const {
  std::array<spec::CutawaySpan<float>, kPacketLanes> spans{};
  // Works row by row, so that a ray starts its search where its neighbour's search ended.
  for (int first = 0, end = 0; first < kPacketLanes; first = end) {
    do {
      ++end;
    } while (end < kPacketLanes && p.pixels.y[end] == p.pixels.y[first] &&
             p.pixels.x[end] == p.pixels.x[end - 1] + 1);
    field_->meet_row(view_, p.pixels.x[first], p.pixels.y[first], end - first,
                     spans.data() + first);
  }
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    if (!(p.starts.end[lane] > p.starts.begin[lane])) continue;
    const spec::CutawaySpan<float>& span = spans[static_cast<std::size_t>(lane)];
    cut_lane(span.t1, span.t2, lane, p);
  }
}

void CpuRays::cut_lane(double t1_mm, double t2_mm, int lane, CpuPacket& p) const {
  if (!(t2_mm > p.starts.begin[lane])) return;
  const double t2 = t2_mm / step_ - p.starts.base[lane];
  const double t1 = std::max(t1_mm / step_ - p.starts.base[lane], kCutNowhere);
  p.rays.t2[lane] = static_cast<float>(t2);
  p.rays.t1[lane] = static_cast<float>(t1);
  p.rays.per_transition[lane] = static_cast<float>(std::min(1 / (t2 - t1), -kCutNowhere));
  // Far above the rounding error in single precision of t2, t1, their difference, and a sum of
  // cells.
  p.rays.margin[lane] =
      static_cast<float>(0.02 + 2e-6 * (t2 - t1 + overlay_cells_ + std::abs(t1) + std::abs(t2)));
  ++p.cut;
}

spec::Interval<double> between_surfaces(const std::vector<spec::Hit<double>>& hits,
                                        std::size_t segment) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  if (segment > hits.size() || (segment == hits.size() && segment > 0 && hits.back().alpha >= 1)) {
    return {0, 0};
  }
  return {segment > 0 ? hits[segment - 1].t : 0, segment < hits.size() ? hits[segment].t : kFar};
}

bool CpuRays::set_lane(double begin_mm, double end_mm, int lane, CpuPacket& p) const {
  const double begin = std::max(begin_mm, p.starts.begin[lane]);
  const double end = std::min(end_mm, p.starts.end[lane]);
  if (!(end > begin)) {
    p.rays.begin[lane] = p.rays.end[lane] = 0;
    return false;
  }
  p.rays.begin[lane] =
      std::max(static_cast<float>(begin / step_ - p.starts.base[lane]), p.from[lane]);
  p.rays.end[lane] = std::min(static_cast<float>(end / step_ - p.starts.base[lane]), p.until[lane]);
  return true;
}

void CpuRays::set_segment(std::size_t segment, CpuPacket& p) const {
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    const auto stretch = between_surfaces(p.hits[lane], segment);
    set_lane(stretch.begin, stretch.end, lane, p);
  }
}

bool CpuRays::set_stretches(const LaneStretches& stretches, CpuPacket& p) const {
  bool any = false;
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    any = set_lane(stretches.begin[lane], stretches.end[lane], lane, p) || any;
  }
  return any;
}

}  // namespace nav::render
