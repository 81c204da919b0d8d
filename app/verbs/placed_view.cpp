// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/placed_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <utility>

#include "app/engines.hpp"
#include "app/predicates/predicate_volume.hpp"
#include "app/report.hpp"
#include "app/views/ct_window.hpp"
#include "app/views/plane_visibility.hpp"
#include "render/predicates/predicate_sampler.hpp"
#include "render/two_volumes.hpp"
#include "session/outside_ct.hpp"

namespace nav::app {
namespace {

std::string banner_of(const session::Placement& placement, const std::string& kind, bool follows) {
  // The 3D view says NOT REGISTERED.
  if (placement.kind != "registered") return kind;
  return follows ? kind + ", CT follows the tissue" : kind;
}

/// Sets what the 3D view shows by predicates. A centre outside of the CT is most likely a volume in
/// another frame.
Result<std::shared_ptr<const PredicateSource>> prepare_view(const SessionConfig& config,
                                                            const Volume& ct,
                                                            std::optional<PredicateView>& view,
                                                            Console& console) {
  PredicateOptions options = config.predicates;
  // Drawn with the plan.
  if (!options.target && config.plan) {
    const auto& target_mm = config.plan->target_ct.mm;
    options.target =
        Eigen::Vector4d(target_mm.x(), target_mm.y(), target_mm.z(), config.plan->target_radius_mm);
  }
  auto made = prepare_predicates(
      options, config.output.threads, console,
      config.source.needle_frame.empty() ? DistancesFrom::kNoNeedle : DistancesFrom::kLiveNeedle);
  if (!made) return made.error();
  const auto& ultrasound = made->volume.ultrasound;
  if (session::mm_outside(ct, std::array{ultrasound->grid().centre()}) > 0) {
    console.report(Severity::kWarning, options.volume.string(),
                   "its centre lies outside of the CT: is it in the CT's frame?");
  }
  std::optional<render::SphereShape> target;
  if (config.predicates.target) target = target_sphere(*config.predicates.target);
  view = {.ultrasound = {ultrasound, std::move(made->volume.predicates), options.ct_importance},
          .alone = options.alone,
          .target = target};
  return made->source;
}

/// True if the 3D ultrasound of a scene shows anywhere in a small image.
Result<bool> shows_ultrasound(render::Scene scene) {
  constexpr int kWidth = 160;
  constexpr double kTransparentMm = 1e6;
  scene.height = std::max(16, kWidth * scene.height / scene.width);
  scene.width = kWidth;
  const auto engine = render::make_cpu_engine();
  const auto with = engine->render(scene);
  if (!with) return with.error();
  (scene.ultrasound ? scene.ultrasound->predicates : *scene.predicates).opacity_length_mm =
      kTransparentMm;
  const auto without = engine->render(scene);
  if (!without) return without.error();
  constexpr double kSeen = 1e-5;  // Less than one pixel by one of 255.
  return render::rms_difference(with->pixels, without->pixels) > kSeen;
}

}  // namespace

Result<PlacedView::Parts> PlacedView::prepare(const SessionConfig& config,
                                              const std::string& reference_frame,
                                              Console& console) {
  console.begin("reading the CT");
  const auto ct =
      session::read_session_ct(config.ct, console, draws_hounsfield_units(config.appearance));
  if (!ct) return ct.error();
  console.end(std::to_string((*ct)->grid().voxel_count()) + " voxels");
  return prepare(config, reference_frame, *ct, console);
}

Result<PlacedView::Parts> PlacedView::prepare(const SessionConfig& config,
                                              const std::string& reference_frame,
                                              std::shared_ptr<const Volume> shared_ct,
                                              Console& console) {
  // A fault of the placement itself is reported before any work.
  auto given = session::given_placement(config.placement, *shared_ct, reference_frame);
  if (!given) return given.error();
  auto engine = make_engine(config.output.engine, config.output.threads, console);
  if (!engine) return engine.error();
  auto appearance = resolve_appearance(config.appearance, *shared_ct);
  if (!appearance) return appearance.error();
  if (auto ok = save_appearance(config.appearance.save, *appearance); !ok) return ok.error();
  if (appearance->drawn) {
    for (const auto& statement : appearance->drawn->statements) console.say(statement);
  }
  warn_of_lost_components(appearance->transfer, console);
  if (!config.predicates.alone || config.predicates.volume.empty()) {
    warn_of_missing_presets(config.appearance, *shared_ct, console);
  }
  PresenterOptions options{.appearance = config.appearance,
                           .view = config.view,
                           .width = config.output.width,
                           .height = config.output.height,
                           .step_voxels = config.output.step_voxels,
                           .rms_error = config.output.rms_error,
                           .pixel_error = config.output.pixel_error,
                           .quality = config.quality,
                           .needle = config.source.needle_size};
  auto shapes = read_cutaway_objects(config.cutaway_objects, *shared_ct, console);
  if (!shapes) return shapes.error();
  options.cut_free = *std::move(shapes);
  if (config.plan) session::warn_outside(*config.plan, *shared_ct, console);
  std::shared_ptr<const PredicateSource> predicates;
  if (!config.predicates.volume.empty()) {
    auto source = prepare_view(config, *shared_ct, options.predicates, console);
    if (!source) return source.error();
    predicates = *std::move(source);
  }
  auto presenter =
      Presenter::create(std::move(options), *std::move(appearance), shared_ct, std::move(*engine));
  if (!presenter) return presenter.error();
  return Parts{.ct = std::move(shared_ct),
               .given = *std::move(given),
               .survey = std::nullopt,
               .presenter = *std::move(presenter),
               .needle_expected = config.source.has_needle(),
               .banner = "",
               .predicates = std::move(predicates)};
}

Result<PlacedView::Parts> PlacedView::prepare_alone(const SessionConfig& config,
                                                    PreparedPredicates prepared) {
  const auto volume = std::make_shared<const Volume>(*prepared.as_recorded);
  // The transfer function is not used: predicates classify the volume.
  SessionConfig::Appearance appearance;
  appearance.preset = "ct-soft-tissue";
  const PredicateOptions& options = config.predicates;
  std::optional<render::SphereShape> target;
  if (options.target) target = target_sphere(*options.target);
  auto presenter = Presenter::create(
      {.appearance = appearance,
       .view = config.view,
       .width = config.output.width,
       .height = config.output.height,
       .predicates = PredicateView{.ultrasound = {prepared.volume.ultrasound,
                                                  std::move(prepared.volume.predicates),
                                                  options.ct_importance},
                                   .alone = true,
                                   .target = target}},
      volume, render::make_cpu_engine());
  if (!presenter) return presenter.error();
  return Parts{.ct = volume,
               .given = std::nullopt,
               .survey = std::nullopt,
               .presenter = *std::move(presenter),
               .needle_expected = false,
               .banner = "",
               .predicates = std::move(prepared.source)};
}

PlacedView::PlacedView(const SessionConfig& config, Console& console, Parts parts)
    : config_(config),
      console_(console),
      ct_(std::move(parts.ct)),
      given_(std::move(parts.given)),
      survey_(std::move(parts.survey)),
      presenter_(std::move(parts.presenter)),
      plan_(config.plan),
      needle_expected_(parts.needle_expected),
      banner_(std::move(parts.banner)),
      predicates_(std::move(parts.predicates)) {}

std::optional<session::CtPlacement> PlacedView::show_before_images() {
  presenter_.set_facts({.plan = plan_,
                        .needle_expected = needle_expected_,
                        .window = ct_window(config_.view, *ct_, {}),
                        .banner = banner_,
                        .warning = given_ ? registration_warning(given_->warnings) : "",
                        .uncertainty = presenter_.facts().uncertainty});
  if (!given_) return std::nullopt;
  return given_->placement;
}

Result<std::optional<session::CtPlacement>> PlacedView::take(
    const TrackedImage& image, const std::optional<session::RecordingRead>& read) {
  std::optional<session::CtPlacement> changed;
  if (!placement_) {
    auto begun = begin(image, read);
    if (!begun) return begun.error();
    changed = *std::move(begun);
  }
  if (config_.placement.follow) {
    // The CT follows from the first image on that meets it.
    if (!follower_) {
      auto made = session::TissueFollower::create(ct_, placement_->placement, image,
                                                  config_.output.threads, console_);
      if (made) {
        follower_ = std::move(*made);
      } else if (made.error().code != ErrorCode::kRefused) {
        return made.error();
      }
    }
    if (follower_) changed = follower_->follow(image);
  }
  outside_.add(*ct_, placement_->placement, image);
  const std::string outside = outside_.warning();
  warn(outside.empty() ? registration_warning(placement_->warnings) : outside);
  return changed;
}

/// Decides everything that depends on where the images lie.
Result<session::CtPlacement> PlacedView::begin(const TrackedImage& image,
                                               const std::optional<session::RecordingRead>& read) {
  const auto first = session::survey_of(image);
  auto placement = session::place_sweep(config_.placement, given_, *ct_, first, read);
  if (!placement) return placement.error();
  const auto& ct_from_reference = placement->placement.ct_from_reference;
  const session::SweepSurvey& seen = survey_ ? *survey_ : first;
  SessionFacts facts{
      .plan = plan_,
      .needle_expected = needle_expected_,
      .focus_ct = ct_from_reference * seen.centroid,
      .window = ct_window(config_.view, *ct_, values_along(*ct_, ct_from_reference, seen.spread)),
      .banner = banner_of(*placement, banner_, config_.placement.follow),
      .warning = presenter_.facts().warning,
      .uncertainty = placement->uncertainty};
  if (const auto axes = session::mean_axes(seen)) {
    facts.typical_plane = SessionFacts::TypicalPlane{
        ct_from_reference * Transform<frames::Reference, frames::Image>(
                                Eigen::Quaterniond(*axes).normalized(), seen.centroid.mm),
        seen.image_extent_mm};
  }
  presenter_.set_facts(std::move(facts));
  report_placement(*placement, console_);
  placement_ = std::move(*placement);
  return placement_->placement;
}

void PlacedView::set_plan(const std::optional<NeedlePlan>& plan) {
  plan_ = plan;
  SessionFacts facts = presenter_.facts();
  facts.plan = plan;
  presenter_.set_facts(std::move(facts));
}

void PlacedView::warn(std::string warning) {
  SessionFacts facts = presenter_.facts();
  facts.warning = std::move(warning);
  presenter_.set_facts(std::move(facts));
}

void PlacedView::set_placement(session::Placement placement) {
  given_ = placement;
  // Images that were taken keep what they decided for the view.
  if (placement_) placement_ = std::move(placement);
  warn(registration_warning(given_->warnings));
}

Result<void> PlacedView::check_ultrasound(const session::Epoch& epoch) {
  if (ultrasound_checked_ || config_.predicates.volume.empty()) return {};
  ultrasound_checked_ = true;
  const render::Scene scene = presenter_.scene(epoch);
  if (auto ok = check_importance(scene); !ok) return ok;
  const auto shows = shows_ultrasound(scene);
  if (!shows) return shows.error();
  if (*shows) return {};
  console_.report(Severity::kWarning, config_.predicates.volume.string(),
                  "nothing of it shows in the first image: no sample in view satisfies a "
                  "predicate of importance above 0, the CT is more important "
                  "(--ct-importance), or the cutaway takes it away (--no-cutaway, "
                  "cutaway_importance of the predicate set)");
  return {};
}

Result<void> PlacedView::check_plane(const session::Epoch& epoch) {
  if (plane_checked_ || !presenter_.appearance().cutaway) return {};
  const render::Scene scene = presenter_.scene(epoch);
  if (!scene.plane || scene.plane->safety.state > SafetyState::kDegraded) return {};
  plane_checked_ = true;
  const auto found = plane_visibility(scene);
  if (!found) return found.error();
  const std::string words = hidden_plane_words(*found);
  if (!words.empty()) console_.report(Severity::kWarning, "appearance", words);
  return {};
}

Result<void> PlacedView::check_importance(const render::Scene& scene) {
  if (!scene.cutaway) return {};
  const render::Scene alone = scene.ultrasound ? render::ultrasound_scene(scene) : scene;
  const auto set =
      render::PredicateSet::create(*alone.predicates, alone.ct, render::position_of(alone));
  if (!set) return set.error();
  const auto shared = render::shared_importance(*set);
  constexpr double kWorthSaying = 0.02;
  if (shared.share < kWorthSaying) return {};
  std::ostringstream text;
  text.precision(2);
  text << "'" << alone.predicates->model.entries[shared.entry].name
       << "', its most important predicate, is true together with others in "
       << std::lround(100 * shared.share)
       << " % of the voxels where it is true: there it counts for " << shared.importance
       << " of what it counts alone, and a cutaway takes it away; 'not' this entry in the others "
          "keeps it";
  console_.report(Severity::kWarning, config_.predicates.volume.string(), text.str());
  return {};
}

void PlacedView::say_note() {
  if (presenter_.note() == note_) return;
  note_ = presenter_.note();
  if (!note_.empty()) console_.report(Severity::kWarning, "render", note_);
}

}  // namespace nav::app
