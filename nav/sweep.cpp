// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/sweep.hpp"

#include <sstream>

namespace nav {

Result<Sweep> Sweep::create(std::vector<TrackedImage> frames, std::string calibration_id) {
  if (frames.empty()) {
    return Error{ErrorCode::kMalformedData, "sweep: expected at least one tracked image, found 0"};
  }
  const auto reject = [](std::size_t index, const std::string& what) {
    return Error{ErrorCode::kMalformedData, "sweep image " + std::to_string(index) + ": " + what};
  };
  for (TrackedImage& tracked : frames) tracked.frame.colours = {};
  const auto& first = frames.front().frame.pixels;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto& pixels = frames[i].frame.pixels;
    if (pixels.empty()) return reject(i, "expected an image, found 0 pixels");
    if (pixels.width() != first.width() || pixels.height() != first.height()) {
      std::ostringstream text;
      text << "expected " << first.width() << " x " << first.height() << " pixels, found "
           << pixels.width() << " x " << pixels.height();
      return reject(i, text.str());
    }
    if (i > 0 && frames[i].frame.acquired <= frames[i - 1].frame.acquired) {
      std::ostringstream text;
      text << "expected a time after " << to_seconds(frames[i - 1].frame.acquired) << " s, found "
           << to_seconds(frames[i].frame.acquired) << " s";
      return reject(i, text.str());
    }
  }
  return Sweep(std::move(frames), std::move(calibration_id));
}

Point<frames::Reference> Sweep::centroid() const {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TrackedImage& tracked : frames_) {
    const auto& pixels = tracked.frame.pixels;
    const auto centre =
        tracked.frame.grid.at(0.5 * (pixels.width() - 1), 0.5 * (pixels.height() - 1));
    sum += (tracked.reference_from_image * centre).mm;
  }
  return {sum / static_cast<double>(frames_.size())};
}

}  // namespace nav
