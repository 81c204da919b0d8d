// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iomanip>
#include <iostream>
#include <memory>

#include "registration/acceptance.hpp"
#include "registration/image_registration.hpp"
#include "registration/starts.hpp"
#include "sim/ct_scanner.hpp"
#include "sim/procedure.hpp"

/// registration_curve [patients] [starts]: run time against target error over the number of
/// patches, on simulated patients only. Seeded: the errors repeat, the times depend on the machine.
namespace nav::registration {
namespace {

constexpr int kFrames = 60;
constexpr double kStartMm = 10;
constexpr double kStartRad = 8 * M_PI / 180;
constexpr double kSuccessMm = 2;
constexpr double kTrackerMm = 0.15;
constexpr double kTrackerRad = 0.0015;
// Not those of the tests, nor those that the acceptance limits were chosen on.
constexpr std::uint64_t kFirstPatient = 101;

struct Patient {
  sim::Procedure procedure;
  Volume ct;
  Sweep sweep;
};

/// Tracker errors: uniform with the standard deviations above, evenly spread over the frames.
Sweep record(const sim::Procedure& procedure) {
  const sim::UltrasoundSimulator probe(procedure.phantom(), procedure.options().probe,
                                       procedure.options().seed);
  const auto errors = spread_twists(kFrames, std::sqrt(3.0) * kTrackerRad,
                                    std::sqrt(3.0) * kTrackerMm, procedure.options().seed);
  std::vector<TrackedFrame> frames;
  for (int i = 0; i < kFrames; ++i) {
    const Timestamp time = procedure.frame_time(i);
    const auto ct_from_image = procedure.ct_from_image(time);
    const auto exact = procedure.ct_from_reference().inverse() * ct_from_image;
    const Vector6d& error = errors[static_cast<std::size_t>(i)];
    const Transform<frames::Reference, frames::Image> measured(
        (exp_rotation(error.head<3>()) * exact.rotation()).normalized(),
        exact.translation_mm() + error.tail<3>());
    frames.push_back({probe.simulate(ct_from_image, time, static_cast<std::uint64_t>(i)), measured,
                      Duration{0}});
  }
  auto sweep = Sweep::create(std::move(frames), "simulated");
  return std::move(sweep).value();
}

std::unique_ptr<Patient> make_patient(std::uint64_t seed) {
  sim::ProcedureOptions options;
  options.seed = seed;
  options.sweep_frames = kFrames;
  sim::Procedure procedure(options);
  auto ct = sim::scan_ct(procedure.phantom());
  Sweep sweep = record(procedure);
  return std::make_unique<Patient>(
      Patient{std::move(procedure), std::move(ct).value(), std::move(sweep)});
}

double target_error_mm(const Patient& patient,
                       const Transform<frames::Ct, frames::Reference>& found) {
  const auto truth = patient.procedure.ct_from_reference();
  const auto targets = patient.procedure.phantom().targets();
  double sum = 0;
  for (const auto& target : targets) {
    sum += ((found * (truth.inverse() * target)).mm - target.mm).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(targets.size()));
}

struct Totals {
  int runs = 0, successes = 0, accepted = 0, false_accepts = 0;
  std::vector<double> errors_mm, seconds, ratios;
};

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

void run_patient(const Patient& patient, int starts, const ImageRegistrationOptions& options,
                 Totals& totals) {
  const auto truth = patient.procedure.ct_from_reference();
  const Eigen::Vector3d centre = (truth * patient.sweep.centroid()).mm;
  for (const Vector6d& direction : spread_twists(starts, 1, 1, patient.procedure.options().seed)) {
    Vector6d twist;
    twist.head<3>() = kStartRad * direction.head<3>().normalized();
    twist.tail<3>() = kStartMm * direction.tail<3>().normalized();
    CollectingDiagnostics diagnostics;
    const auto result = register_sweep(patient.ct, patient.sweep, moved(truth, centre, twist),
                                       options, diagnostics);
    ++totals.runs;
    if (!result) continue;
    const double error_mm = target_error_mm(patient, result->ct_from_reference);
    const auto target = patient.procedure.plan().target_ct;
    const bool accepted = decide(*result, {}, target).accepted;
    const bool success = error_mm < kSuccessMm;
    totals.successes += success ? 1 : 0;
    totals.accepted += accepted ? 1 : 0;
    totals.false_accepts += accepted && !success ? 1 : 0;
    totals.seconds.push_back(result->total_s);
    if (!success) continue;
    totals.errors_mm.push_back(error_mm);
    const auto found = result->ct_from_reference * (truth.inverse() * target);
    totals.ratios.push_back((found - target).v.norm() / result->tre_rms_mm(target));
  }
}

int run(int patients, int starts) {
  std::cout << "Simulated patients only; nothing here is clinical accuracy.\n"
            << patients << " patients from seed " << kFirstPatient << ", " << starts
            << " starts each at " << kStartMm << " mm / 8 degrees, " << kFrames
            << " pictures, tracker noise " << kTrackerMm << " mm / " << kTrackerRad
            << " rad, one thread, whole call with preparation.\n"
            << "share of patches | success < " << kSuccessMm
            << " mm | error mm median, p95 | error/predicted median | accepted, wrongly | s median"
            << '\n';
  std::vector<std::unique_ptr<Patient>> all;
  for (int i = 0; i < patients; ++i) {
    all.push_back(make_patient(kFirstPatient + static_cast<std::uint64_t>(i)));
  }
  std::cout << std::fixed << std::setprecision(3);
  for (const double share : {0.25, 0.5, 1.0, 2.0, 4.0}) {
    ImageRegistrationOptions options;
    options.threads = 1;
    for (LevelOptions& level : options.levels) {
      level.patches = std::max(50, static_cast<int>(std::lround(share * level.patches)));
    }
    Totals totals;
    for (const auto& patient : all) run_patient(*patient, starts, options, totals);
    std::cout << std::setw(16) << share << " | " << totals.successes << '/' << totals.runs << " | "
              << quantile(totals.errors_mm, 0.5) << ", " << quantile(totals.errors_mm, 0.95)
              << " | " << quantile(totals.ratios, 0.5) << " | " << totals.accepted << ", "
              << totals.false_accepts << " | " << quantile(totals.seconds, 0.5) << '\n'
              << std::flush;
  }
  return 0;
}

}  // namespace
}  // namespace nav::registration

int main(int argc, char** argv) {
  const int patients = argc > 1 ? std::atoi(argv[1]) : 4;
  const int starts = argc > 2 ? std::atoi(argv[2]) : 5;
  if (patients < 1 || starts < 1 || argc > 3) {
    std::cerr << "usage: registration_curve [patients >= 1] [starts >= 1]\n";
    return 2;
  }
  return nav::registration::run(patients, starts);
}
