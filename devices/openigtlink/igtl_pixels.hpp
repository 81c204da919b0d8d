// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "devices/openigtlink/igtl_image.hpp"
#include "nav/grey_scale.hpp"
#include "nav/ultrasound_image.hpp"

namespace nav::devices {

/// Sets the pixels of an ultrasound image, and its colours, to those of a message: one whole slice
/// of grey (1 component), RGB (3) or RGBA (4, whose opacity is not used), of 8 bits or of 16 bits
/// from 0, which become 8 bits by \p scale. Rejects all else with kUnsupportedData.
Result<void> set_pixels(UltrasoundImage& frame, const IgtlImage& image, GreyScale& scale);

}  // namespace nav::devices
