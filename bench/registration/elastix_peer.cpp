// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/elastix_peer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <unistd.h>

#include "bench/registration/child_program.hpp"
#include "registration/similarity/shadow_mask.hpp"

namespace nav::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kVoxelMm = 1.0;
constexpr std::int16_t kLowestHu = -150;
constexpr std::int16_t kHighestHu = 250;

/// Axes and voxels of a volume; MetaImage lists the axes one after the other.
void write_header(const fs::path& file, const std::array<int, 3>& size,
                  const Eigen::Vector3d& spacing, const Eigen::Vector3d& origin,
                  const Eigen::Matrix3d& axes, const std::string& type, const std::string& raw) {
  std::ofstream out(file);
  out.precision(17);
  out << "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\n"
      << "TransformMatrix =";
  for (int axis = 0; axis < 3; ++axis) {
    for (int row = 0; row < 3; ++row) out << ' ' << axes(row, axis);
  }
  out << "\nOffset = " << origin.x() << ' ' << origin.y() << ' ' << origin.z()
      << "\nElementSpacing = " << spacing.x() << ' ' << spacing.y() << ' ' << spacing.z()
      << "\nDimSize = " << size[0] << ' ' << size[1] << ' ' << size[2] << "\nElementType = " << type
      << "\nElementDataFile = " << raw << '\n';
}

template <class T>
void write_raw(const fs::path& file, const T* values, std::size_t count) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(values),  // NOLINT: bytes of a file.
            static_cast<std::streamsize>(count * sizeof(T)));
}

/// Mean grey of each voxel of a box in Reference.
struct Compound {
  std::array<int, 3> size{};
  Eigen::Vector3d origin;  ///< Reference, mm.
  std::vector<std::uint8_t> grey, mask;
};

Compound compound(const Sweep& sweep, const std::vector<Image2d<std::uint8_t>>& masks) {
  std::vector<std::pair<Eigen::Vector3d, std::uint8_t>> pixels;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300);
  Eigen::Vector3d high = -low;
  for (std::size_t i = 0; i < sweep.frames().size(); ++i) {
    const TrackedImage& tracked = sweep.frames()[i];
    const UltrasoundImage& frame = tracked.frame;
    for (int row = 0; row < frame.pixels.height(); ++row) {
      for (int column = 0; column < frame.pixels.width(); ++column) {
        if (masks[i].at(column, row) == 0) continue;
        const auto p = frame.grid.at(column, row);
        pixels.emplace_back((tracked.reference_from_image * p).mm, frame.pixels.at(column, row));
        low = low.cwiseMin(pixels.back().first);
        high = high.cwiseMax(pixels.back().first);
      }
    }
  }
  Compound out{{}, low, {}, {}};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    out.size[axis] = static_cast<int>((high[a] - low[a]) / kVoxelMm) + 1;
  }
  const auto index = [&](const Eigen::Vector3d& p) {
    const Eigen::Array3i at =
        ((p - low) / kVoxelMm)
            .array()
            .round()
            .cast<int>()
            .min(Eigen::Array3i(out.size[0] - 1, out.size[1] - 1, out.size[2] - 1));
    return (static_cast<std::size_t>(at[2]) * static_cast<std::size_t>(out.size[1]) +
            static_cast<std::size_t>(at[1])) *
               static_cast<std::size_t>(out.size[0]) +
           static_cast<std::size_t>(at[0]);
  };
  const std::size_t voxels = static_cast<std::size_t>(out.size[0]) *
                             static_cast<std::size_t>(out.size[1]) *
                             static_cast<std::size_t>(out.size[2]);
  std::vector<std::uint32_t> sum(voxels, 0), count(voxels, 0);
  for (const auto& [p, grey] : pixels) {
    sum[index(p)] += grey;
    ++count[index(p)];
  }
  out.grey.resize(voxels);
  out.mask.resize(voxels);
  double mean = 0;
  for (const auto& [p, grey] : pixels) mean += grey / static_cast<double>(pixels.size());
  for (std::size_t i = 0; i < voxels; ++i) {
    out.mask[i] = count[i] > 0 ? 1 : 0;
    // The pyramid smooths across the mask: a grey that differs from the mean would make an edge
    // there.
    out.grey[i] = static_cast<std::uint8_t>(count[i] > 0 ? sum[i] / count[i] : std::lround(mean));
  }
  return out;
}

void write_parameters(const fs::path& file, const ElastixEffort& effort) {
  std::ofstream(file) << R"((FixedInternalImagePixelType "float")
(MovingInternalImagePixelType "float")
(FixedImageDimension 3)
(MovingImageDimension 3)
(UseDirectionCosines "true")
(Registration "MultiResolutionRegistration")
(Interpolator "LinearInterpolator")
(ResampleInterpolator "FinalBSplineInterpolator")
(Resampler "DefaultResampler")
(FixedImagePyramid "FixedRecursiveImagePyramid")
(MovingImagePyramid "MovingRecursiveImagePyramid")
(Optimizer "AdaptiveStochasticGradientDescent")
(Transform "EulerTransform")
(Metric "AdvancedMattesMutualInformation")
(AutomaticScalesEstimation "true")
(AutomaticTransformInitialization "false")
(HowToCombineTransforms "Compose")
(NumberOfHistogramBins 32)
(ErodeMask "false")
(ImageSampler "RandomCoordinate")
(NewSamplesEveryIteration "true")
(DefaultPixelValue -1000)
(WriteResultImage "false")
)"
                      << "(NumberOfResolutions " << effort.resolutions
                      << ")\n(MaximumNumberOfIterations " << effort.iterations
                      << ")\n(NumberOfSpatialSamples " << effort.samples << ")\n";
}

