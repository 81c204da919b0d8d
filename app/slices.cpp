// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/slices.hpp"

#include <sstream>

#include "app/output_folder.hpp"
#include "io/ct.hpp"
#include "render/canvas.hpp"
#include "render/slice.hpp"

namespace nav::app {
namespace {

Result<render::SlabMode> slab_mode(const std::string& name) {
  if (name == "maximum") return render::SlabMode::kMaximum;
  if (name == "minimum") return render::SlabMode::kMinimum;
  if (name == "mean") return render::SlabMode::kMean;
  return Error{ErrorCode::kUsage, "--mode: expected maximum, minimum or mean, found " + name};
}

/// The slice's grey picture with its name and the letters of its edges.
Image2d<Rgba8> labelled(const Image2d<Rgba8>& grey, const std::string& name,
                        const render::SliceLabels& labels) {
  render::Canvas canvas(grey.width(), grey.height(), render::rgb8(0));
  canvas.copy(grey, 0, 0);
  const Rgba8 colour = render::rgb8(0xffd24a);
  constexpr int kSize = 16;
  constexpr int kMargin = 6;
  const auto centred = [&](const std::string& text) {
    return (grey.width() - canvas.text_width(kSize, text)) / 2;
  };
  const int middle = grey.height() / 2 + kSize / 3;
  canvas.text(kMargin, kMargin + kSize, kSize, name, colour);
  canvas.text(kMargin, middle, kSize, labels.left, colour);
  canvas.text(grey.width() - kMargin - canvas.text_width(kSize, labels.right), middle, kSize,
              labels.right, colour);
  canvas.text(centred(labels.top), kMargin + kSize, kSize, labels.top, colour);
  canvas.text(centred(labels.bottom), grey.height() - kMargin, kSize, labels.bottom, colour);
  return canvas.picture();
}

}  // namespace

Result<void> run_slices(const SlicesOptions& options, Console& console) {
  const auto mode = slab_mode(options.slab);
  if (!mode) return mode.error();
  if (!(options.width_hu > 0 && options.width_hu <= 1e6)) {
    return Error{ErrorCode::kUsage, "--window-width: expected more than 0 to 10^6 HU, found " +
                                        std::to_string(options.width_hu)};
  }
  if (!(options.level_hu >= -1e6 && options.level_hu <= 1e6)) {
    return Error{ErrorCode::kUsage, "--window-level: expected -10^6 to 10^6 HU, found " +
                                        std::to_string(options.level_hu)};
  }
  constexpr int kLeastPx = 64;  // The letters need room.
  if (options.size_px < kLeastPx || options.size_px > 8192) {
    return Error{ErrorCode::kUsage,
                 "--size: expected 64 to 8192 pixels, found " + std::to_string(options.size_px)};
  }
  io::CtOptions reading;
  reading.accept_unknown_orientation = options.accept_unknown_orientation;
  const auto ct = io::read_ct(options.ct, console, reading);
  if (!ct) return ct.error();
  auto out = OutputFolder::create(options.out);
  if (!out) return out.error();
  const Point<frames::Ct> at =
      options.at_ct ? Point<frames::Ct>{*options.at_ct} : ct->grid().centre();
  render::SliceOptions slice;
  slice.width = slice.height = options.size_px;
  slice.mm_per_pixel = options.mm_per_pixel > 0
                           ? options.mm_per_pixel
                           : ct->grid().extent_mm().maxCoeff() / options.size_px;
  slice.slab_mm = options.slab_mm;
  slice.slab = *mode;
  for (const auto& [name, plane] : {std::pair("axial", render::axial_slice(at)),
                                    {"coronal", render::coronal_slice(at)},
                                    {"sagittal", render::sagittal_slice(at)}}) {
    const auto values = render::slice_values(*ct, plane, slice);
    if (!values) return values.error();
    const auto grey = render::to_grey(*values, {options.level_hu, options.width_hu});
    const auto ok = out->write_picture(std::string(name) + ".png",
                                       labelled(grey, name, render::labels_of(plane)));
    if (!ok) return ok;
  }
  std::ostringstream where;
  where << "slices through (" << at.mm.transpose() << ") mm in " << options.out.string();
  console.say(where.str());
  return {};
}

}  // namespace nav::app
