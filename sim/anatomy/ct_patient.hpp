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
  double smooth_mm = 0.8;  ///< Standard deviation of the blur before classes are told, [0, 5].
  std::uint64_t seed = 1;  ///< Of what the CT does not tell.
  double hidden_mm = 12;   ///< Size of the variations that the CT does not show, [2, 100].
  double hidden_share =
      0.35;  ///< How strongly scatter and absorption vary by themselves, [0, 0.9].
  /// What is looked at: targets and landmarks lie within kAboutMm of it. Absent: all over the CT.
  std::optional<Point<frames::Ct>> about;
};
inline constexpr double kAboutMm = 50;

/// A patient made of a real CT: gas, lung, fat, soft tissue, enhanced blood and bone by HU, with
/// smooth shares where classes meet. Scatter, impedance and absorption are the classes' own, varied
/// by smooth random fields that do not depend on HU, so that no function of the CT predicts them.
/// hu() is the CT itself, trilinear, and its gradient that of the interpolant; outside is air.
/// targets() and landmarks() are points of soft tissue on a regular pattern: the CT brings no
/// names. Refuses options out of range, CTs without a body (no soft tissue at all), and a point to
/// look at with none of it around.
Result<std::shared_ptr<const Anatomy>> make_ct_patient(const Volume& ct,
                                                       const CtPatientOptions& options = {});
}  // namespace nav::sim
