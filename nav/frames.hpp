// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

/// Tags of the coordinate frames. docs/frames.md draws and defines them.
namespace nav::frames {

struct Ct {
  static constexpr std::string_view kName = "Ct";
};  ///< DICOM patient axes (LPS), mm.
struct Reference {
  static constexpr std::string_view kName = "Reference";
};  ///< Patient-fixed tracked body, mm.
struct Tracker {
  static constexpr std::string_view kName = "Tracker";
};  ///< Camera or field generator, mm.
struct Probe {
  static constexpr std::string_view kName = "Probe";
};  ///< Tracked body on the ultrasound probe, mm.
struct Needle {
  static constexpr std::string_view kName = "Needle";
};  ///< Tracked body on the needle: origin at the tip, +z from the hub towards the tip, mm.
struct Image {
  static constexpr std::string_view kName = "Image";
};  ///< Ultrasound plane: origin at the centre of the transducer face, +x lateral towards the probe
    ///< mark, +y into the depth, +z = x × y, mm.

}  // namespace nav::frames
