// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "registration/search/global_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "nav/check.hpp"
#include "registration/search/starts.hpp"

namespace nav::registration {
namespace {

// Every third patch is enough to rank poses that are centimetres apart.
constexpr std::size_t kScreenStride = 3;
constexpr std::size_t kMinScreenPatches = 60;
// Enough random poses to know the mean and spread of their costs.
constexpr int kFirstStarts = 60;
constexpr double kClearDeviations = 7;
constexpr std::size_t kTriedStarts = 48;
constexpr std::size_t kSolvedStarts = 16;
// If a batch of starts ends in no result that is clearly right, other starts are tried.
constexpr std::uint64_t kBatches = 3;
constexpr std::uint64_t kBatchSeed = 1000;
constexpr int kScreenIterations = 10;
// Rounds around the best results so far: the box shrinks by the factor in each.
constexpr int kRounds = 3;
constexpr std::size_t kCentres = 4;
constexpr int kStartsPerCentre = 40;
constexpr std::size_t kSolvedPerRound = 8;
constexpr double kShrink = 0.4;
constexpr std::size_t kFinished = 4;
constexpr double kSameMm = 4;
// Poses all over the body are ranked by a few samples each of a few patches. Of these,
// kRankedPerTried times the poses to be tried are ranked again, by as few samples of all patches.
// More patches distinguish positions better than more samples of each patch, which are smooth.
constexpr int kPlaceStride = 3;
constexpr std::size_t kFirstPatches = 30;
constexpr std::size_t kRankedPerTried = 4;
constexpr std::size_t kSampledPlaces = 200;
// Steps of a trial, and the fraction of the tried positions that it starts from.
struct Trial {
  int iterations;
  double share;
};
constexpr std::array<Trial, 3> kTrials{{{2, 1.0}, {3, 0.3}, {kScreenIterations, 0.1}}};
// Found poses are refined on other levels: an accuracy of a few tenths of a millimetre is enough.
constexpr double kTolerance = 3e-4;
// Poses ranked or solved in parallel before the caller is asked whether to continue: about 10 ms.
constexpr std::size_t kRankedPerCheck = 600;
constexpr std::size_t kSolvedPerCheck = 48;

struct Ranked {
  double cost;
  Pose pose;
};

bool cheaper(const Ranked& a, const Ranked& b) { return a.cost < b.cost; }

class Search {
 public:
  Search(const SimilarityCost& cost, const SweepPoints& points, const SearchOptions& options,
         const std::function<bool()>& keep_going, int& non_finite)
      : cost_(cost),
        points_(points),
        options_(options),
        keep_going_(keep_going),
        non_finite_(non_finite),
        screen_patches_(screen_of(cost.patches())),
        screen_(cost.on(screen_patches_)),
        quick_patches_(quick_of(cost.patches())),
        quick_(cost.on(quick_patches_)) {}

  std::vector<Found> run(const Pose& initial) {
    found_.push_back({solve(cost_, initial, options_.max_iterations), true});
    if (options_.starts == 0 || stopped()) return std::move(found_);
    const auto twists =
        spread_twists(options_.starts, options_.range_rad, options_.range_mm, options_.seed);
    const auto first = std::min<std::size_t>(kFirstStarts, twists.size());
    rank({twists.begin(), twists.begin() + static_cast<std::ptrdiff_t>(first)}, initial, screen_);
    learn_limit();
    if (screen_.cost(found_[0].solution.pose).cost <= clear_) return std::move(found_);
    ranked_.clear();
    for (std::uint64_t batch = 0; batch < kBatches && !clear() && !stopped(); ++batch) {
      try_starts(initial, options_.seed + kBatchSeed * batch);
      search_about(options_.range_rad, options_.range_mm);
    }
    finish();
    return std::move(found_);
  }

  std::vector<Found> run_among(const Places& places) {
    if (places.poses.empty()) return {};
    rank_places(places);
    if (!stopped()) try_places(places.tried);
    // Twice the distance of neighbouring poses.
    search_about(places.spacing_mm / kRotationScaleMm / kShrink, places.spacing_mm / kShrink);
    finish();
    return std::move(found_);
  }

 private:
  static PatchSet every(std::size_t stride, const PatchSet& all) {
    std::size_t index = 0;
    return subset(all, [&](const Patch&) { return index++ % stride == 0; });
  }
  static PatchSet screen_of(const PatchSet& all) {
    return every(std::clamp<std::size_t>(all.patches.size() / kMinScreenPatches, 1, kScreenStride),
                 all);
  }

