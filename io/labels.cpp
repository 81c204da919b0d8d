// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/labels.hpp"

#include <cmath>
#include <limits>
#include <optional>

#include "io/detail/ct_readers.hpp"
#include "io/detail/text.hpp"

namespace nav::io {
namespace {

class LabelSink final : public detail::VoxelSink {
 public:
  void reserve(std::size_t voxel_count) override { values_.reserve(voxel_count); }
  void append(std::span<const std::byte> samples, PixelType type,
              const detail::Rescale& rescale) override {
    detail::for_each_sample(samples, type, [&](auto stored) {
      push(rescale.slope * static_cast<double>(stored) + rescale.intercept);
    });
  }
  /// First value that is not a label.
  struct Misfit {
    double value;
    std::size_t index;
  };
  [[nodiscard]] const std::optional<Misfit>& misfit() const { return misfit_; }
  [[nodiscard]] std::vector<std::uint32_t> take() { return std::move(values_); }

 private:
  void push(double value) {
    constexpr double kMost = std::numeric_limits<std::uint32_t>::max();
    const bool fits = value >= 0 && value <= kMost && value == std::trunc(value);
    if (!fits && !misfit_) misfit_ = {value, values_.size()};
    values_.push_back(fits ? static_cast<std::uint32_t>(value) : 0);
  }
  std::vector<std::uint32_t> values_;
  std::optional<Misfit> misfit_;
};

}  // namespace

Result<LabelFile> read_labels(const std::filesystem::path& path, Diagnostics& diagnostics) {
  LabelSink sink;
  detail::VolumeReading reading;
  reading.least_slices = 1;  // Ultrasound may have a single slice.
  const auto grid = detail::read_voxels(path, sink, diagnostics, reading);
  if (!grid) {
    return Error{
        ErrorCode::kUnsupportedData,
        path.string() +
            ": expected labels as .nii, .nii.gz, .mha, .mhd, .nrrd or .nhdr, found another "
            "kind of file"};
  }
  if (!*grid) return grid->error();
  if (const auto& misfit = sink.misfit()) {
    const auto row = static_cast<std::size_t>((*grid)->size[0]);
    const std::size_t slice = row * static_cast<std::size_t>((*grid)->size[1]);
    const std::size_t i = misfit->index;
    return Error{
        ErrorCode::kMalformedData,
        path.string() + ": expected labels that are whole numbers from 0 to 4294967295, found " +
            detail::to_text(misfit->value) + " at index (" + std::to_string(i % row) + ", " +
            std::to_string(i % slice / row) + ", " + std::to_string(i / slice) + ")"};
  }
  return LabelFile{**grid, sink.take()};
}

}  // namespace nav::io
