// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "nav/diagnostics.hpp"
#include "nav/result.hpp"
#include "render/scene.hpp"

namespace nav::bench {

/// A scene and its name in the tables.
struct NamedScene {
  std::string name;
  render::Scene scene;  ///< CT and transfer function only: VTK's mappers know no plane or needle.
};

/// A volume of the set and its two transfer functions.
struct BenchVolume {
  std::string name;
  std::shared_ptr<const StoredVolume> ct;
  std::vector<render::TransferFunction> appearances;
};

/// Third-party data: SONDE_DATA_DIR, or ../shared/data beside the current folder.
std::filesystem::path bench_data_dir();

/// The simulated patient of seed 1, portal phase, as a CT. Fails only because of a bug.
Result<std::shared_ptr<const Volume>> simulated_ct();

/// Contrast-filled vessels only: transparent below 180 HU and above 480.
render::TransferFunction vessels_only();

/// The volumes of the comparison whose scene names can contain filter: the simulated patient, and
/// head, abdomen, aorta, lung and pelvis from data. Missing data is reported as skipped.
Result<std::vector<BenchVolume>> bench_volumes(const std::string& filter,
                                               const std::filesystem::path& data,
                                               Diagnostics& diagnostics);

/// Makes a BenchVolume of a CT of the user.
Result<BenchVolume> bench_volume(const std::string& name, std::shared_ptr<const Volume> ct);

/// Scenes named volume/transfer function/camera/shading, with two cameras each: perspective from
/// the patient's left front, orthographic from the front and above. Only scenes whose name contains
/// filter.
std::vector<NamedScene> bench_scenes(const std::vector<BenchVolume>& volumes,
                                     const std::string& filter, int width, int height);

/// The scene with its eye moved by frame micrometres, so that no engine can reuse an image.
render::Scene nudged(render::Scene scene, int frame);

/// The CT alone, unshaded: the scene without plane, geometry, cutaway and shading.
render::Scene bare(const render::Scene& scene);

/// The simulated patient, 300 mm a side in n voxels, n in [16, 768]: interpolated from one scan
/// with voxels of scanned_mm, with independent noise of 12 HU in every voxel.
Result<std::shared_ptr<const Volume>> cubic_patient(int n, double scanned_mm = 1.2);

}  // namespace nav::bench
