// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <sstream>

#include "render/features/digest.hpp"
#include "render/features/service.hpp"

namespace nav::render::features {
namespace {

/// Increased with every change of a feature's values, so that older values are not found any more.
constexpr double kDefinitionVersion = 5;

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

void add(const DerivedOptions& options, Digest& digest) {
  digest.add(static_cast<double>(options.index()));
  const auto add_all = [&digest](std::initializer_list<double> numbers) {
    for (const double number : numbers) digest.add(number);
  };
  std::visit(
      Overloaded{
          [&](const SnrOptions& o) {
            add_all(
                {static_cast<double>(o.window_voxels), static_cast<double>(o.weights), o.black});
          },
          [&](const VesselnessOptions& o) {
            add_all({static_cast<double>(o.polarity), o.smallest_radius_mm, o.largest_radius_mm,
                     static_cast<double>(o.scales), o.alpha, o.beta, o.contrast, o.truncate,
                     o.negligible_response});
          },
          [&](const ConfidenceOptions& o) {
            add_all({o.alpha, o.beta, o.gamma, o.solve.error,
                     static_cast<double>(o.solve.max_iterations)});
          },
          [&](const GradientPartOptions& o) {
            add_all({static_cast<double>(o.part), o.gradient.smoothing_mm, o.gradient.truncate});
            if (o.part == GradientPart::kAngle) digest.add(o.gradient.least_per_mm);
          },
          [&](const ScanDepthOptions&) {},
      },
      options);
}

/// Converts a result, without the data that it only carries along.
template <class T, class Take>
Result<DerivedVolume> taken(Result<T> result, const Take& take) {
  if (!result) return result.error();
  return take(*result);
}

}  // namespace

bool needs_scan_lines(const DerivedOptions& options) {
  const auto* gradient = std::get_if<GradientPartOptions>(&options);
  return (gradient != nullptr && gradient->part != GradientPart::kMagnitude) ||
         std::holds_alternative<ConfidenceOptions>(options) ||
         std::holds_alternative<ScanDepthOptions>(options);
}

Result<void> validate(const DerivedRequest& request) {
  const VoxelGrid& grid = request.volume.grid();
  const std::string& name = request.volume.name();
  const auto ok =
      std::visit(Overloaded{
                     [&](const GradientPartOptions& o) { return validate(o.gradient, grid, name); },
                     [&](const VesselnessOptions& o) { return validate(o, grid, name); },
                     [](const ScanDepthOptions&) { return Result<void>(); },
                     [](const auto& o) { return validate(o); },
                 },
                 request.options);
  if (!ok || !needs_scan_lines(request.options)) return ok;
  if (!request.lines) {
    return Error{
        ErrorCode::kUsage,
        request.volume.name() +
            ": confidence, depth and gradients along or across scan lines require scan-line "
            "directions (one direction, the apex of a fan or a sweep), found none"};
  }
  return request.lines->check(request.volume.grid(), request.volume.name());
}

std::string key_of(const DerivedRequest& request) {
  Digest digest;
  digest.add(kDefinitionVersion);
  digest.add(request.volume.digest());
  add(request.options, digest);
  if (needs_scan_lines(request.options) && request.lines) digest.add(request.lines->digest());
  return digest.hex();
}

Result<DerivedVolume> compute(const DerivedRequest& request, const RunOptions& run) {
  if (const auto ok = validate(request); !ok) return ok.error();
  const auto plain = [](const FeatureVolume& v) { return DerivedVolume{v, ""}; };
  const ScalarVolume& volume = request.volume;
  return std::visit(
      Overloaded{
          [&](const SnrOptions& o) { return taken(signal_to_noise(volume, o, run), plain); },
          [&](const VesselnessOptions& o) { return taken(vesselness(volume, o, run), plain); },
          [&](const ConfidenceOptions& o) {
            return taken(confidence(volume, *request.lines, o, run), [](const Confidence& c) {
              std::ostringstream note;
              note << c.report.iterations << " iterations, ";
              if (std::isnan(c.report.estimated_error)) {
                note << "error unknown because gamma is too small";
              } else {
                note << "estimated error " << c.report.estimated_error << " rms";
              }
              note << ", relative residual " << c.report.relative_residual;
              return DerivedVolume{c.volume, note.str()};
            });
          },
          [&](const GradientPartOptions& o) {
            const ScanLines* lines = request.lines ? &*request.lines : nullptr;
            return taken(gradient_part(volume, o.part, lines, o.gradient, run), plain);
          },
          [&](const ScanDepthOptions&) {
            return taken(scan_depth(volume.grid(), *request.lines, run), plain);
          },
      },
      request.options);
}

}  // namespace nav::render::features
