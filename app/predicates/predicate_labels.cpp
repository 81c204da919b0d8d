// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_labels.hpp"

#include <sstream>

#include "io/labels.hpp"

namespace nav::app {
namespace {

std::string text_of(const VoxelGrid& grid) {
  std::ostringstream text;
  text.precision(9);  // Enough to see differences that same_place() finds.
  text << grid.size[0] << " x " << grid.size[1] << " x " << grid.size[2] << " voxels of "
       << grid.spacing_mm.x() << " x " << grid.spacing_mm.y() << " x " << grid.spacing_mm.z()
       << " mm at (" << grid.origin_mm.transpose() << ") along";
  for (int axis = 0; axis < 3; ++axis) {
    text << (axis == 0 ? " (" : ", (") << grid.directions.col(axis).transpose() << ")";
  }
  return text.str();
}

/// True when two grids are equal within the rounding of files with 6 digits.
bool same_place(const VoxelGrid& a, const VoxelGrid& b) {
  if (a.size != b.size) return false;
  const double voxel = b.spacing_mm.minCoeff();
  constexpr double kShare = 0.01;  // Share of a voxel, at every corner.
  const Eigen::Vector3d last(a.size[0] - 1, a.size[1] - 1, a.size[2] - 1);
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d at =
        last.cwiseProduct(Eigen::Vector3d(corner & 1, corner >> 1 & 1, corner >> 2));
    if (!((a.at(at).mm - b.at(at).mm).norm() <= kShare * voxel)) return false;
  }
  return true;
}

}  // namespace

Result<render::LabelVolume> read_labels(const std::vector<std::filesystem::path>& files,
                                        const VoxelGrid& grid, Diagnostics& diagnostics) {
  constexpr std::size_t kMostFiles = 32;
  if (files.empty() || files.size() > kMostFiles) {
    return Error{ErrorCode::kUsage,
                 "labels: expected 1 to 32 files, found " + std::to_string(files.size())};
  }
  std::vector<std::uint32_t> bits(grid.voxel_count());
  for (std::size_t n = 0; n < files.size(); ++n) {
    const auto read = io::read_labels(files[n], diagnostics);
    if (!read) return read.error();
    if (!same_place(read->grid, grid)) {
      return Error{ErrorCode::kMalformedData, files[n].string() +
                                                  ": expected labels on the grid of the volume, " +
                                                  text_of(grid) + ", found " + text_of(read->grid)};
    }
    for (std::size_t i = 0; i < bits.size(); ++i) {
      if (files.size() == 1) {
        bits[i] = read->values[i];
      } else if (read->values[i] != 0) {
        bits[i] |= 1U << n;
      }
    }
  }
  return render::LabelVolume::create(grid, std::move(bits),
                                     files.size() == 1 ? files.front().string() : "labels");
}

}  // namespace nav::app
