// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "render/cpu/cpu_march.hpp"

/// The cutaway of ray_spec_cutaway.hpp for packets of rays and blocks of pixels, in single
/// precision. Coordinates are mm along the CT axes from a reference point among the objects.
/// Distances along a ray are measured from the foot of that point on the ray, so that a distant eye
/// loses no digits. Plain data only, see cpu_march.hpp.
namespace nav::render {

/// An edge of a polygon, from a to b; u and v are coordinates in the polygon's plane.
struct CutEdge {
  float a[3];
  float along[3];  ///< b - a.
  float u[2];      ///< At a and b.
  float v[2];      ///< At a and b.
  float u_per_v;   ///< (u_b - u_a) / (v_b - v_a); undefined if v_a = v_b.
  int polygon;
};

struct CutPolygon {
  float normal[3];  ///< Unit length; zero for a segment.
  float axis_u[3];
  float axis_v[3];
  float vertex[3];  ///< A point of the plane.
  int first_edge;
  int edges;
};

struct CutBall {
  float centre[3];
  float radius;
};

/// All objects that cut. Index 0: theta1, index 1: theta2.
struct CutObjects {
  const CutEdge* edges;
  int edge_count;
  const CutPolygon* polygons;
  int polygon_count;
  const CutBall* balls;
  int ball_count;
  float cot[2];
  float per_sine[2];  ///< 1 / sin(theta).
  float sine[2];
};

/// The objects that may decide for a block of pixels. The arrays have room for all objects and 8
/// more.
struct CutChoice {
  int* edges;  ///< Sorted by polygon.
  int edge_count;
  int* polygons;  ///< Polygons whose inside may be hit.
  /// All rays of the block pass inside, and not too steeply. Then the polygon decides alone, unless
  /// another object reaches farther from the eye.
  bool* inside;
  int polygon_count;
  float* upper;  ///< Buffer, two values per edge.
};

/// The ray in the middle of a block of pixels, and limits for the distance of all other rays from
/// it.
struct CutBlock {
  float origin[3];  ///< On the ray, at the foot of the reference point.
  float direction[3];
  float corner_origin[4][3];  ///< Origins of the four outermost rays, at their feet.
  float corner_direction[4][3];
  float foot;   ///< Distance from the ray's origin to its foot, mm.
  float eye;    ///< Equal to foot; 0 in orthographic views.
  float angle;  ///< Greatest angle to another ray, rad, rounded up.
  float shift;  ///< Greatest distance between the origins, mm, rounded up.
};

/// The rays of a packet and their intersections with the surfaces.
struct alignas(64) CutRays {
  float origin[3][kPacketLanes];
  float direction[3][kPacketLanes];
  float t1[kPacketLanes];  ///< From the foot, mm; -1e30: no intersection.
  float t2[kPacketLanes];
};

}  // namespace nav::render