/// Time to read the images in seconds, from the log.
double reading_s(const fs::path& log) {
  std::ifstream in(log);
  const std::string label = "Reading images took ";
  for (std::string line; std::getline(in, line);) {
    const std::size_t at = line.find(label);
    if (at == std::string::npos) continue;
    std::istringstream text(line.substr(at + label.size()));
    double number = 0;
    std::string unit;
    text >> number >> unit;
    return unit.rfind("ms", 0) == 0 ? 1e-3 * number : number;
  }
  return 0;
}

/// Numbers that follow "(name " in a transform file.
std::vector<double> numbers_of(const fs::path& file, const std::string& name) {
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    if (line.rfind("(" + name + " ", 0) != 0) continue;
    std::istringstream text(line.substr(name.size() + 2));
    std::vector<double> numbers;
    for (double number = 0; text >> number;) numbers.push_back(number);
    return numbers;
  }
  return {};
}

/// ITK's Euler transform: R = Rz Rx Ry about a centre.
std::optional<Transform<frames::Ct, frames::Ct>> read_transform(const fs::path& file) {
  const auto p = numbers_of(file, "TransformParameters");
  const auto c = numbers_of(file, "CenterOfRotationPoint");
  if (p.size() != 6 || c.size() != 3) return {};
  const Eigen::Quaterniond q = Eigen::AngleAxisd(p[2], Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(p[0], Eigen::Vector3d::UnitX()) *
                               Eigen::AngleAxisd(p[1], Eigen::Vector3d::UnitY());
  const Eigen::Vector3d centre(c[0], c[1], c[2]);
  const Eigen::Vector3d shift(p[3], p[4], p[5]);
  if (!q.coeffs().allFinite() || !shift.allFinite() || !centre.allFinite()) return {};
  return Transform<frames::Ct, frames::Ct>(q.normalized(), centre - q * centre + shift);
}

}  // namespace

std::optional<fs::path> find_elastix() {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path != nullptr ? path : "");
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path file = fs::path(folder) / "elastix";
    if (!folder.empty() && access(file.c_str(), X_OK) == 0) return file;
  }
  return {};
}

double startup_s(const fs::path& elastix) {
  const auto run = run_program({elastix.string(), "--version"});
  return run ? run->cpu_s : 0;
}

Result<void> write_elastix_case(const Patient& patient, const RecordedSweep& recorded,
                                const fs::path& folder) {
  const VoxelGrid& grid = patient.ct->grid();
  // The window of soft tissue that our similarity uses: histograms of air and bone would help
  // neither side.
  std::vector<std::int16_t> hu(patient.ct->hu().begin(), patient.ct->hu().end());
  for (std::int16_t& value : hu) value = std::clamp<std::int16_t>(value, kLowestHu, kHighestHu);
  write_raw(folder / "ct.raw", hu.data(), hu.size());
  write_header(folder / "ct.mhd", grid.size, grid.spacing_mm, grid.origin_mm, grid.directions,
               "MET_SHORT", "ct.raw");
  const auto masks = registration::shadow_masks(recorded.sweep, {});
  if (!masks) return masks.error();
  const Compound us = compound(recorded.sweep, *masks);
  write_raw(folder / "us.raw", us.grey.data(), us.grey.size());
  write_raw(folder / "mask.raw", us.mask.data(), us.mask.size());
  std::ofstream layout(folder / "layout");
  layout.precision(17);
  layout << us.size[0] << ' ' << us.size[1] << ' ' << us.size[2] << ' ' << us.origin.transpose();
  if (layout.flush()) return {};
  return Error{ErrorCode::kIo, folder.string() + ": cannot write the case for elastix"};
}

Result<ElastixRun> run_elastix(const fs::path& elastix, const fs::path& folder, const CtPose& start,
                               const ElastixEffort& effort) {
  std::ifstream layout(folder / "layout");
  std::array<int, 3> size{};
  Eigen::Vector3d origin;
  layout >> size[0] >> size[1] >> size[2] >> origin.x() >> origin.y() >> origin.z();
  if (!layout)
    return Error{ErrorCode::kIo, folder.string() + ": expected a case for elastix, found none"};
  // The start is included in the positions of the sweep's voxels: elastix then starts from
  // identity.
  const Eigen::Matrix3d axes = start.rotation().toRotationMatrix();
  const Eigen::Vector3d at = (start * Point<frames::Reference>{origin}).mm;
  const Eigen::Vector3d spacing = Eigen::Vector3d::Constant(kVoxelMm);
  for (const std::string name : {"us", "mask"}) {
    write_header(folder / (name + ".mhd"), size, spacing, at, axes, "MET_UCHAR", name + ".raw");
  }
  write_parameters(folder / "rigid.txt", effort);
  const auto run =
      run_program({elastix.string(), "-f", (folder / "us.mhd").string(), "-fMask",
                   (folder / "mask.mhd").string(), "-m", (folder / "ct.mhd").string(), "-p",
                   (folder / "rigid.txt").string(), "-out", folder.string(), "-threads", "1"});
  const bool done = run && run->exit_code == 0;
  const auto moved = done ? read_transform(folder / "TransformParameters.0.txt") : std::nullopt;
  if (!moved) {
    return Error{ErrorCode::kRefused, "elastix: expected a transform, found none; its log: " +
                                          (folder / "elastix.log").string()};
  }
  return ElastixRun{*moved * start, run->cpu_s, reading_s(folder / "elastix.log")};
}

}  // namespace nav::bench
