// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/registration/bootstrap_curve.hpp"

#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

#include "bench/measure.hpp"
#include "bench/registration/thread_time.hpp"
#include "bench/registration/trials.hpp"
#include "nav/check.hpp"
#include "nav/index.hpp"
#include "registration/pose_solver.hpp"
#include "registration/similarity/ct_structure.hpp"
#include "registration/uncertainty/sandwich.hpp"

namespace nav::bench {
namespace {

using registration::BootstrapOptions;
using registration::CtChannels;
using registration::image_bootstrap;
using registration::ImageBootstrap;
using registration::ImageDraws;
using registration::ImageRegistrationOptions;
using registration::LocalShape;
using registration::Patch;
using registration::PatchSet;
using registration::PreparedSweep;
using registration::SimilarityCost;
using registration::Vector6d;

constexpr double kStartMm = 5;
constexpr int kSeeds = 8;  // Number of seeds for each number of replicates.

/// A sweep at the pose that a registration found, with the patches of its last solve.
class Solved {
 public:
  Solved(std::shared_ptr<const Patient> patient, std::shared_ptr<const RecordedSweep> recorded,
         std::shared_ptr<const ReadyCt> ct, const ImageRegistrationOptions& options)
      : patient_(std::move(patient)),
        recorded_(std::move(recorded)),
        ct_(std::move(ct)),
        options_(options),
        sweep_(prepared()),
        pose_(found()),
        patches_(with_ct_structure(channels(), sweep_.levels().back().patches, pose_,
                                   options.min_ct_contrast_hu, nullptr)),
        cost_(SimilarityCost(channels(), patches_, options.ridge, 1).robust(options.loss)) {
    refine();
  }

  [[nodiscard]] LocalShape shape() const {
    return local_shape(cost_, pose_, pose_ * sweep_.points().centroid,
                       registration::kCurvatureSteps * options_.levels.back().sample_step_mm);
  }
  [[nodiscard]] const PatchSet& patches() const { return patches_; }
  [[nodiscard]] const SimilarityCost& cost() const { return cost_; }
  [[nodiscard]] const registration::Pose& pose() const { return pose_; }

  /// Distance that a twist about a point moves the targets, RMS, mm.
  [[nodiscard]] double moved_mm(const Vector6d& twist, const Eigen::Vector3d& centre) const {
    return target_error_mm(registration::moved(pose_, centre, twist), pose_, targets());
  }
  /// Pose found from images weighted by their counts, starting at the pose of all.
  [[nodiscard]] registration::Pose solve(const std::map<int, int>& counts) const {
    PatchSet drawn = subset(patches_, [&](const Patch& p) { return counts.at(p.frame) > 0; });
    double sum = 0;
    for (Patch& p : drawn.patches) sum += p.weight *= counts.at(p.frame);
    for (Patch& p : drawn.patches) p.weight /= sum;
    const SimilarityCost cost = cost_.on(drawn);
    return solve_pose(cost, pose_, sweep_.points().centroid, {options_.max_iterations, kTolerance},
                      {})
        .pose;
  }
  [[nodiscard]] double error_mm() const {
    return target_error_mm(pose_, patient_->truth, recorded_->targets);
  }
  [[nodiscard]] double predicted_mm(const registration::PoseUncertainty& uncertainty) const {
    double sum = 0;
    for (const auto& target : targets()) {
      sum += std::pow(uncertainty.tre_rms_mm(target), 2) / static_cast<double>(targets().size());
    }
    return std::sqrt(sum);
  }
  [[nodiscard]] const std::vector<Point<frames::Ct>>& targets() const { return recorded_->targets; }

 private:
  static constexpr double kTolerance = 1e-6;

  [[nodiscard]] const CtChannels& channels() const { return *ct_->prepared.levels().back(); }
  [[nodiscard]] PreparedSweep prepared() const {
    CollectingDiagnostics diagnostics;
    auto made = PreparedSweep::create(recorded_->sweep, options_, diagnostics);
    NAV_CHECK(made.has_value(), patient_->seed);
    return std::move(*made);
  }
  [[nodiscard]] registration::Pose found() const {
    const CtPose start = start_at(kStartMm, patient_->truth, *recorded_, patient_->seed);
    const auto result = register_prepared(ct_->prepared, sweep_, start, options_);
    NAV_CHECK(result.has_value(), patient_->seed);
    return result->ct_from_reference;
  }
  /// Solves to the minimum of the remaining patches, which replicates are compared with.
  void refine() {
    pose_ = solve_pose(cost_, pose_, sweep_.points().centroid,
                       {options_.max_iterations, kTolerance}, {})
                .pose;
  }

