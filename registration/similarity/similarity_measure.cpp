// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/similarity/similarity_measure.hpp"

#include "registration/similarity/mutual_information.hpp"

namespace nav::registration {
namespace {

/// LC² or, with the CT's intensity alone, NCC (lc2_kernel.hpp).
class LinearCombination final : public PatchMeasure {
 public:
  LinearCombination(const char* name, bool intensity_only)
      : name_(name), intensity_only_(intensity_only) {}
  [[nodiscard]] const char* name() const override { return name_; }
  [[nodiscard]] double cost(const CtChannels& ct, const PlacedPatch& patch,
                            double ridge) const override {
    return patch_cost(ct, patch, ridge, intensity_only_);
  }
  [[nodiscard]] PatchTerms terms(const CtChannels& ct, const PlacedPatch& patch, double ridge,
                                 bool with_hessian) const override {
    return with_hessian ? patch_terms(ct, patch, ridge, intensity_only_)
                        : patch_gradient(ct, patch, ridge, intensity_only_);
  }

 private:
  const char* name_;
  bool intensity_only_;
};

class MutualInformation final : public SampleMeasure {
 public:
  [[nodiscard]] const char* name() const override { return "mi"; }
  // It hardly falls towards its minimum.
  [[nodiscard]] double tolerance_power() const override { return 2; }
  [[nodiscard]] CostTerms cost(const CtChannels& ct, const PatchSet& patches,
                               const Pose& ct_from_reference) const override {
    return mutual_information(ct, patches, ct_from_reference);
  }
  [[nodiscard]] CostTerms terms(const CtChannels& ct, const PatchSet& patches,
                                const Pose& ct_from_reference, const Eigen::Vector3d& centre_ct_mm,
                                bool keep_patch_gradients) const override {
    return mutual_information_terms(ct, patches, ct_from_reference, centre_ct_mm,
                                    keep_patch_gradients);
  }
};

}  // namespace

const SimilarityMeasure& measure_of(Similarity similarity) {
  static const LinearCombination lc2("lc2", false);
  static const LinearCombination ncc("ncc", true);
  static const MutualInformation mi;
  switch (similarity) {
    case Similarity::kNcc:
      return ncc;
    case Similarity::kMutualInformation:
      return mi;
    case Similarity::kLc2:
      break;
  }
  return lc2;
}

const char* to_string(Similarity similarity) { return measure_of(similarity).name(); }

}  // namespace nav::registration
