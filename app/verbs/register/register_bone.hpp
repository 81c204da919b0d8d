// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "app/report.hpp"
#include "nav/sweep.hpp"
#include "nav/volume.hpp"
#include "registration/bone/bone_registration.hpp"

namespace nav::app {

/// A registration by bone with what it was made of.
struct BoneOutcome {
  registration::BoneRegistration result;
  std::optional<double> threshold_hu;  ///< CT value of bone; absent: a mesh was given.
};

/// Share of the scan lines from which on a sweep shows enough bone to be registered by it.
inline constexpr double kEnoughBone = 0.1;

/// Registers the bone that a sweep shows to that of the CT within reach of the sweep, or to a mesh
/// (surface, or empty). threads: 0 for all cores. keep_going: false ends with kCancelled. Errors
/// name the file; kRefused if the sweep or the CT shows hardly any bone.
Result<BoneOutcome> register_bone_of(const Sweep& sweep, const Volume& ct,
                                     const std::filesystem::path& surface,
                                     const Transform<frames::Ct, frames::Reference>& start,
                                     int threads, const std::function<bool()>& keep_going);

/// JSON of a registration by bone (docs/json.md).
io::Json json_of(const BoneOutcome& outcome, const registration::Decision& decision,
                 const Point<frames::Ct>& target);

}  // namespace nav::app
