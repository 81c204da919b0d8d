// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/shape/deformable_registration.hpp"

#include <Eigen/SparseCore>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "registration/shape/field_fit.hpp"
#include "registration/shape/paired_gain.hpp"

namespace nav::registration {
namespace {

using Vec = Eigen::Vector3d;

/// Mean cost of an image's patches without and with a field.
struct ImageCost {
  double rigid = 0, deformed = 0, weight = 0;
};

/// Adds the costs of the images that were left out of the fit.
void add_held_out(const DeformedCost& cost, const SplineField& field,
                  const std::vector<bool>& fitted, std::map<int, ImageCost>& images) {
  for (const RestingPatch& patch : cost.patches()) {
    if (fitted[static_cast<std::size_t>(patch.frame)]) continue;
    ImageCost& image = images[patch.frame];
    image.rigid += patch.weight * cost.cost(patch, Vec::Zero());
    image.deformed += patch.weight * cost.cost(patch, field.displacement(patch.centre_ct));
    image.weight += patch.weight;
  }
}

double mean_cost(const DeformedCost& cost, const SplineField* field) {
  double sum = 0;
  for (const RestingPatch& p : cost.patches()) {
    const Vec shift = field != nullptr ? field->displacement(p.centre_ct) : Vec::Zero();
    sum += p.weight * cost.cost(p, shift);
  }
  return sum;
}

/// Difference of two fields, RMS over the patches.
double rms_apart(const DeformedCost& cost, const SplineField& a, const SplineField& b) {
  double sum = 0;
  for (const RestingPatch& p : cost.patches()) {
    sum += p.weight * (a.displacement(p.centre_ct) - b.displacement(p.centre_ct)).squaredNorm();
  }
  return std::sqrt(sum);
}

double rms_displacement(const DeformedCost& cost, const SplineField& field) {
  double sum = 0;
  for (const RestingPatch& p : cost.patches()) {
    sum += p.weight * field.displacement(p.centre_ct).squaredNorm();
  }
  return std::sqrt(sum);
}

CtBox box_of_patches(const DeformedCost& cost) {
  CtBox box{Vec::Constant(1e300), Vec::Constant(-1e300)};
  for (const RestingPatch& p : cost.patches()) {
    box.low = box.low.cwiseMin(p.centre_ct);
    box.high = box.high.cwiseMax(p.centre_ct);
  }
  return box;
}

void weigh(const std::map<int, ImageCost>& images, DeformableResult& result) {
  PairedGain gain;
  for (const auto& [frame, p] : images) {
    result.held_out_rigid += p.rigid / p.weight / static_cast<double>(images.size());
    result.held_out_deformed += p.deformed / p.weight / static_cast<double>(images.size());
    gain.add((p.rigid - p.deformed) / p.weight);
  }
  result.gain_sigmas = gain.sigmas();
}

/// The images that a fit uses: every second one with patches (two halves), and all.
using Chosen = std::vector<bool>;
struct Choices {
  std::array<Chosen, 2> halves;
  Chosen all;
  int images = 0;
};
Choices choices_of(const PatchSet& patches) {
  std::set<int> numbers;
  for (const Patch& patch : patches.patches) numbers.insert(patch.frame);
  Choices out;
  if (numbers.empty()) return out;
  const auto count = static_cast<std::size_t>(*numbers.rbegin()) + 1;
  out.all.assign(count, true);
  out.halves.fill(Chosen(count, false));
  for (const int number : numbers) {
    out.halves[static_cast<std::size_t>(out.images++ % 2)][static_cast<std::size_t>(number)] = true;
  }
  return out;
}

SplineField between(const SplineField& a, const SplineField& b) {
  SplineField out = a;
  out.set_coefficients(0.5 * (a.coefficients() + b.coefficients()));
  return out;
}

/// Rejects a box that is larger than any sweep: a pose that is far off is a fault, and a field that
/// reaches there takes gigabytes.
Result<void> check_extent(const CtBox& box, double spacing_mm) {
  const double points = SplineField::control_points_over(box, spacing_mm);
  if (points <= SplineField::kMostControlPoints) return {};
  std::ostringstream text;
  text << "deformable registration: expected patches that at most "
       << SplineField::kMostControlPoints << " control points " << spacing_mm
       << " mm apart cover, found patches over " << (box.high - box.low).transpose()
       << " mm, which need " << points;
  return Error{ErrorCode::kRefused, text.str()};
}

/// The choice of the model, with its reason.
Result<DeformableResult> choose(const DeformedCost& cost, const Choices& choices,
                                const DeformableOptions& options) {
  const CtBox box = box_of_patches(cost);
  if (auto ok = check_extent(box, options.spacing_mm); !ok) return ok.error();
  const SplineField empty(box, options.spacing_mm);
  DeformableResult result{
      .field = empty, .rigid_cost = mean_cost(cost, nullptr), .min_determinant = 1};
  result.final_cost = result.rigid_cost;
  const Error not_finite{ErrorCode::kNumerical,
                         "deformable registration: expected a finite similarity of every patch"};
  if (!std::isfinite(result.rigid_cost)) return not_finite;
  std::array<FieldFit, 2> fits = {FieldFit{empty, 0, true}, FieldFit{empty, 0, true}};
  tbb::parallel_for(std::size_t{0}, fits.size(), [&](std::size_t half) {
    fits[half] = fit_field(cost, choices.halves[half], empty, options);
  });
  if (!fits[0].finite || !fits[1].finite) return not_finite;
  std::map<int, ImageCost> images;
  for (std::size_t half = 0; half < fits.size(); ++half) {
    add_held_out(cost, fits[half].field, choices.halves[half], images);
  }
  weigh(images, result);
  result.halves_disagreement_mm = rms_apart(cost, fits[0].field, fits[1].field);
  std::ostringstream text;
  text.precision(3);
  const double share = 1 - result.held_out_deformed / std::max(result.held_out_rigid, 1e-12);
  if (!(result.gain_sigmas >= options.min_gain_sigmas && share >= options.min_gain_share)) {
    text << "rigid: in images left out of the fit, a deformation reduced the cost by "
         << 100 * share << " % (" << result.gain_sigmas << " standard errors), expected at least "
         << 100 * options.min_gain_share << " % (" << options.min_gain_sigmas << ')';
    result.reason = text.str();
    return result;
  }
  const FieldFit all = fit_field(cost, choices.all, between(fits[0].field, fits[1].field), options);
  if (!all.finite) return not_finite;
  result.iterations = fits[0].iterations + fits[1].iterations + all.iterations;
  result.min_determinant = all.field.min_determinant();
  result.max_gradient = all.field.gradient_bound();
  result.displacement_mm = rms_displacement(cost, all.field);
  if (!(result.displacement_mm >= options.min_displacement_mm)) {
    text << "rigid: the deformation moves tissue by " << result.displacement_mm
         << " mm RMS, expected at least " << options.min_displacement_mm;
    result.reason = text.str();
    return result;
  }
  if (!(result.min_determinant >= options.min_determinant)) {
    text << "rigid: the deformation compresses tissue to " << result.min_determinant
         << " of its volume, expected at least " << options.min_determinant;
    result.reason = text.str();
    return result;
  }
  result.field = all.field;
  result.supported = true;
  result.bending_energy_mm = all.field.bending_energy_mm();
  result.final_cost = mean_cost(cost, &result.field);
  text << "deformable: in images left out of the fit, the deformation reduced the cost by "
       << 100 * share << " % (" << result.gain_sigmas
       << " standard errors); it compresses tissue to no less than " << result.min_determinant
       << " of its volume";
  result.reason = text.str();
  return result;
}

}  // namespace

Result<void> validate(const DeformableOptions& o) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("deformable registration: expected ") + what};
  };
  if (!(o.spacing_mm >= 10 && o.spacing_mm <= 200)) return reject("a spacing of 10 to 200 mm");
  if (!(o.bending > 0 && std::isfinite(o.bending))) return reject("bending > 0");
  if (o.max_iterations < 1 || o.max_iterations > 100) return reject("1 to 100 iterations");
  if (!(o.ridge > 0 && std::isfinite(o.ridge))) return reject("ridge > 0");
  if (!(o.contrast_power >= 0 && o.contrast_power <= 3)) return reject("contrast_power in [0, 3]");
  if (!(o.min_gain_share >= 0 && o.min_gain_share < 1)) return reject("min_gain_share in [0, 1)");
  if (!(o.min_gain_sigmas > 0)) return reject("min_gain_sigmas > 0");
  if (!(o.min_displacement_mm >= 0)) return reject("min_displacement_mm >= 0");
  if (o.threads < 1 || o.threads > 64) return reject("1 to 64 threads");
  if (!(o.min_determinant > 0 && o.min_determinant < 1)) return reject("min_determinant in (0, 1)");
  return {};
}

Result<DeformableResult> refine_deformable(const CtChannels& ct, const PatchSet& patches,
                                           const Pose& ct_from_reference,
                                           const DeformableOptions& options) {
  constexpr int kMinImages = 4;
  if (const auto ok = validate(options); !ok) return ok.error();
  const Choices choices = choices_of(patches);
  if (choices.images < kMinImages) {
    return Error{ErrorCode::kRefused,
                 "deformable registration: expected at least 4 images with patches, found " +
                     std::to_string(choices.images)};
  }
  const DeformedCost cost(ct, patches, ct_from_reference, options);
  std::optional<Result<DeformableResult>> result;
  tbb::task_arena arena(options.threads);
  arena.execute([&] { result = choose(cost, choices, options); });
  return *result;
}

}  // namespace nav::registration
