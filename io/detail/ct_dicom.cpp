// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <set>
#include <vtkDICOMReader.h>
#include <vtkErrorCode.h>
#include <vtkExecutive.h>
#include <vtkImageData.h>
#include <vtkNew.h>

#include "io/detail/ct_readers.hpp"
#include "io/detail/dicom_series.hpp"
#include "io/detail/text.hpp"
#include "io/detail/vtk_errors.hpp"
#include "io/detail/within_memory.hpp"

namespace nav::io::detail {

namespace {

std::optional<PixelType> pixel_type(int vtk_type) {
  switch (vtk_type) {
    case VTK_UNSIGNED_CHAR:
      return PixelType::kUint8;
    case VTK_CHAR:
    case VTK_SIGNED_CHAR:
      return PixelType::kInt8;
    case VTK_UNSIGNED_SHORT:
      return PixelType::kUint16;
    case VTK_SHORT:
      return PixelType::kInt16;
    case VTK_UNSIGNED_INT:
      return PixelType::kUint32;
    case VTK_INT:
      return PixelType::kInt32;
    case VTK_FLOAT:
      return PixelType::kFloat32;
    case VTK_DOUBLE:
      return PixelType::kFloat64;
    default:
      return {};
  }
}

/// All frames of one file as stored, first row first.
struct DecodedFile {
  std::filesystem::path path;
  PixelType type = PixelType::kInt16;
  std::size_t frame_bytes = 0;
  std::vector<std::byte> samples;
};

Result<DecodedFile> decode_file(const DicomSlice& slice) {
  vtkNew<vtkDICOMReader> reader;
  VtkErrors errors;
  errors.watch(reader);
  errors.watch(reader->GetExecutive());
  silence_gdcm();
  reader->SetFileName(slice.file.c_str());
  reader->SetSorting(0);
  reader->SetAutoRescale(0);
  reader->SetMemoryRowOrderToFileNative();
  errors.run([&] { reader->Update(); });
  const auto fail = [&](const std::string& what) {
    return Error{ErrorCode::kMalformedData, slice.file.string() + ": cannot decode: " + what};
  };
  if (!errors.first().empty()) return fail(errors.first());
  if (reader->GetErrorCode() != vtkErrorCode::NoError) {
    return fail("VTK error code " + std::to_string(reader->GetErrorCode()));
  }
  vtkImageData* image = reader->GetOutput();
  const int* size = image->GetDimensions();
  if (size[0] != slice.columns || size[1] != slice.rows || size[2] < 1 ||
      image->GetNumberOfScalarComponents() != 1 || image->GetScalarPointer() == nullptr) {
    return fail("expected " + std::to_string(slice.columns) + " x " + std::to_string(slice.rows) +
                " pixels, found " + std::to_string(size[0]) + " x " + std::to_string(size[1]));
  }
  DecodedFile out;
  out.path = slice.file;
  const auto type = pixel_type(image->GetScalarType());
  if (!type) return fail(std::string("unexpected samples ") + image->GetScalarTypeAsString());
  out.type = *type;
  out.frame_bytes = static_cast<std::size_t>(slice.columns) * static_cast<std::size_t>(slice.rows) *
                    size_of(out.type);
  const auto* begin = static_cast<const std::byte*>(image->GetScalarPointer());
  out.samples.assign(begin, begin + out.frame_bytes * static_cast<std::size_t>(size[2]));
  return out;
}

/// Reports that a stack is irregular, or rejects it.
Result<void> judge_irregular(const DicomStack& stack, const DicomSeries& series,
                             const std::string& name, const CtOptions& options,
                             Diagnostics& diagnostics) {
  const std::string gap = to_text(std::round(stack.max_gap_mm * 100) / 100) + " mm before " +
                          stack.slices[stack.max_gap_at].name();
  if (stack.max_gap_mm > options.max_gap_mm) {
    return Error{ErrorCode::kMalformedData, name + ": expected gaps between slices of at most " +
                                                to_text(options.max_gap_mm) + " mm, found " + gap};
  }
  for (std::size_t k = 1; k < stack.slices.size(); ++k) {
    const double shift = stack.at_mm[k].head<2>().norm();
    const double above = stack.at_mm[k].z();
    if (shift <= above + options.max_gap_mm) continue;
    return Error{ErrorCode::kMalformedData,
                 name + ": expected slices above each other, tilted by at most 45 degrees, found " +
                     stack.slices[k].name() + " shifted by " + to_text(shift) +
                     " mm within its plane, " + to_text(above) + " mm from " +
                     stack.slices[0].name()};
  }
  const double tilt_deg = stack.tilt_rad * 180 / M_PI;
  diagnostics.report(
      "io.ct", {.subject = name,
                .key = "positions of slices",
                .values = {"tilted by " + to_text(std::round(tilt_deg * 100) / 100) + " degrees" +
                               (series.tilt_tag.empty() ? "" : " (tag: " + series.tilt_tag + ")"),
                           "gaps from " + to_text(std::round(stack.min_gap_mm * 100) / 100) +
                               " mm to " + gap},
                .used = "a regular orthogonal grid, resampled by linear interpolation"});
  return {};
}

/// Reports what contradicts the positions of a regular stack: the stated gap, which shows that
/// every second slice is missing, and numbers of images that are not there.
void compare_positions(const DicomStack& stack, const DicomSeries& series, const std::string& name,
                       Diagnostics& diagnostics) {
  constexpr double kRoundingMm = 0.06;
  constexpr double kShare = 0.01;
  const double gap_mm = stack.grid().spacing_mm.z();
  const double stated_mm = stack.slices.front().stated_gap_mm;
  if (stated_mm > 0 && std::abs(stated_mm - gap_mm) > kRoundingMm + kShare * gap_mm) {
    diagnostics.report("io.ct", {.subject = name,
                                 .key = "SpacingBetweenSlices",
                                 .values = {to_text(stated_mm) + " mm stated",
                                            to_text(gap_mm) + " mm by the positions"},
                                 .used = "the positions"});
  }
  std::set<std::int64_t> numbers;
  for (const DicomSlice& slice : stack.slices) {
    if (slice.instance) numbers.insert(*slice.instance);
  }
  if (numbers.size() != stack.slices.size()) return;
  const double range =
      static_cast<double>(*numbers.rbegin()) - static_cast<double>(*numbers.begin()) + 1;
  if (range <= static_cast<double>(numbers.size() + series.localizers)) return;
  diagnostics.report(
      "io.ct",
      {.subject = name,
       .key = "InstanceNumber",
       .values = {std::to_string(*numbers.begin()) + " to " + std::to_string(*numbers.rbegin()),
                  std::to_string(numbers.size()) + " images (are some missing?)"},
       .used = "the images that are there"});
}

/// Rejects acquisitions that alternate from slice to slice, as two phases of contrast do, whatever
/// attribute tells them apart. Acquisitions that follow each other are one volume, and so are
/// slices of which each has a time of its own.
Result<void> check_acquisitions(const DicomStack& stack, const std::string& name) {
  constexpr std::size_t kMostPhases = 8;
  for (std::size_t i = 0; i < kPhaseKeys.size(); ++i) {
    std::set<std::string> all{stack.slices.front().phase[i]};
    std::size_t changes = 0;
    for (std::size_t k = 1; k < stack.slices.size(); ++k) {
      all.insert(stack.slices[k].phase[i]);
      if (stack.slices[k].phase[i] != stack.slices[k - 1].phase[i]) ++changes;
    }
    if (changes < all.size()) continue;
    // Detectors with several rows share times between slices, which may return: only times that
    // differ from every slice to the next are phases.
    const bool alternates = changes + 1 == stack.slices.size() && all.size() <= kMostPhases;
    if (i >= kPhaseTimes && !alternates) continue;
    std::string listed;
    for (const std::string& one : all) listed += (listed.empty() ? "" : ", ") + excerpt(one);
    return Error{ErrorCode::kMalformedData,
                 name + ": expected acquisitions that follow each other, found slices of " +
                     std::to_string(all.size()) + " that alternate (" + kPhaseKeys[i] + " " +
                     listed + ")"};
  }
  return {};
}

}  // namespace

Result<HuBuilder> decode_slices(const DicomStack& stack, const std::string& name,
                                std::int16_t least) {
  HuBuilder builder(stack.grid().voxel_count(), least);
  std::optional<DecodedFile> open;  // Slices of a multi-frame file usually follow one another.
  for (const DicomSlice& slice : stack.slices) {
    if (!open || open->path != slice.file) {
      auto decoded = decode_file(slice);
      if (!decoded) return decoded.error();
      open = std::move(*decoded);
    }
    const std::size_t begin = static_cast<std::size_t>(slice.frame) * open->frame_bytes;
    if (begin + open->frame_bytes > open->samples.size()) {
      return Error{ErrorCode::kMalformedData,
                   name + ": " + slice.name() + ": expected pixel data of the frame, found none"};
    }
    builder.append(std::span(open->samples).subspan(begin, open->frame_bytes), open->type,
                   slice.rescale);
  }
  return builder;
}

namespace {

/// Decodes the slices of a stack onto a grid: their own, or the regular one of an irregular stack.
Result<StoredVolume> decode_stack(const DicomStack& stack, const DicomSeries& series,
                                  const VoxelGrid& grid, const std::string& name,
                                  Diagnostics& diagnostics, const VolumeReading& options) {
  auto builder = decode_slices(stack, name, options.least);
  if (!builder) return builder.error();
  if (series.modality == "CT") builder->set_ct();
  const auto reported = builder->report(name, stack.grid().size, options.unit, diagnostics);
  if (!reported) return reported.error();
  if (stack.regular) return StoredVolume::create(grid, builder->take(), name);
  return StoredVolume::create(grid, resample(stack, builder->hu(), grid), name);
}

}  // namespace

Result<StoredVolume> read_ct_dicom(const std::vector<std::filesystem::path>& files,
                                   const std::string& name, Diagnostics& diagnostics,
                                   const VolumeReading& options) {
  auto all = scan_dicom(files, name, diagnostics);
  if (!all) return all.error();
  auto series = choose_series(std::move(*all), name, options, diagnostics);
  if (!series) return series.error();
  const auto stack = stack_slices(std::move(series->slices), name);
  if (!stack) return stack.error();
  if (const auto ok = validate(stack->grid(), name); !ok) return ok.error();
  if (const auto ok = check_acquisitions(*stack, name); !ok) return ok.error();
  if (!stack->regular) {
    const auto ok = judge_irregular(*stack, *series, name, options, diagnostics);
    if (!ok) return ok.error();
  } else {
    compare_positions(*stack, *series, name, diagnostics);
  }
  const VoxelGrid grid = stack->regular ? stack->grid() : regular_grid(*stack);
  if (const auto ok = validate(grid, name); !ok) return ok.error();
  const double bytes =
      static_cast<double>(stack->grid().voxel_count() + grid.voxel_count()) * sizeof(std::int16_t);
  return within_memory(name, bytes, [&]() -> Result<StoredVolume> {
    return decode_stack(*stack, *series, grid, name, diagnostics, options);
  });
}

}  // namespace nav::io::detail
