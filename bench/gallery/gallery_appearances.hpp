// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "nav/volume.hpp"
#include "render/transfer/transfer_function.hpp"
#include "sim/anatomy/abdomen_phantom.hpp"

/// Transfer functions and volumes of the gallery's images.
namespace nav::bench {

/// Importances of the materials of an abdominal CT, [0, 1].
struct AbdomenImportance {
  double skin = 0.1;
  double flesh = 0.01;
  double organs = 0.5;
  double vessels = 1;
  double bone = 1;
};

/// The preset ct-portal, with other importances: skin and fat brown, flesh red, organs yellow,
/// vessels blue, bone white (Burns et al. 2007, Figure 5). Vessels are told from the rims of bones
/// by their gradient. Errors, here and below: those of app::read_preset().
Result<render::TransferFunction> abdomen_appearance(const Volume& ct,
                                                    const AbdomenImportance& importance);

/// The preset ct-native: the same colours for a CT without contrast agent, in which vessels do not
/// show.
Result<render::TransferFunction> plain_ct_appearance(const Volume& ct);

/// The preset cta-emphasis: vessels red, bone ivory, flesh and skin; vessels matter, nothing else
/// does.
Result<render::TransferFunction> angiography_appearance(const Volume& ct);

enum class MrFat { kSuppressed, kBright };

/// T1 of the simulated patient, 1.6 mm, contrast-enhanced with suppressed fat, or without contrast
/// agent with bright fat: tissue values of its own, uneven receiver gain, Rician noise. Values are
/// intensities, not HU.
Result<std::shared_ptr<const Volume>> simulated_mr(const sim::AbdomenPhantom& phantom, MrFat fat);

/// The preset mr-fat-suppressed for an MR. vessels: their importance.
Result<render::TransferFunction> mr_appearance(const Volume& mr, double vessels);

}  // namespace nav::bench