  static PatchSet quick_of(const PatchSet& all) {
    return all.side > 2 * kPlaceStride ? coarsened(all, kPlaceStride) : all;
  }

  bool stopped() {
    stopped_ = stopped_ || (keep_going_ && !keep_going_());
    return stopped_;
  }

  PoseSolution solve(const SimilarityCost& cost, const Pose& pose, int iterations) {
    PoseSolution solution =
        solve_pose(cost, pose, points_.centroid, {iterations, kTolerance}, keep_going_);
    non_finite_ = std::max(non_finite_, solution.non_finite);
    stopped_ = stopped_ || solution.cancelled;
    return solution;
  }

  void rank(const std::vector<Vector6d>& twists, const Pose& about, const SimilarityCost& screen) {
    const Eigen::Vector3d centre = (about * points_.centroid).mm;
    std::vector<Pose> poses;
    for (const Vector6d& twist : twists) poses.push_back(moved(about, centre, twist));
    rank(poses, screen);
  }

  /// Ranks poses in parallel: a single pose is too little work to be divided. Poses that were not
  /// reached in time are left out.
  void rank(const std::vector<Pose>& poses, const SimilarityCost& screen) {
    const std::size_t first = ranked_.size();
    for (const Pose& pose : poses) ranked_.push_back({0, pose});
    const std::size_t done = side_by_side(poses.size(), kRankedPerCheck, [&](std::size_t i) {
      const CostTerms terms = screen.cost(poses[i]);
      ranked_[first + i].cost = terms.cost;
      return terms.non_finite;
    });
    ranked_.erase(ranked_.begin() + static_cast<std::ptrdiff_t>(first + done), ranked_.end());
  }

  /// Calls work(i), which returns a number of non-finite patches, for all i below count. Asks the
  /// caller every per_check calls, on the calling thread, and stops if told to. Returns how many
  /// calls were made.
  template <class Work>
  std::size_t side_by_side(std::size_t count, std::size_t per_check, const Work& work) {
    std::vector<int> non_finite(count, 0);
    tbb::task_arena arena(options_.threads);
    std::size_t done = 0;
    while (done < count && (done == 0 || !stopped())) {
      const std::size_t end = std::min(count, done + per_check);
      arena.execute(
          [&] { tbb::parallel_for(done, end, [&](std::size_t i) { non_finite[i] = work(i); }); });
      done = end;
    }
    for (const int one : non_finite) non_finite_ = std::max(non_finite_, one);
    return done;
  }

  /// Computes the cost below which a result is not chance.
  void learn_limit() {
    const auto n = static_cast<double>(ranked_.size());
    double mean = 0;
    for (const Ranked& one : ranked_) mean += one.cost / n;
    double variance = 0;
    for (const Ranked& one : ranked_)
      variance += std::pow(one.cost - mean, 2) / std::max(n - 1, 1.0);
    clear_ = mean - kClearDeviations * std::sqrt(variance);
  }

  [[nodiscard]] bool clear() const { return !solved_.empty() && solved_.front().cost <= clear_; }

  /// Tries a batch of starts about a pose: the cheapest are tried, and the best of these solved.
  void try_starts(const Pose& initial, std::uint64_t seed) {
    rank(spread_twists(options_.starts, options_.range_rad, options_.range_mm, seed), initial,
         quick_);
    keep_cheapest(ranked_, kTriedStarts);
    ranked_ = solve_all(ranked_, kTrials.front().iterations);
    solve_best(kSolvedStarts);
  }

  /// Solves the cheapest ranked starts and clears the list.
  void solve_best(std::size_t count) {
    std::stable_sort(ranked_.begin(), ranked_.end(), cheaper);
    for (std::size_t i = 0; i < std::min(count, ranked_.size()) && !stopped(); ++i) {
      const PoseSolution solution = solve(screen_, ranked_[i].pose, kScreenIterations);
      solved_.push_back({solution.final_cost, solution.pose});
    }
    ranked_.clear();
    drop_duplicates();
  }

  /// Keeps the cheapest of many poses, using more patches in each pass.
  void rank_places(const Places& places) {
    std::vector<Pose> poses;
    const std::size_t stride = std::max<std::size_t>(1, places.poses.size() / kSampledPlaces);
    for (std::size_t i = 0; i < places.poses.size(); i += stride) poses.push_back(places.poses[i]);
    rank(poses, screen_);
    learn_limit();
    ranked_.clear();
    const PatchSet few = every(
        std::max<std::size_t>(1, quick_patches_.patches.size() / kFirstPatches), quick_patches_);
    rank(places.poses, cost_.on(few));
    keep_cheapest(ranked_, kRankedPerTried * places.tried);
    poses.clear();
    for (const Ranked& one : ranked_) poses.push_back(one.pose);
    ranked_.clear();
    rank(poses, quick_);
    keep_cheapest(ranked_, places.tried);
  }

