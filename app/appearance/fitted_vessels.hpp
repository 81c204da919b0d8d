// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "app/options/session_config.hpp"
#include "nav/volume.hpp"
#include "render/transfer/transfer_function.hpp"

namespace nav::app {

/// CT and transfer function that the 3D view draws in place of others, so that the component
/// `vessels` shows the blood of this scan and no bone.
struct DrawnVessels {
  std::shared_ptr<const Volume> ct;  ///< Copy for drawing only; not in HU where bone was moved.
  render::TransferFunction transfer;
  std::string statement;  ///< One sentence: the blood that was found, or that none was.
};

/// Fits the component `vessels` of a transfer function to a CT in HU: at the point that the session
/// gives, else by the CT's histogram. If no blood is found, the function's own window stays, and
/// bone is taken out of it all the same. Takes about 0.3 s and 10 bytes a voxel for each million
/// voxels. Errors: those of render::blood_pool_at(), for a point that the session gives.
Result<DrawnVessels> drawn_vessels(const render::TransferFunction& transfer,
                                   const SessionConfig::Appearance& appearance, const Volume& ct);

}  // namespace nav::app
