// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "app/window/feed.hpp"

namespace nav::app {
namespace {

/// The camera of 'sonde predicates'.
render::Camera camera_of_volume(const PreparedPredicates& prepared, const SessionConfig& config) {
  constexpr int kAnySize = 600;
  const render::PredicateVolume& volume = prepared.volume;
  render::Camera camera =
      render::predicate_scene(volume, volume.predicates.model, kAnySize, kAnySize).camera;
  const Eigen::Vector3d look_at = camera.look_at_ct.mm;
  const double distance_mm = (camera.eye_ct.mm - look_at).norm();
  const Eigen::Matrix3d& axes = volume.ultrasound->grid().directions;
  const Eigen::Vector3d from = (axes * config.predicates.from.stableNormalized()).normalized();
  camera.eye_ct = {look_at + distance_mm * from};
  constexpr double kNearlyAlong = 0.95;
  if (std::abs(camera.up_ct.v.normalized().dot(from)) > kNearlyAlong) camera.up_ct = {axes.col(2)};
  return camera;
}

class VolumeFeed final : public Feed {
 public:
  VolumeFeed(const SessionConfig& config, Console& console, std::string name,
             const render::Camera& camera, PlacedView::Parts parts)
      : name_(std::move(name)),
        simulated_(config.predicates.volume.empty()),
        window_(parts.predicates->volume.predicates.intensity),
        camera_(camera),
        session_(session::SessionSetup{}, console),
        view_(config, console, std::move(parts)) {
    view_.presenter().set_facts(
        {.plan = std::nullopt,
         .window = {0.5 * (window_.black + window_.white), window_.white - window_.black},
         .banner = kind()});
  }

  Result<std::optional<session::Epoch>> next(Timestamp) override {
    if (std::exchange(shown_, true)) return std::optional<session::Epoch>();
    return std::optional<session::Epoch>(session_.refresh());
  }
  [[nodiscard]] session::Epoch again(session::Epoch epoch, Timestamp) override { return epoch; }
  [[nodiscard]] Timestamp on_clock(Timestamp time) const override { return time; }
  [[nodiscard]] bool over() const override { return false; }
  void finish() override {
    session_.finish();
    session_.navigator().finish();
  }
  [[nodiscard]] std::optional<render::Camera> camera() const override { return camera_; }
  [[nodiscard]] bool stored() const override { return true; }
  [[nodiscard]] session::Session& session() override { return session_; }
  [[nodiscard]] PlacedView& view() override { return view_; }
  [[nodiscard]] std::string kind() const override {
    return simulated_ ? "SIMULATED VOLUME" : "STORED VOLUME";
  }
  [[nodiscard]] std::string ended() const override { return {}; }
  [[nodiscard]] std::vector<std::pair<std::string, std::string>> facts() override {
    return {{"patient", (simulated_ ? "phantom " : "3D ultrasound ") + name_},
            {"devices", "none: a stored volume is shown"},
            {"review", "predicate set " + view_.predicates()->file.name}};
  }

 private:
  std::string name_;
  bool simulated_;
  render::PredicateScene::IntensityWindow window_;
  render::Camera camera_;
  session::Session session_;
  PlacedView view_;
  bool shown_ = false;
};

}  // namespace

Result<std::unique_ptr<Feed>> open_volume_feed(const SessionConfig& config, Console& console) {
  auto prepared = prepare_predicates(config.predicates, config.output.threads, console,
                                     DistancesFrom::kNoNeedle);
  if (!prepared) return prepared.error();
  const render::Camera camera = camera_of_volume(*prepared, config);
  std::string name = prepared->volume.name;
  auto parts = PlacedView::prepare_alone(config, *std::move(prepared));
  if (!parts) return parts.error();
  return std::unique_ptr<Feed>(
      std::make_unique<VolumeFeed>(config, console, std::move(name), camera, *std::move(parts)));
}

}  // namespace nav::app
