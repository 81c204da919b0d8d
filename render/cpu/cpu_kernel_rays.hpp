// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_cutaway.hpp"
#include "render/cpu/cpu_march.hpp"

/// The start of rays in double precision, in plain loops over lanes that the compiler converts to
/// vector instructions. See cpu_kernel.hpp for the files that may include this. V only gives every
/// instance the linkage of its file.
namespace nav::render {

template <class V>
struct RayStarter {
  const RayInputs& in;
  alignas(32) double origin[3][kPacketLanes];     ///< Index coordinates.
  alignas(32) double direction[3][kPacketLanes];  ///< Index coordinates per mm.

  /// spec::ray_of() and spec::index_ray().
  void aim(const PacketPixels& pixels) {
    alignas(32) double a[kPacketLanes];
    alignas(32) double b[kPacketLanes];
    alignas(32) double scale[kPacketLanes];
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      a[lane] = (pixels.x[lane] + 0.5 - in.half_width) * in.pixel;
      b[lane] = (in.half_height - pixels.y[lane] - 0.5) * in.pixel;
      scale[lane] = in.orthographic ? 1 : 1 / V::root(1 + a[lane] * a[lane] + b[lane] * b[lane]);
    }
    for (int axis = 0; axis < 3; ++axis) {
      const double e = in.eye[axis];
      const double f = in.forward[axis];
      for (int lane = 0; lane < kPacketLanes; ++lane) {
        const double offset = a[lane] * in.right[axis] + b[lane] * in.up[axis];
        origin[axis][lane] = in.orthographic ? e + offset : e;
        direction[axis][lane] = in.orthographic ? f : (f + offset) * scale[lane];
      }
    }
  }

  /// spec::clip_to_box().
  void clip(const PacketPixels& pixels, RayStarts& out) const {
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      out.begin[lane] = 0;
      out.end[lane] = 1e300;
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (int lane = 0; lane < kPacketLanes; ++lane) {
        const double o = origin[axis][lane];
        const double d = direction[axis][lane];
        const bool still = d == 0;
        const double per = 1 / (still ? 1.0 : d);
        const bool within = o >= in.low[axis] && o <= in.high[axis];
        double near = (in.low[axis] - o) * per;
        double far = (in.high[axis] - o) * per;
        const double least = near < far ? near : far;
        const double most = near < far ? far : near;
        near = still ? (within ? 0.0 : 1e300) : least;
        far = still ? 1e300 : most;
        out.begin[lane] = out.begin[lane] < near ? near : out.begin[lane];
        out.end[lane] = far < out.end[lane] ? far : out.end[lane];
      }
    }
    out.any = false;
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      const bool outside = pixels.x[lane] >= in.width || pixels.y[lane] >= in.height;
      if (outside || !(out.end[lane] > out.begin[lane])) out.begin[lane] = out.end[lane] = 0;
      out.any = out.any || out.end[lane] > 0;
    }
  }

  /// spec::jitter_of().
  static double jitter(int x, int y) {
    std::uint32_t h =
        static_cast<std::uint32_t>(x) * 0x8da6b343U + static_cast<std::uint32_t>(y) * 0xd8163841U;
    h = (h ^ (h >> 16)) * 0x7feb352dU;
    h = (h ^ (h >> 15)) * 0x846ca68bU;
    return static_cast<double>((h ^ (h >> 16)) >> 8) / 16777216.0;
  }

  void start(const PacketPixels& pixels, RayPacket& rays, RayStarts& out) const {
    const double per_step = 1 / in.step_mm;
    for (int lane = 0; lane < kPacketLanes; ++lane) {
      const double shift = in.jitter ? jitter(pixels.x[lane], pixels.y[lane]) : 0.0;
      // Truncation equals the floor, except for entries within the first cell of a shifted ray.
      const double cells = out.begin[lane] * per_step - shift;
      const auto whole = static_cast<double>(static_cast<std::int64_t>(cells));
      out.base[lane] = (whole > cells ? whole - 1 : whole) + shift;
      rays.begin[lane] = static_cast<float>(out.begin[lane] * per_step - out.base[lane]);
      rays.end[lane] = static_cast<float>(out.end[lane] * per_step - out.base[lane]);
      rays.alpha[lane] = 0;
      rays.t1[lane] = rays.t2[lane] = -1e30F;
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (int lane = 0; lane < kPacketLanes; ++lane) {
        const double first = (out.base[lane] + in.first_sample) * in.step_mm;
        rays.rgb[axis][lane] = 0;
        rays.origin[axis][lane] =
            static_cast<float>(origin[axis][lane] + first * direction[axis][lane]);
        rays.step[axis][lane] = static_cast<float>(in.step_mm * direction[axis][lane]);
      }
    }
  }
};

/// spec::ray_of() with the origin at the foot of the reference point.
template <class V>
void aim_cut_rays(const RayInputs& in, const CutView& view, const PacketPixels& pixels,
                  CutRays& rays, double* feet) {
  for (int lane = 0; lane < kPacketLanes; ++lane) {
    const double a = (pixels.x[lane] + 0.5 - in.half_width) * in.pixel;
    const double b = (in.half_height - pixels.y[lane] - 0.5) * in.pixel;
    const double scale = in.orthographic ? 1 : 1 / V::root(1 + a * a + b * b);
    double origin[3];
    double direction[3];
    double foot = 0;
    for (int i = 0; i < 3; ++i) {
      const double offset = a * view.right[i] + b * view.up[i];
      origin[i] = in.orthographic ? view.eye[i] + offset : view.eye[i];
      direction[i] = in.orthographic ? view.forward[i] : (view.forward[i] + offset) * scale;
      foot -= origin[i] * direction[i];
    }
    for (int i = 0; i < 3; ++i) {
      rays.origin[i][lane] = static_cast<float>(origin[i] + foot * direction[i]);
      rays.direction[i][lane] = static_cast<float>(direction[i]);
    }
    feet[lane] = foot;
  }
}

template <class V>
void start_rays(const RayInputs& in, const PacketPixels& pixels, RayPacket& rays, RayStarts& out) {
  RayStarter<V> starter{in, {}, {}};
  starter.aim(pixels);
  starter.clip(pixels, out);
  starter.start(pixels, rays, out);
}

}  // namespace nav::render
