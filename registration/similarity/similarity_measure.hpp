// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "nav/transform.hpp"
#include "registration/image_registration.hpp"
#include "registration/similarity/ct_channels.hpp"
#include "registration/similarity/lc2_kernel.hpp"
#include "registration/similarity/patches.hpp"

namespace nav::registration {

using Pose = Transform<frames::Ct, frames::Reference>;
struct CostTerms;
class PatchMeasure;
class SampleMeasure;

/// A similarity measure of ultrasound and CT. Implementations have no state and may be used by
/// several threads at once. A measure is either a PatchMeasure or a SampleMeasure.
class SimilarityMeasure {
 public:
  virtual ~SimilarityMeasure() = default;
  /// Stable lower-case name: "lc2".
  [[nodiscard]] virtual const char* name() const = 0;
  /// Power of the samples' step with which the tolerance of a solve grows: the flatter the cost is
  /// near its minimum, the smaller.
  [[nodiscard]] virtual double tolerance_power() const = 0;
  /// This measure if its cost is a weighted sum of terms of single patches, else null. Losses,
  /// errors of the system, a strain and the choice of patches with structure need such terms.
  [[nodiscard]] virtual const PatchMeasure* by_patch() const { return nullptr; }
  /// This measure if its cost is of all samples together, else null.
  [[nodiscard]] virtual const SampleMeasure* by_samples() const { return nullptr; }
};

/// A measure with a term of [0, 1] for each patch. ridge > 0: noise of the CT channels, 100 HU.
class PatchMeasure : public SimilarityMeasure {
 public:
  [[nodiscard]] double tolerance_power() const override { return 4; }
  [[nodiscard]] const PatchMeasure* by_patch() const final { return this; }
  /// The term, NaN if any sample of the CT is not finite.
  [[nodiscard]] virtual double cost(const CtChannels& ct, const PlacedPatch& patch,
                                    double ridge) const = 0;
  /// The term with the gradient of its half, and the Hessian, which is 0 if it is not requested.
  [[nodiscard]] virtual PatchTerms terms(const CtChannels& ct, const PlacedPatch& patch,
                                         double ridge, bool with_hessian) const = 0;
};

/// A measure of all samples together, [0, 1].
class SampleMeasure : public SimilarityMeasure {
 public:
  [[nodiscard]] const SampleMeasure* by_samples() const final { return this; }
  [[nodiscard]] virtual CostTerms cost(const CtChannels& ct, const PatchSet& patches,
                                       const Pose& ct_from_reference) const = 0;
  /// The cost and the derivatives of its half by a twist about a centre; patch_gradients if they
  /// are requested.
  [[nodiscard]] virtual CostTerms terms(const CtChannels& ct, const PatchSet& patches,
                                        const Pose& ct_from_reference,
                                        const Eigen::Vector3d& centre_ct_mm,
                                        bool keep_patch_gradients) const = 0;
};

/// The implementation of a measure; it lives as long as the program.
const SimilarityMeasure& measure_of(Similarity similarity);

}  // namespace nav::registration
