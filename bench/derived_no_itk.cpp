// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/derived_itk.hpp"

namespace nav::bench {

struct ItkPeer::Image {};
ItkPeer::ItkPeer(const ItkVoxels&, int) {}
ItkPeer::~ItkPeer() = default;
bool ItkPeer::built() { return false; }
void ItkPeer::signal_to_noise() {}
void ItkPeer::vesselness(const ItkTubes&) {}
void ItkPeer::gradient_magnitude(double) {}

}  // namespace nav::bench
