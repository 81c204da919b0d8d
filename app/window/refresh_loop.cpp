// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/refresh_loop.hpp"

#include <utility>

#include "app/window/theme.hpp"

namespace nav::app {

namespace {

/// Puts a value into a box of the window's thread and wakes that thread once.
template <class T>
auto poster(Mailbox<T>& box, RefreshLoop& loop) {
  return [&box, &loop](T value) {
    if (!box.put(std::move(value))) return;
    QMetaObject::invokeMethod(
        &loop, [&loop] { loop.tick(); }, Qt::QueuedConnection);
  };
}

/// Sentence about a recording; empty while there is none.
QString words_of(const RecordingStatus& recording, Timestamp now) {
  const QString file = QString::fromStdString(recording.path.filename().string());
  if (!recording.failure.empty()) {
    return QStringLiteral("NOT RECORDED: ") + theme::plain(recording.failure);
  }
  if (!recording.since) return {};
  QString words = QStringLiteral("recording %1: %2 s")
                      .arg(file)
                      .arg(static_cast<int>(to_seconds(now - *recording.since)));
  if (recording.lost > 0) words += QStringLiteral(", %1 samples lost").arg(recording.lost);
  return words;
}

const char* cost_name(ViewId id) {
  switch (id) {
    case ViewId::kUltrasound:
      return "ultrasound";
    case ViewId::kCt:
      return "ct";
    case ViewId::kBullsEye:
      return "bull's-eye";
    case ViewId::kNeedleFirst:
    case ViewId::kNeedleSecond:
      return "needle slice";
    default:
      return "slice";
  }
}

}  // namespace

RefreshLoop::RefreshLoop(const Options& options, const Clock& clock, Console& console,
                         WindowReport& report, const SessionViews& views)
    : clock_(clock),
      report_(report),
      views_(views),
      has_session_(options.has_session),
      flat_engine_({poster(flats_, *this), poster(flat_failures_, *this)}),
      scene_engine_(
          options.engine, options.config.output.threads, clock, console,
          {poster(scenes_, *this), poster(scene_failures_, *this), poster(looks_, *this)}),
      session_(options.config, options.loop, clock, console,
               {poster(moments_, *this), poster(news_box_, *this), poster(recording_box_, *this),
                poster(job_box_, *this),
                // Each counts: a mailbox would keep the newest only.
                [this](session::PressedButton press) {
                  QMetaObject::invokeMethod(
                      this,
                      [this, press = std::move(press)] {
                        if (pressed) pressed(press);
                      },
                      Qt::QueuedConnection);
                }}) {
  if (!has_session_)
    news_.words = "no session: open a CT (step 1, Patient), or start with a SESSION or --simulated";
  views_.scene->moved = [this](const render::CameraMovement& movement) { move_camera(movement); };
  views_.scene->resized = [this] { order_images(); };
  views_.scene->looked_at = [this](const ViewImage& seen, int x, int y) {
    scene_engine_.look({{.moment = seen.moment,
                         .camera = seen.camera,
                         .size = {seen.image.width(), seen.image.height()},
                         .edits = edits_},
                        x,
                        y});
  };
  views_.scene->seen_from = [this](render::ViewFrom side) {
    if (const auto now = camera()) set_camera(render::seen_from(*now, side));
  };
  for (const ViewId id : kFlatViews) {
    views_.flat[id]->resized = [this] { order_images(); };
    views_.flat[id]->moved = [this](ViewId view, const SliceInput& input, const ViewImage& seen) {
      move_slices(view, input, seen);
    };
  }
  measure_painting();
}

void RefreshLoop::measure_painting() {
  for (const ViewId id : kFlatViews) {
    views_.flat[id]->painted = [this, id](const ViewImage& view_image, double ms) {
      report_.paint(ms);
      report_.convert(view_image.convert_ms);
      report_.draw(cost_name(id), view_image.draw_ms);
      if (slices_asked_ && view_image.asked >= slices_.number()) {
        report_.input_to_paint(1e3 * to_seconds(clock_.now() - *slices_asked_));
        slices_asked_.reset();
      }
      if (id != ViewId::kUltrasound) return;
      const Moment& moment = *view_image.moment;
      if (!moment.acquired || !moment.epoch.frame || frozen_) return;
      const std::uint64_t image = moment.epoch.frame->frame.sequence + 1;
      if (image == std::exchange(latency_of_, image)) return;
      report_.latency(1e3 * to_seconds(clock_.now() - *moment.acquired));
    };
  }
  views_.scene->painted = [this](const ViewImage& view_image, double ms) {
    report_.paint(ms);
    report_.convert(view_image.convert_ms);
    report_.draw(view_image.refined ? "scene, full" : "scene, coarse", view_image.draw_ms);
    if (!view_image.refined) {
      report_.draw("scene, 1/" + std::to_string(view_image.factor), view_image.draw_ms);
    }
    if (!camera_asked_ || view_image.asked < camera_number_) return;
    report_.input_to_paint(1e3 * to_seconds(clock_.now() - *camera_asked_));
    camera_asked_.reset();
  };
}

void RefreshLoop::start() {
  flat_engine_.start();
  scene_engine_.start();
  if (has_session_) session_.start();
}

void RefreshLoop::stop() {
  session_.stop();
  flat_engine_.stop();
  scene_engine_.stop();
}

void RefreshLoop::move_camera(const render::CameraMovement& movement) {
  if (const auto now = camera()) set_camera(render::moved(*now, movement));
}

std::optional<render::Camera> RefreshLoop::camera() const {
  if (camera_) return camera_;
  const SharedMoment moment = wanted();
  if (!moment) return std::nullopt;
  return moment->scene->camera;
}

void RefreshLoop::set_camera(const render::Camera& camera) {
  camera_ = camera;
  scene_changed();
}

void RefreshLoop::set_edits(std::shared_ptr<const SceneEdits> edits) {
  edits_ = std::move(edits);
  scene_changed();
}

void RefreshLoop::scene_changed() {
  ++camera_number_;
  const SharedMoment moment = wanted();
  if (!moment) return;
  if (!camera_asked_) camera_asked_ = clock_.now();
  order_scene(moment);
}

void RefreshLoop::show_ultrasound_slices(bool shown) {
  slices_.show_ultrasound(shown);
  order_images();
}

void RefreshLoop::order_scene(const SharedMoment& moment) {
  if (!is_drawn(ViewId::kScene)) return;
  scene_engine_.draw({moment, camera_, views_.scene->pixel_size(), camera_number_, frozen(),
                      slices_.settings().cursor, edits_});
}

void RefreshLoop::move_slices(ViewId id, const SliceInput& input, const ViewImage& seen) {
  if (!slices_.apply(id, input, seen)) return;
  if (!slices_asked_) slices_asked_ = clock_.now();
  order_images();
}

void RefreshLoop::open(const SessionConfig& config) {
  has_session_ = true;
  session_.open(config);
}

void RefreshLoop::show_job(const JobNews& news) {
  job_ = news;
  if (changed) changed();
}

void RefreshLoop::set_overlay(const CtOverlay& overlay) {
  slices_.set_overlay(overlay);
  order_images();
}

void RefreshLoop::set_slices(const SliceSettings& settings) {
  slices_.restore(settings);
  order_images();
}

void RefreshLoop::reset_slices() {
  slices_.reset();
  order_images();
}

bool RefreshLoop::is_drawn(ViewId id) const {
  const ViewWidget* view =
      id == ViewId::kScene ? static_cast<const ViewWidget*>(views_.scene) : views_.flat[id];
  return !view->isHidden() || mirrored_[id];
}

void RefreshLoop::set_mirrored(const PerView<bool>& views) {
  if (std::exchange(mirrored_, views).all != views.all) views_changed();
}

void RefreshLoop::views_changed() {
  const bool scene = is_drawn(ViewId::kScene);
  assembler_.expect_scene(scene);
  if (!scene) {
    views_.scene->clear_image();
    scene_moment_.reset();
  }
  for (const ViewId id : kFlatViews) {
    if (!is_drawn(id)) views_.flat[id]->clear_image();
  }
  order_images();
}

void RefreshLoop::reset_camera() {
  camera_.reset();
  ++camera_number_;
  order_images();
}

void RefreshLoop::set_frozen(bool frozen) {
  if (frozen == frozen_.has_value() || (frozen && !flat_moment_)) return;
  if (frozen) {
    frozen_ = Frozen{flat_moment_, clock_.now()};
  } else {
    frozen_.reset();
    views_.scene->set_frozen(std::nullopt);
    for (const ViewId id : kFlatViews) views_.flat[id]->set_frozen(std::nullopt);
  }
  order_images();
  tick();
}

void RefreshLoop::order_images() {
  const SharedMoment moment = wanted();
  if (!moment) return;
  FlatEngine::Order order{.moment = moment,
                          .ratio = views_.scene->devicePixelRatioF(),
                          .settings = slices_.settings(),
                          .number = slices_.number()};
  for (const ViewId id : kFlatViews) {
    const FlatWidget& view = *views_.flat[id];
    order.sizes[id] = is_drawn(id) ? view.pixel_size() : PixelSize{0, 0};
  }
  flat_engine_.draw(std::move(order));
  order_scene(moment);
}

bool RefreshLoop::fault(const std::string& name, Duration time) {
  if (name == "hang-engine") {
    scene_engine_.hang(time);
  } else if (name == "hang-views") {
    flat_engine_.hang(time);
  } else if (name == "hang-session") {
    session_.hang(time);
  } else if (name == "cover-marker" || name == "hold-images") {
    session_.order({name, time});
  } else {
    return false;
  }
  loss_ = Loss{clock_.now()};
  return true;
}

void RefreshLoop::take_all() {
  if (auto news = news_box_.take()) {
    news_ = std::move(*news);
    if (changed) changed();
  }
  if (auto recording = recording_box_.take()) {
    recording_ = std::move(*recording);
    if (changed) changed();
  }
  if (auto job = job_box_.take()) {
    job_ = std::move(*job);
    if (changed) changed();
  }
  if (const auto look = looks_.take(); look && *look && camera() && !(looked && looked(**look))) {
    set_camera(render::looking_at(*camera(), **look));
  }
  if (auto failure = scene_failures_.take()) failures_.scene = std::move(*failure);
  if (auto failure = flat_failures_.take()) failures_.flat = std::move(*failure);
  const Timestamp now = clock_.now();
  if (auto moment = moments_.take()) {
    newest_ = std::move(*moment);
    for (const InputStatus& input : newest_->inputs) report_.state(to_seconds(now), input);
    if (!frozen_) order_images();
  }
  const auto fits = [this](const auto& view_image) {
    return !frozen_ || view_image.moment->number == frozen_->moment->number;
  };
  if (auto flat = flats_.take(); flat && fits(*flat)) {
    assembler_.add(std::move(*flat), now);
  }
  if (auto scene = scenes_.take(); scene && fits(*scene)) {
    assembler_.add(std::move(*scene), now);
  }
}

void RefreshLoop::show(Assembled shown) {
  if (!shown.flat && !shown.scene) return;
  if (shown.flat) {
    flat_moment_ = shown.flat->moment;
    for (const ViewId id : kFlatViews) {
      auto& view_image = shown.flat->views[id];
      // A view that has just come to the screen was not ordered yet: it waits for its image.
      if (view_image && is_drawn(id)) {
        views_.flat[id]->set_view_image(*std::move(view_image));
      } else {
        views_.flat[id]->clear_image();
      }
    }
  }
  if (shown.scene) {
    scene_moment_ = shown.scene->moment;
    views_.scene->set_view_image(std::move(*shown.scene));
  }
}

void RefreshLoop::tick() {
  take_all();
  Assembled shown = assembler_.next(clock_.now());
  const bool refreshed = shown.flat.has_value() || shown.scene.has_value();
  show(std::move(shown));
  const Timestamp now = clock_.now();
  judgement_ = judge(newest_, flat_moment_, scene_moment_, failures_, now, structures_);
  if (!newest_) {
    for (ViewJudgement* view : {&judgement_.ultrasound, &judgement_.ct, &judgement_.scene,
                                &judgement_.slices, &judgement_.needle, &judgement_.bullseye}) {
      view->headline = news_.stage == SessionNews::Stage::kFailed ? "NO SESSION"
                       : has_session_                             ? "LOADING"
                                                                  : "NO SESSION";
      view->safety.cause = failures_.scene.empty() ? news_.words : failures_.scene;
    }
    judgement_.withdrawn = news_.words;
  }
  apply(judgement_, now);
  measure(now);
  if (refreshed && flat_moment_) report_.refresh(views_agree());
}

/// Each view keeps the moment that it shows; one that differs has to be marked or covered.
bool RefreshLoop::views_agree() const {
  for (const ViewId id : kFlatViews) {
    const auto& view_image = views_.flat[id]->view_image();
    if (view_image && view_image->moment->number != flat_moment_->number) return false;
  }
  if (!scene_moment_ || scene_moment_->number == flat_moment_->number) return true;
  const Judgement& j = judgement_;
  return j.scene.late || j.scene.covered || j.ultrasound.late || j.ultrasound.covered;
}

/// A frozen view says that it is frozen and shows no live number. It is covered only where there is
/// nothing to see in it.
void RefreshLoop::judge_frozen(Judgement& shown, Timestamp now) {
  const Safety frozen{SafetyState::kStale, "frozen by the user"};
  const double seconds = to_seconds(now - frozen_->since);
  if (scene_moment_) shown.scene.covered = false;
  shown.scene.safety = frozen;
  views_.scene->set_frozen(seconds);
  for (const ViewId id : kFlatViews) {
    const auto& view_image = views_.flat[id]->view_image();
    ViewJudgement& view = judgement_of(shown, id);
    view.covered = !view_image || (!view_image->plane && !view_image->slice);
    view.late = false;
    view.headline = "NOTHING TO SHOW";
    view.safety = frozen;
    view.about.clear();
    views_.flat[id]->set_judgement(view, newest_ ? newest_->kind : "");
    views_.flat[id]->set_frozen(seconds);
  }
  shown.guidance.reset();
  shown.nearest.reset();
  shown.withdrawn = frozen.cause;
}

void RefreshLoop::apply(const Judgement& judgement, Timestamp now) {
  const std::string kind = newest_ ? newest_->kind : "";
  Judgement shown = judgement;
  if (frozen_) {
    judge_frozen(shown, now);
  } else {
    for (const ViewId id : kFlatViews) {
      views_.flat[id]->set_judgement(judgement_of(shown, id), kind);
    }
  }
  views_.scene->set_judgement(shown.scene, kind);
  views_.numerals->show_numbers(shown.guidance, shown.error, shown.withdrawn, shown.nearest);
  QString notice;
  if (!newest_) {
    notice = QString::fromStdString(news_.words);
  } else {
    notice = QString::fromStdString(!newest_->notice.empty() ? newest_->notice : newest_->warning);
  }
  if (job_.stage == JobNews::Stage::kRunning) {
    QString job = theme::plain(job_.words);
    if (job_.share) job += QStringLiteral(" %1 %").arg(std::lround(100 * *job_.share));
    notice = notice.isEmpty() ? job : job + QStringLiteral("; ") + notice;
  }
  const QString recording = words_of(recording_, now);
  if (!recording.isEmpty()) {
    notice = notice.isEmpty() ? recording : recording + QStringLiteral("; ") + notice;
  }
  views_.status->show_inputs(newest_ ? newest_->inputs : std::vector<InputStatus>(), notice, now);
}

/// Times from an ordered fault to its effect.
void RefreshLoop::measure(Timestamp now) {
  if (!loss_) return;
  const double ms = 1e3 * to_seconds(now - loss_->since);
  if (!loss_->withdrawn && !judgement_.guidance) {
    loss_->withdrawn = true;
    report_.withdrawn(ms);
  }
  if (!loss_->covered && (judgement_.ultrasound.covered || judgement_.scene.covered)) {
    loss_->covered = true;
    report_.covered(ms);
  }
}

void RefreshLoop::complete(io::Json& report) const {
  const auto [name, device] = scene_engine_.engine();
  report["engine"] = name.empty() ? io::Json(nullptr) : io::Json(name);
  report["device"] = device.empty() ? io::Json(nullptr) : io::Json(device);
  report["superseded"] = {{"moments", moments_.superseded()},
                          {"3D view", scene_engine_.superseded()},
                          {"flat views", flat_engine_.superseded()},
                          {"pictures", assembler_.superseded()}};
  report["interrupted"] = scene_engine_.interrupted();
  report["ledger"] = session_.ledger();
  report["recordings"] = session_.recordings();
  report["buttons"] = session_.presses();
}

}  // namespace nav::app
