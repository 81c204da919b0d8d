// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "nav/result.hpp"
#include "nav/volume.hpp"
#include "render/transfer/transfer_function.hpp"

namespace nav::render {

/// Blood with contrast agent in a CT, and the soft tissue around it.
struct BloodPool {
  double mean_hu;
  double sigma_hu;   ///< Spread of the values of homogeneous blood, >= kLeastBloodSigmaHu.
  double tissue_hu;  ///< Brightest soft tissue.
};
inline constexpr double kLeastBloodSigmaHu = 8;

/// Finds the blood pool in the histogram of the homogeneous voxels that no bone encloses: the
/// brightest peak from 130 to 700 HU of at least 2 ml, in whose window lie at most 2.5 l. kNotFound
/// when there is none, as in a CT without contrast agent or of a model.
Result<BloodPool> find_blood_pool(const Volume& ct);
/// The blood pool at a point inside a vessel: median and spread of the voxels within 3 mm.
/// kUsage for a point outside the CT or a value that is no contrast-filled blood (130 to 1500 HU).
Result<BloodPool> blood_pool_at(const Volume& ct, const Point<frames::Ct>& at);

/// Values of blood: full opacity from full_from to full_to, none outside zero_below and zero_above.
struct VesselWindow {
  double zero_below, full_from, full_to, zero_above;  ///< HU, ascending.
};
/// Window of a blood pool: its lower ramp lies between tissue and blood, where partial volumes of
/// vessels lie.
VesselWindow vessel_window(const BloodPool& pool);

/// Kind of a voxel.
enum class VesselClass : std::uint8_t {
  kRest,      ///< Below the window, or near a vessel.
  kVessel,    ///< In the window, and not in bone.
  kBone,      ///< Above the window, enclosed by such voxels (marrow), or their rim.
  kFragment,  ///< In the window, but of a component below the least volume.
  kImplant,   ///< Above the window inside a vessel: a stent or plaque. It has no rim of bone.
};

struct VesselClasses {
  std::vector<VesselClass> voxels;  ///< In the order of the CT's voxels.
  double vessel_ml = 0;
  double bone_ml = 0;
  double fragment_ml = 0;
};

/// Least volume of a component of vessels that is drawn, ml.
inline constexpr double kLeastVesselMl = 0.3;

/// Tells vessels from bone. Bone: voxels above the window; what closed contours of at most 25 cm²
/// of them enclose in a slice of any of the three orientations; and what lies nearer to these than
/// to blood and falls off from them, up to 3 mm. Blood: homogeneous components of at least 1 ml of
/// which bone encloses at most half. Components above the window that lie within two voxels of
/// blood by at least half are implants. least_ml: smaller components are fragments. Deterministic.
VesselClasses classify_vessels(const Volume& ct, const VesselWindow& window,
                               double least_ml = kLeastVesselMl);

/// A CT and a transfer function that together draw vessels without bone, by any engine.
struct SeparatedVessels {
  std::shared_ptr<const Volume> ct;
  TransferFunction transfer;
};
/// Value that separate_vessels() adds to voxels of bone and to a rim of two voxels around it.
/// Between bone and its surroundings values pass the window of vessels within 2 % of a voxel.
inline constexpr int kSeparationHu = 28672;

/// Moves bone with its rim, and implants, to values of their own, kSeparationHu higher. There the
/// function has its components again, without `vessels`. Fragments take the value below the window.
/// Everything else looks as before. The copy
/// of the CT is for drawing only; its values are not HU. Precondition: classes of this CT.
Result<SeparatedVessels> separate_vessels(const Volume& ct, const VesselClasses& classes,
                                          const VesselWindow& window,
                                          const TransferFunction& transfer,
                                          const std::string& vessels);

/// A transfer function whose component `vessels` has a window, without a gradient window, and whose
/// component `organs` ends where vessels begin. Unknown components are left out.
Result<TransferFunction> with_vessel_window(const TransferFunction& transfer,
                                            const VesselWindow& window, const std::string& vessels,
                                            const std::string& organs);
/// The window of a component as it is.
VesselWindow window_of(const TransferComponent& component);

}  // namespace nav::render
