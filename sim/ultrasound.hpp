// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "nav/ultrasound_image.hpp"
#include "sim/anatomy/abdomen_phantom.hpp"
#include "sim/motion/warp.hpp"
#include "sim/needle_shaft.hpp"
#include "sim/probe_model.hpp"

namespace nav::sim {

/// Envelope signal: scan lines x samples, one line after another.
struct ScanLineImage {
  int lines = 0;
  int samples = 0;
  double sample_mm = 0;  ///< Distance between samples; sample 0 is at the face.
  std::vector<float> amplitude;
  [[nodiscard]] float at(int line, int sample) const {
    return amplitude[static_cast<std::size_t>(line) * static_cast<std::size_t>(samples) +
                     static_cast<std::size_t>(sample)];
  }
};

/// Simulates B-mode images of a patient: attenuation per tissue with an imperfect depth gain,
/// echoes of interfaces (impedance step times incidence), fully developed speckle that is fixed in
/// the tissue, beam and slice width, shadows of bone and gas, log compression, scan conversion. The
/// bytes do not depend on the number of threads. simulate() is thread-safe.
class UltrasoundSimulator {
 public:
  /// Preconditions: \p patient is not null; validate(probe); otherwise a Bug.
  UltrasoundSimulator(std::shared_ptr<const Anatomy> patient, const ProbeModel& probe,
                      std::uint64_t seed);
  UltrasoundSimulator(const AbdomenPhantom& phantom, const ProbeModel& probe, std::uint64_t seed);
  ~UltrasoundSimulator();
  UltrasoundSimulator(UltrasoundSimulator&&) noexcept;
  UltrasoundSimulator& operator=(UltrasoundSimulator&&) noexcept;

  /// Simulates one image. received is set to acquired; sequence also seeds the electronic noise.
  /// \p needle: a straight or bent needle, if one is visible.
  /// \p warp: motion of the tissue and its speckle; nullptr: at rest.
  [[nodiscard]] UltrasoundImage simulate(const Transform<frames::Ct, frames::Image>& ct_from_image,
                                         Timestamp acquired, std::uint64_t sequence,
                                         const NeedleShaft& needle = {},
                                         const Warp* warp = nullptr) const;
  /// Envelope after depth gain and noise, before log compression; 1 is white.
  [[nodiscard]] ScanLineImage envelope(const Transform<frames::Ct, frames::Image>& ct_from_image,
                                       std::uint64_t sequence, const NeedleShaft& needle = {},
                                       const Warp* warp = nullptr) const;

  [[nodiscard]] const ProbeModel& probe() const;
  [[nodiscard]] PixelGrid grid() const;
  /// Absent for a linear probe.
  [[nodiscard]] std::optional<SectorOutline> outline() const;

 private:
  struct Tables;
  std::unique_ptr<const Tables> tables_;
};

}  // namespace nav::sim
