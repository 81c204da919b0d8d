// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "nav/volume.hpp"
#include "sim/anatomy/anatomy.hpp"

namespace nav::sim {

struct CtPatientOptions {
  double smooth_mm = 0.8;  ///< Standard deviation of the blur before the classification, [0, 5].
  std::uint64_t seed = 1;  ///< Seed of the properties that the CT does not determine.
  double hidden_mm = 12;   ///< Size of the variations that the CT does not show, [2, 100].
  double hidden_share =
      0.35;  ///< Strength of the independent variation of scatter and absorption, [0, 0.9].
  /// Centre of the imaged region: targets and landmarks lie within kAboutMm of it. Absent: they are
  /// all over the CT.
  std::optional<Point<frames::Ct>> about;
};
inline constexpr double kAboutMm = 50;

/// Makes a patient from a real CT: gas, lung, fat, soft tissue, enhanced blood and bone by HU, with
/// smooth shares between classes. Scatter, impedance and absorption are those of the classes,
/// varied by smooth random fields that do not depend on HU, so that no function of the CT predicts
/// them. hu() is the CT itself, trilinear, with the gradient of the interpolant; outside is air.
/// targets() and landmarks() are points of soft tissue on a regular pattern, because the CT has no
/// names. Rejects options out of range, CTs without a body (no soft tissue at all), and a point \p
/// about without soft tissue around it.
Result<std::shared_ptr<const Anatomy>> make_ct_patient(const Volume& ct,
                                                       const CtPatientOptions& options = {});
}  // namespace nav::sim
