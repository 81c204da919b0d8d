// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "nav/volume.hpp"
#include "render/scene.hpp"

namespace nav::app {

/// An object of interest that a session names, CT (LPS) mm: what lies in front of it is cut away.
struct CutawayObject {
  enum class Type { kBox, kPolygon, kMesh };
  Type type = Type::kBox;
  Eigen::Vector3d centre_ct = Eigen::Vector3d::Zero();          ///< Centre of a box.
  Eigen::Matrix3d half_edges_ct = Eigen::Matrix3d::Identity();  ///< Half edges of a box, columns.
  std::vector<Eigen::Vector3d> vertices_ct;  ///< Vertices of a polygon, in order.
  std::filesystem::path file;                ///< File of a mesh.
};

/// The objects as a cutaway takes them.
struct CutawayShapes {
  std::vector<render::PolygonObject> polygons;
  std::vector<render::BoxObject> boxes;
  std::vector<std::shared_ptr<const render::MeshObject>> meshes;
};

/// Rejects, by cutaway_objects[i]: positions beyond 10^6 mm or NaN, boxes whose edges have no
/// length or are not at right angles, polygons that are not flat, cross themselves or have no area.
/// kUsage.
Result<void> validate(const std::vector<CutawayObject>& objects);

/// Reads meshes and makes them ready. Errors: of io::read_surface(), kMalformedData for meshes with
/// vertices that are not finite or without any area; a warning for an object beside the CT.
Result<CutawayShapes> read_cutaway_objects(const std::vector<CutawayObject>& objects,
                                           const Volume& ct, Diagnostics& diagnostics);

}  // namespace nav::app
