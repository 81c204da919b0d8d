// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/step_search.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace nav::render {
namespace {

constexpr int kColumns = 64;
constexpr double kCoarsest = 4;      // Voxels.
constexpr int kSteps = 11;           // Down to 1/8 voxel.
constexpr std::size_t kPerHalf = 2;  // Steps from one to half of it.
constexpr double kMargin = 0.95;     // The estimate may say too little.

/// The CT alone, in few pixels.
Scene few_rays(const Scene& scene) {
  Scene few = scene;
  few.plane.reset();
  few.needle.reset();
  few.spheres.clear();
  few.lines.clear();
  few.cutaway.reset();
  few.predicates.reset();
  few.ultrasound.reset();
  few.quality.pixel_error = 0;
  few.width = kColumns;
  few.height = std::max(1, (kColumns * scene.height + scene.width / 2) / scene.width);
  return few;
}

/// Where errors that follow a power of the step pass an error; fine itself where they do not.
StepChoice between(const StepChoice& coarse, const StepChoice& fine, double rms) {
  if (!(fine.rms > 0 && fine.rms < rms && rms < coarse.rms)) return fine;
  const double share = std::log(rms / fine.rms) / std::log(coarse.rms / fine.rms);
  return {fine.step_voxels * std::pow(coarse.step_voxels / fine.step_voxels, share), rms, true};
}

/// 2^p, from two differences, the coarser one first.
double ratio_of(double coarse, double fine) {
  return fine > 0 ? std::clamp(coarse / fine, 2.0, 4.0) : 4.0;
}

}  // namespace

Result<StepChoice> step_for_error(Engine& engine, const Scene& scene, double rms) {
  if (!(rms > 0 && rms <= 1)) {
    return Error{ErrorCode::kUsage,
                 "step for an error: expected an rms in (0, 1], found " + std::to_string(rms)};
  }
  Scene few = few_rays(scene);
  std::vector<double> steps;
  std::vector<Image2d<RgbaF>> pictures;
  std::vector<double> differences;  // From a step to half of it.
  const auto draw = [&]() -> Result<void> {
    steps.push_back(kCoarsest * std::pow(2.0, -0.5 * static_cast<double>(steps.size())));
    few.quality.step_voxels = steps.back();
    auto image = engine.render(few);
    if (!image) return image.error();
    pictures.push_back(std::move(image->pixels));
    return {};
  };
  StepChoice choice;
  StepChoice coarser;
  for (std::size_t i = 0; i < kSteps; ++i) {
    while (pictures.size() <= i + kPerHalf) {
      if (auto ok = draw(); !ok) return ok.error();
    }
    differences.push_back(rms_difference(pictures[i], pictures[i + kPerHalf]));
    const double ratio = i < kPerHalf ? 2.0 : ratio_of(differences[i - kPerHalf], differences[i]);
    coarser = std::exchange(choice, {steps[i], differences[i] * ratio / (ratio - 1), false});
    choice.reached = choice.rms <= rms;
    if (choice.reached) break;
  }
  return choice.reached && coarser.rms > 0 ? between(coarser, choice, kMargin * rms) : choice;
}

}  // namespace nav::render
