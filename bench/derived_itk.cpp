// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/derived_itk.hpp"

#include <algorithm>
#include <itkGradientMagnitudeImageFilter.h>
#include <itkGradientMagnitudeRecursiveGaussianImageFilter.h>
#include <itkHessianToObjectnessMeasureImageFilter.h>
#include <itkImage.h>
#include <itkMeanImageFilter.h>
#include <itkMultiScaleHessianBasedMeasureImageFilter.h>
#include <itkMultiThreaderBase.h>
#include <itkNoiseImageFilter.h>

namespace nav::bench {

using Voxels = itk::Image<float, 3>;

struct ItkPeer::Image {
  Voxels::Pointer voxels = Voxels::New();
};

ItkPeer::ItkPeer(const ItkVoxels& voxels, int threads) : image_(std::make_unique<Image>()) {
  if (threads > 0) {
    itk::MultiThreaderBase::SetGlobalMaximumNumberOfThreads(static_cast<unsigned>(threads));
  }
  Voxels::SizeType size;
  Voxels::SpacingType spacing;
  for (unsigned a = 0; a < 3; ++a) {
    size[a] = static_cast<itk::SizeValueType>(voxels.size[a]);
    spacing[a] = voxels.spacing_mm[a];
  }
  image_->voxels->SetRegions(Voxels::RegionType(size));
  image_->voxels->SetSpacing(spacing);
  image_->voxels->Allocate();
  std::copy(voxels.values.begin(), voxels.values.end(), image_->voxels->GetBufferPointer());
}
ItkPeer::~ItkPeer() = default;

bool ItkPeer::built() { return true; }

void ItkPeer::signal_to_noise() {
  Voxels::SizeType radius;
  radius.Fill(3);
  const auto noise = itk::NoiseImageFilter<Voxels, Voxels>::New();
  noise->SetInput(image_->voxels);
  noise->SetRadius(radius);
  noise->Update();
  const auto mean = itk::MeanImageFilter<Voxels, Voxels>::New();
  mean->SetInput(image_->voxels);
  mean->SetRadius(radius);
  mean->Update();
}

void ItkPeer::vesselness(const ItkTubes& tubes) {
  using Tensor = itk::SymmetricSecondRankTensor<double, 3>;
  using Hessian = itk::Image<Tensor, 3>;
  const auto measure = itk::HessianToObjectnessMeasureImageFilter<Hessian, Voxels>::New();
  measure->SetObjectDimension(1);
  measure->SetScaleObjectnessMeasure(false);
  measure->SetBrightObject(tubes.bright);
  measure->SetAlpha(tubes.alpha);
  measure->SetBeta(tubes.beta);
  measure->SetGamma(tubes.c);
  const auto scales = itk::MultiScaleHessianBasedMeasureImageFilter<Voxels, Hessian, Voxels>::New();
  scales->SetInput(image_->voxels);
  scales->SetHessianToMeasureFilter(measure);
  scales->SetSigmaMinimum(tubes.first_sigma_mm);
  scales->SetSigmaMaximum(tubes.last_sigma_mm);
  scales->SetNumberOfSigmaSteps(static_cast<unsigned>(tubes.scales));
  scales->SetSigmaStepMethodToLogarithmic();
  scales->Update();
}

void ItkPeer::gradient_magnitude(double smoothing_mm) {
  if (smoothing_mm > 0) {
    const auto smooth = itk::GradientMagnitudeRecursiveGaussianImageFilter<Voxels, Voxels>::New();
    smooth->SetInput(image_->voxels);
    smooth->SetSigma(smoothing_mm);
    smooth->Update();
    return;
  }
  const auto gradient = itk::GradientMagnitudeImageFilter<Voxels, Voxels>::New();
  gradient->SetInput(image_->voxels);
  gradient->Update();
}

}  // namespace nav::bench