  std::shared_ptr<const Patient> patient_;
  std::shared_ptr<const RecordedSweep> recorded_;
  std::shared_ptr<const ReadyCt> ct_;
  ImageRegistrationOptions options_;
  PreparedSweep sweep_;
  registration::Pose pose_;
  PatchSet patches_;
  SimilarityCost cost_;
};

/// The difference of two poses as a twist about a point.
Vector6d twist_between(const registration::Pose& from, const registration::Pose& to,
                       const Eigen::Vector3d& centre) {
  const Eigen::AngleAxisd turn(to.rotation() * from.rotation().inverse());
  Vector6d twist;
  twist.head<3>() = turn.angle() * turn.axis();
  const Eigen::Vector3d at = from.rotation().inverse() * (centre - from.translation_mm());
  twist.tail<3>() = to.rotation() * at + to.translation_mm() - centre;
  return twist;
}

/// Target error predicted by a bootstrap of a sweep, RMS over the targets.
double predicted_by(const Solved& solved, const LocalShape& shape, int replicates,
                    std::uint64_t seed) {
  BootstrapOptions options;
  options.replicates = replicates;
  options.seed = seed;
  return solved.predicted_mm(image_bootstrap(shape, options).uncertainty());
}

/// Adds error and time of each number of replicates on one sweep to the lists.
void add_points(const Solved& solved, const LocalShape& shape, const std::vector<int>& replicates,
                std::vector<std::vector<double>>& squares,
                std::vector<std::vector<double>>& cpu_us) {
  const double most = predicted_by(solved, shape, kBootstrapMost, kSeeds + 1);
  for (std::size_t i = 0; i < replicates.size(); ++i) {
    for (int seed = 1; seed <= kSeeds; ++seed) {
      BootstrapOptions options;
      options.replicates = replicates[i];
      options.seed = static_cast<std::uint64_t>(seed);
      cpu_us[i].push_back(1e6 * timed([&] { image_bootstrap(shape, options); }));
      const double one = predicted_by(solved, shape, replicates[i], options.seed);
      squares[i].push_back(std::pow(one / most - 1, 2));
    }
  }
}

BootstrapReference compare(const Solved& solved, const LocalShape& shape, int replicates) {
  BootstrapOptions options;
  options.replicates = replicates;
  const ImageBootstrap steps = image_bootstrap(shape, options);
  NAV_CHECK(steps.valid && steps.unsolved == 0, steps.fault);
  std::vector<double> way_mm;
  for (std::size_t i = 1; i < shape.images.size(); ++i) way_mm.push_back(shape.images[i].way_mm);
  const ImageDraws draws(way_mm, options);
  const Eigen::Vector3d centre = shape.centre_ct.mm;
  BootstrapReference out{};
  out.images = steps.images;
  out.block = steps.block;
  out.error_mm = solved.error_mm();
  out.clusters_mm = solved.predicted_mm(
      sandwich_covariance(shape, solved.patches(), solved.pose(), 0).uncertainty);
  out.step_mm = solved.predicted_mm(steps.uncertainty());
  double solved2 = 0;
  double apart2 = 0;
  out.solved_cpu_s = timed([&] {
    for (int replicate = 0; replicate < replicates; ++replicate) {
      const std::vector<int> counts = draws.counts(replicate);
      std::map<int, int> of_frame;
      for (std::size_t i = 0; i < counts.size(); ++i) {
        of_frame[shape.images[i].frame] = counts[i];
      }
      const Vector6d full = twist_between(solved.pose(), solved.solve(of_frame), centre);
      solved2 += std::pow(solved.moved_mm(full, centre), 2);
      apart2 += std::pow(solved.moved_mm(full - steps.twists[as_size(replicate)], centre), 2);
    }
  });
  out.solved_mm = std::sqrt(solved2 / replicates);
  out.apart = std::sqrt(apart2 / solved2);
  return out;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double one : values) sum += one;
  return sum / static_cast<double>(values.size());
}

}  // namespace

BootstrapCurve measure_bootstrap(const BootstrapCurveOptions& options, CaseStore& store,
                                 const std::function<void(double)>& progress) {
  const ImageRegistrationOptions settings = default_cohort().local;
  const int frames = default_cohort().frames;
  std::vector<std::vector<double>> squares(options.replicates.size()), cpu_us(squares.size());
  BootstrapCurve curve;
  for (int patient = 0; patient < options.patients; ++patient) {
    const std::uint64_t seed = options.first_seed + static_cast<std::uint64_t>(patient);
    for (std::size_t path = 0; path < options.paths.size(); ++path) {
      const Solved solved(store.patient(seed), store.sweep(seed, options.paths[path], frames),
                          store.ready_ct(seed, settings), settings);
      const LocalShape shape = solved.shape();
      add_points(solved, shape, options.replicates, squares, cpu_us);
      curve.references.push_back(compare(solved, shape, options.solved));
      curve.references.back().patient = seed;
      curve.references.back().path = options.paths[path];
      if (progress) {
        progress(
            (patient + static_cast<double>(path + 1) / static_cast<double>(options.paths.size())) /
            options.patients);
      }
    }
  }
  for (std::size_t i = 0; i < squares.size(); ++i) {
    curve.points.push_back(
        {options.replicates[i], median(cpu_us[i]), std::sqrt(mean_of(squares[i]))});
  }
  return curve;
}

std::string to_text(const BootstrapCurve& curve) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(3)
       << "\nresampled images: difference of the predicted error from that of " << kBootstrapMost
       << " replicates\n";
  for (const BootstrapPoint& p : curve.points) {
    text << "  " << std::setw(5) << p.replicates << " replicates: " << std::setprecision(0)
         << p.cpu_us << " us of one processor, difference " << std::setprecision(1) << 100 * p.off
         << " %\n"
         << std::setprecision(3);
  }
  text << "one step compared with full solves of the same samples, RMS at the targets, no floor:\n";
  for (const BootstrapReference& r : curve.references) {
    text << "  " << r.patient << ' ' << std::setw(9) << std::left << to_string(r.path) << std::right
         << ": " << r.images << " images in blocks of " << r.block << ", steps " << r.step_mm
         << " mm, solves " << r.solved_mm << " mm (" << r.solved_cpu_s << " s), difference "
         << r.apart << "; clusters " << r.clusters_mm << " mm, actual error " << r.error_mm
         << " mm\n";
  }
  return text.str();
}

}  // namespace nav::bench
