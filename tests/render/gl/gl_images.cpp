// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/render/gl/gl_images.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>

namespace nav::test {
namespace {

double worst_channel(const RgbaF& p, const RgbaF& q) {
  const double worst =
      255.0 * std::max({std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)});
  return std::isnan(p.r + p.g + p.b + p.a) ? 1e9 : worst;
}

}  // namespace

void keep_image(const std::string& name, const Image2d<Rgba8>& pixels) {
  const char* folder = std::getenv("SONDE_PICTURES");
  if (folder == nullptr) return;
  vtkNew<vtkImageData> image;
  image->SetDimensions(pixels.width(), pixels.height(), 1);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
  for (int row = 0; row < pixels.height(); ++row) {
    for (int column = 0; column < pixels.width(); ++column) {
      const Rgba8& p = pixels.at(column, pixels.height() - 1 - row);
      auto* out = static_cast<unsigned char*>(image->GetScalarPointer(column, row, 0));
      out[0] = p.r;
      out[1] = p.g;
      out[2] = p.b;
    }
  }
  vtkNew<vtkPNGWriter> writer;
  writer->SetFileName((std::string(folder) + "/" + name + ".png").c_str());
  writer->SetInputData(image);
  writer->Write();
}

ImageDifference difference(const Image2d<Rgba8>& a, const Image2d<Rgba8>& b, int limit) {
  ImageDifference result;
  std::size_t above = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    const Rgba8& p = a.pixels()[i];
    const Rgba8& q = b.pixels()[i];
    const int worst = std::max({std::abs(p.r - q.r), std::abs(p.g - q.g), std::abs(p.b - q.b)});
    result.max = std::max(result.max, worst);
    if (worst > limit) ++above;
  }
  result.fraction_above = static_cast<double>(above) / static_cast<double>(a.pixels().size());
  return result;
}

ImageDifference difference(const Image2d<RgbaF>& a, const Image2d<RgbaF>& b, double limit_255) {
  ImageDifference result;
  std::size_t above = 0;
  double worst = 0;
  for (std::size_t i = 0; i < a.pixels().size(); ++i) {
    const double here = worst_channel(a.pixels()[i], b.pixels()[i]);
    worst = std::max(worst, here);
    if (here > limit_255) ++above;
  }
  result.max = static_cast<int>(std::ceil(worst));
  result.fraction_above = static_cast<double>(above) / static_cast<double>(a.pixels().size());
  return result;
}

::testing::AssertionResult agree(const Image2d<RgbaF>& actual, const Image2d<RgbaF>& expected,
                                 double limit_255) {
  if (actual.width() != expected.width() || actual.height() != expected.height()) {
    return ::testing::AssertionFailure() << "images of different size";
  }
  constexpr double kOutliers = 1e-3;  // Share of rays that graze an edge, where single and double
                                      // precision differ.
  const ImageDifference found = difference(actual, expected, limit_255);
  if (found.fraction_above <= kOutliers) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure()
         << 100 * found.fraction_above << " % of the pixels differ by more than " << limit_255
         << "/255, at most " << found.max << "/255";
}

}  // namespace nav::test