  static void keep_cheapest(std::vector<Ranked>& ranked, std::size_t count) {
    std::stable_sort(ranked.begin(), ranked.end(), cheaper);
    if (ranked.size() > count) ranked.resize(count, ranked.front());
  }

  /// Makes a few steps from all ranked poses, more from the best of these, and a full trial from
  /// the best of those.
  void try_places(std::size_t tried) {
    solved_ = std::move(ranked_);
    ranked_.clear();
    for (const Trial& trial : kTrials) {
      if (stopped()) return;
      const auto count = static_cast<std::size_t>(trial.share * static_cast<double>(tried));
      keep_cheapest(solved_, std::max<std::size_t>(count, 1));
      solved_ = solve_all(solved_, trial.iterations);
      drop_duplicates();
    }
  }

  /// Starts that were not reached in time stay unchanged.
  std::vector<Ranked> solve_all(const std::vector<Ranked>& starts, int iterations) {
    std::vector<Ranked> out = starts;
    side_by_side(starts.size(), kSolvedPerCheck, [&](std::size_t i) {
      const PoseSolution solution =
          solve_pose(screen_, starts[i].pose, points_.centroid, {iterations, kTolerance}, {});
      out[i] = {solution.final_cost, solution.pose};
      return solution.non_finite;
    });
    return out;
  }

  void drop_duplicates() {
    std::stable_sort(solved_.begin(), solved_.end(), cheaper);
    std::vector<Ranked> kept;
    for (const Ranked& one : solved_) {
      const bool known = std::any_of(kept.begin(), kept.end(), [&](const Ranked& k) {
        return distance_mm(points_, k.pose, one.pose) < kSameMm;
      });
      if (!known) kept.push_back(one);
    }
    solved_ = std::move(kept);
  }

  /// Rounds in shrinking boxes about the best results.
  void search_about(double range_rad, double range_mm) {
    double shrink = kShrink;
    for (int round = 0; round < kRounds && !clear() && !stopped(); ++round, shrink *= kShrink) {
      search_about_best(shrink * range_rad, shrink * range_mm, static_cast<std::uint64_t>(round));
    }
  }

  void search_about_best(double range_rad, double range_mm, std::uint64_t round) {
    const std::vector<Ranked> centres(
        solved_.begin(),
        solved_.begin() + static_cast<std::ptrdiff_t>(std::min(kCentres, solved_.size())));
    std::uint64_t seed = options_.seed + 17 * (round + 1);
    for (const Ranked& centre : centres) {
      rank(spread_twists(kStartsPerCentre, range_rad, range_mm, ++seed), centre.pose, quick_);
    }
    solve_best(kSolvedPerRound);
  }

  /// Solves the best results on all patches.
  void finish() {
    for (std::size_t i = 0; i < std::min(kFinished, solved_.size()) && !stopped(); ++i) {
      found_.push_back({solve(cost_, solved_[i].pose, options_.max_iterations), false});
    }
    std::stable_sort(found_.begin(), found_.end(), [](const Found& a, const Found& b) {
      return a.solution.final_cost < b.solution.final_cost;
    });
  }

  const SimilarityCost& cost_;
  const SweepPoints& points_;
  const SearchOptions& options_;
  const std::function<bool()>& keep_going_;
  int& non_finite_;
  PatchSet screen_patches_;
  SimilarityCost screen_;
  PatchSet quick_patches_;  // All patches, with few samples each.
  SimilarityCost quick_;
  std::vector<Ranked> ranked_, solved_;
  std::vector<Found> found_;
  double clear_ = 0;
  bool stopped_ = false;
};

}  // namespace

std::vector<Found> search(const SimilarityCost& cost, const Pose& initial,
                          const SweepPoints& points, const SearchOptions& options,
                          const std::function<bool()>& keep_going, int& non_finite) {
  return Search(cost, points, options, keep_going, non_finite).run(initial);
}

std::vector<Found> search_among(const SimilarityCost& cost, const Places& places,
                                const SweepPoints& points, const SearchOptions& options,
                                const std::function<bool()>& keep_going, int& non_finite) {
  NAV_CHECK(places.spacing_mm > 0 && places.tried >= 1, places.spacing_mm, places.tried);
  return Search(cost, points, options, keep_going, non_finite).run_among(places);
}

}  // namespace nav::registration
