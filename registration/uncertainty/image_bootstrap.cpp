// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/uncertainty/image_bootstrap.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "nav/check.hpp"
#include "nav/index.hpp"
#include "nav/matrices.hpp"
#include "registration/counter_random.hpp"
#include "registration/of_values.hpp"
#include "registration/uncertainty/sandwich.hpp"

namespace nav::registration {
namespace {

// Below this, a direction of a replicate rests on noise.
constexpr double kLeastRcond = 1e-4;
constexpr double kMostUnsolved = 0.1;
// Distance between the counters of successive replicates.
constexpr std::uint64_t kCounters = 1U << 16;

/// Terms of one ultrasound image that can be drawn, or of several.
struct Drawable {
  Vector6d gradient;
  Matrix6d hessian;
  void operator+=(const Drawable& other) {
    gradient += other.gradient;
    hessian += other.hessian;
  }
};

/// Returns for each image the sum of \p block consecutive images from it on.
std::vector<Drawable> blocks_of(const std::vector<Drawable>& images, int block) {
  std::vector<Drawable> sums;
  for (std::size_t first = 0; first < images.size(); ++first) {
    Drawable sum{Vector6d::Zero(), Matrix6d::Zero()};
    for (int i = 0; i < block; ++i) {
      sum += images[(first + as_size(i)) % images.size()];
    }
    sums.push_back(sum);
  }
  return sums;
}

/// The least symmetric matrix that is nowhere less than a or b, measured relative to a. If a is not
/// positive, returns their sum, which is not less either.
Matrix6d larger_of(const Matrix6d& a, const Matrix6d& b) {
  const Matrix6d whiten = of_values(a, inverse_square_root);
  const Matrix6d colour = of_values(a, square_root);
  const Matrix6d white = of_values(whiten * b * whiten, [](double v) { return std::max(v, 1.0); });
  const Matrix6d larger = colour * white * colour;
  return larger.allFinite() ? larger : a + b;
}

/// The images of a shape that have weight.
struct Drawables {
  std::vector<Drawable> images;
  std::vector<double> way_mm;  ///< Distance from each image to the next.
  std::string fault;           ///< Why they do not determine a pose; empty if they do.
};

Drawables drawables_of(const LocalShape& shape) {
  Drawables out;
  double way_mm = 0;
  Drawable all{Vector6d::Zero(), Matrix6d::Zero()};
  for (const ImageShape& image : shape.images) {
    way_mm += image.way_mm;
    if (!(image.weight > 0)) continue;
    if (!out.images.empty()) out.way_mm.push_back(way_mm);
    out.images.push_back({image.gradient, image.hessian});
    all += out.images.back();
    way_mm = 0;
  }
  out.fault = curvature_fault(shape.hessian);
  if (out.fault.empty()) out.fault = curvature_fault(all.hessian);
  if (!out.fault.empty()) return out;
  // Gauss–Newton Hessians are too stiff, because each patch also fits its noise.
  const Matrix6d softer = turning_into(shape.hessian, all.hessian);
  for (Drawable& one : out.images) one.hessian = softer * one.hessian * softer.transpose();
  return out;
}

std::string too_few(const char* what, int least, int found) {
  return "expected at least " + std::to_string(least) + ' ' + what + ", found " +
         std::to_string(found);
}

/// −H⁻¹ g as a twist, if H determines it.
std::optional<Vector6d> newton_step(const Drawable& sum) {
  const Eigen::LLT<Matrix6d> llt(sum.hessian);
  if (llt.info() != Eigen::Success || !(llt.rcond() > kLeastRcond)) return {};
  const Vector6d step = -(twist_from_scaled() * llt.solve(sum.gradient));
  if (!step.allFinite()) return {};
  return step;
}

double error_mm(const Vector6d& twist, const Eigen::Vector3d& from_centre) {
  const Eigen::Vector3d turn = twist.head<3>();
  return (turn.cross(from_centre) + twist.tail<3>()).norm();
}

}  // namespace

Result<void> validate(const BootstrapOptions& options) {
  const auto reject = [](const char* what) {
    return Error{ErrorCode::kUsage, std::string("bootstrap: expected ") + what};
  };
  if (options.replicates != 0 && (options.replicates < 20 || options.replicates > 100000)) {
    return reject("replicates of 20 to 100000, or 0");
  }
  if (!(options.block_mm >= 0 && options.block_mm <= 1000)) return reject("block_mm in [0, 1000]");
  return {};
}

ImageDraws::ImageDraws(const std::vector<double>& way_mm, const BootstrapOptions& options)
    : images_(static_cast<int>(way_mm.size()) + 1), block_(1), seed_(options.seed) {
  double way = 0;
  for (const double one : way_mm) way += one;
  const double mean = way_mm.empty() ? 0 : way / static_cast<double>(way_mm.size());
  // Images of one plane share all their speckle.
  const double wanted = mean > 0 ? options.block_mm / mean : images_;
  block_ = static_cast<int>(std::lround(std::clamp(wanted, 1.0, static_cast<double>(images_))));
  blocks_ = std::max(1, static_cast<int>(std::lround(static_cast<double>(images_) / block_)));
}

std::vector<int> ImageDraws::starts(int replicate) const {
  std::vector<int> out;
  std::uint64_t counter = (seed_ << 40U) + kCounters * static_cast<std::uint64_t>(replicate);
  for (int i = 0; i < blocks_; ++i) {
    out.push_back(static_cast<int>(fraction(counter++) * images_));
  }
  return out;
}

std::vector<int> ImageDraws::counts(int replicate) const {
  std::vector<int> out(as_size(images_), 0);
  for (const int start : starts(replicate)) {
    for (int i = 0; i < block_; ++i) ++out[as_size((start + i) % images_)];
  }
  return out;
}

PoseUncertainty ImageBootstrap::uncertainty() const {
  PoseUncertainty out{centre_ct, Matrix6d::Zero()};
  for (const Vector6d& twist : twists) {
    out.covariance += twist * twist.transpose() / static_cast<double>(twists.size());
  }
  return out;
}

double ImageBootstrap::tre_rms_mm(const Point<frames::Ct>& target) const {
  return valid ? uncertainty().tre_rms_mm(target) : std::numeric_limits<double>::infinity();
}

double ImageBootstrap::tre_quantile_mm(const Point<frames::Ct>& target, double share) const {
  NAV_CHECK(share >= 0 && share <= 1, share);
  if (!valid) return std::numeric_limits<double>::infinity();
  std::vector<double> errors;
  for (const Vector6d& twist : twists) {
    errors.push_back(error_mm(twist, target.mm - centre_ct.mm));
  }
  const auto at = errors.begin() + std::lround(share * static_cast<double>(errors.size() - 1));
  std::nth_element(errors.begin(), at, errors.end());
  return *at;
}

ImageBootstrap image_bootstrap(const LocalShape& shape, const BootstrapOptions& options) {
  NAV_CHECK(validate(options).has_value(), options.replicates, options.block_mm);
  ImageBootstrap out;
  out.centre_ct = shape.centre_ct;
  if (options.replicates == 0) return out;
  const Drawables all = drawables_of(shape);
  out.images = static_cast<int>(all.images.size());
  const ImageDraws draws(all.way_mm, options);
  out.block = draws.block();
  out.places = draws.blocks();
  if (out.images < kLeastImages) {
    out.fault = too_few("images with patches", kLeastImages, out.images);
  } else if (out.places < kLeastPlaces) {
    out.fault = too_few("positions at which images were acquired", kLeastPlaces, out.places);
  } else {
    out.fault = all.fault;
  }
  if (!out.fault.empty()) return out;
  const std::vector<Drawable> blocks = blocks_of(all.images, draws.block());
  // Corrects for blocks that do not add up to all images.
  const double scale = std::sqrt(static_cast<double>(draws.blocks() * draws.block()) /
                                 static_cast<double>(all.images.size()));
  for (int replicate = 0; replicate < options.replicates; ++replicate) {
    Drawable sum{Vector6d::Zero(), Matrix6d::Zero()};
    for (const int start : draws.starts(replicate)) sum += blocks[as_size(start)];
    if (const auto step = newton_step(sum)) {
      out.twists.push_back(scale * *step);
    } else {
      ++out.unsolved;
    }
  }
  if (out.unsolved > kMostUnsolved * options.replicates) {
    out.fault = "expected resampled images to determine the pose, found " +
                std::to_string(out.unsolved) + " of " + std::to_string(options.replicates) +
                " samples that do not";
    out.twists.clear();
  }
  out.valid = out.fault.empty();
  return out;
}

PoseUncertainty with_bootstrap(const SandwichCovariance& clusters, const ImageBootstrap& bootstrap,
                               double bias_floor_mm) {
  PoseUncertainty out = clusters.uncertainty;
  if (!clusters.valid || !bootstrap.valid) return out;
  const Matrix6d scale = twist_from_scaled();
  const Matrix6d scaled = symmetric_inverse(scale);
  const Matrix6d drawn = scaled * bootstrap.uncertainty().covariance * scaled +
                         bias_floor_mm * bias_floor_mm * Matrix6d::Identity();
  const Matrix6d larger = larger_of(scaled * out.covariance * scaled, drawn);
  out.covariance = scale * (0.5 * (larger + larger.transpose())) * scale;
  return out;
}

}  // namespace nav::registration
