// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <vector>

namespace nav::bench {

/// Plain numbers, because ITK has its own Eigen, which must not meet ours in one source file.
struct ItkVoxels {
  std::array<int, 3> size;
  std::array<double, 3> spacing_mm;
  std::vector<float> values;
};
struct ItkTubes {
  bool bright;
  double alpha, beta, c;
  double first_sigma_mm, last_sigma_mm;
  int scales;
};

/// The filters of ITK that are compared with ours, on a copy of the same voxels. A build without
/// ITK has none.
class ItkPeer {
 public:
  ItkPeer(const ItkVoxels& voxels, int threads);
  ~ItkPeer();
  ItkPeer(const ItkPeer&) = delete;
  ItkPeer& operator=(const ItkPeer&) = delete;

  static bool built();
  /// itk::MeanImageFilter over itk::NoiseImageFilter (local standard deviation), 7^3.
  void signal_to_noise();
  /// itk::MultiScaleHessianBasedMeasureImageFilter with HessianToObjectnessMeasureImageFilter.
  void vesselness(const ItkTubes& tubes);
  /// itk::GradientMagnitudeImageFilter; with smoothing:
  /// itk::GradientMagnitudeRecursiveGaussianImageFilter.
  void gradient_magnitude(double smoothing_mm);

 private:
  struct Image;
  std::unique_ptr<Image> image_;
};

}  // namespace nav::bench
