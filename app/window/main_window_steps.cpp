// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The steps that act: Patient, Registration, Plan.
#include "app/window/main_window.hpp"
#include "app/window/theme.hpp"

namespace nav::app {

std::optional<Point<frames::Ct>> MainWindow::cursor() const {
  const SharedMoment& moment = loop_.newest();
  if (!moment) return std::nullopt;
  return cursor_of(loop_.slices(), *moment);
}

void MainWindow::add_steps() {
  step_page_->add(0, patient_);
  step_page_->add(3, registration_page_);
  step_page_->add(4, plan_);
  patient_->open = [this] { open_ct(); };
  patient_->cancel = [this] {
    opening_.reset();
    loop_.cancel_opening();
  };
  plan_->cursor = [this] { return cursor(); };
  plan_->edited = [this] { use_plan(); };
  plan_->pick_changed = [this] { show_pick(); };
  const auto picked = [this](const Point<frames::Ct>& point) {
    if (plan_->pick() == PlanPage::Pick::kNone) return false;
    plan_->picked(point);
    return true;
  };
  const auto follow = [this](EyeHandles& handles) {
    handles.moved = [this](const EyeMovement& movement) { registration_.move(movement); };
    handles.dragged = [this](bool begins) { registration_.drag(begins); };
  };
  for (const ViewId id : kFlatViews) {
    flat_[id]->picked = picked;
    follow(flat_[id]->handles());
  }
  follow(scene_->handles());
  loop_.looked = picked;
  registration_page_->overlay_changed = [this](const CtOverlay& overlay) {
    loop_.set_overlay(overlay);
    const QString words = overlay.mode == CtOverlay::Mode::kBlend          ? "CT OVER IT: BLEND"
                          : overlay.mode == CtOverlay::Mode::kCheckerboard ? "CT OVER IT: SQUARES"
                          : overlay.mode == CtOverlay::Mode::kWipe         ? "CT OVER IT: WIPE"
                                                                           : "";
    dynamic_cast<UltrasoundWidget&>(*flat_[ViewId::kUltrasound]).set_overlay_words(words);
  };
}

RegistrationDesk::Hears MainWindow::registration_hears() {
  return {.moment = [this] { return loop_.newest(); },
          .config = [this] { return config_to_register(); },
          .cursor = [this] { return cursor(); },
          .place = [this](const session::Placement& placement) { loop_.set_placement(placement); },
          .judged = [this](const RegistrationCandidate& candidate,
                           bool accepted) { judge(candidate, accepted); },
          .by_eye = [this](bool) { show_handles(); },
          .file =
              [this](const char* suffix) {
                return std::filesystem::absolute(stamped_file(QLatin1String(suffix)).toStdString());
              },
          .job =
              [this](const JobNews& news, double seconds, double cancel_ms) {
                loop_.show_job(news);
                if (news.stage == JobNews::Stage::kRunning) return;
                const bool cancelled = news.stage == JobNews::Stage::kCancelled;
                report_.job(news.name, seconds, cancelled,
                            cancelled ? std::optional(cancel_ms) : std::nullopt);
              }};
}

/// The session with the newest recording of its devices in place of them.
SessionConfig MainWindow::config_to_register() const {
  SessionConfig config = config_;
  const RecordingStatus& recording = loop_.recording();
  if (config.source.recording.empty() && !recording.path.empty() && !recording.since) {
    config.source.recording = recording.path;
  }
  return config;
}

void MainWindow::judge(const RegistrationCandidate& candidate, bool accepted) {
  if (!accepted) {
    if (candidate.method == "in use") verdict_ = "rejected";
    return update_panel();
  }
  verdict_ = "accepted";
  config_.placement.registration = candidate.file;
  config_.placement.ct_from_reference.reset();
  if (candidate.file.empty()) {
    config_.placement.ct_from_reference = candidate.placement->placement.ct_from_reference.matrix();
  }
  update_panel();
}

/// A registration that the user has rejected stays degraded, also when the session is reopened.
void MainWindow::keep_rejected(const Moment& moment) {
  const auto& placement = moment.placement;
  const bool valid = placement && placement->placement.safety.state == SafetyState::kValid;
  if (verdict_ != "rejected" || !valid) return;
  session::Placement rejected = *placement;
  rejected.placement.safety = {SafetyState::kDegraded, "the user has rejected the registration"};
  loop_.set_placement(rejected);
}

/// Opens the CT of the field in the background. What belongs to the old one goes with it.
void MainWindow::open_ct() {
  const std::string text = patient_->path().trimmed().toStdString();
  if (text.empty()) return patient_->say(QStringLiteral("Give a folder or a file."));
  const bool takes_ct =
      !config_.predicates.alone && config_.source.kind != SessionConfig::SourceKind::kSimulated;
  if (!takes_ct) {
    return patient_->say(QStringLiteral(
        "The simulated procedure has its own CT, and a stored volume none. A window without a "
        "session ('sonde window') opens a CT alone."));
  }
  // Without a session: the CT alone, to look at it and to plan.
  SessionConfig next = shown_session_ != 0 ? session_now() : SessionConfig();
  next.ct = {.path = std::filesystem::absolute(text)};
  next.placement = {};
  next.plan.reset();
  next.critical_structures.clear();
  next.window.cursor_mm.reset();
  next.window.camera = {};
  next.window.zooms.clear();
  next.window.transfer.reset();
  next.window.verdict.reset();
  patient_->say(QStringLiteral("Reading %1. The CT that is shown stays until it is complete.")
                    .arg(theme::plain(text)));
  open_session(next, session_file_, true);
}

void MainWindow::show_job() {
  const JobNews& job = loop_.job();
  patient_->set_busy(opening_.has_value());
  if (job.name != "open" || job.stage == JobNews::Stage::kRunning) return;
  if (opening_ && job.stage == JobNews::Stage::kDone) return;  // Its first moment has yet to come.
  const SharedMoment& moment = loop_.newest();
  if (job.stage == JobNews::Stage::kDone && moment) {
    const VoxelGrid& grid = moment->ct->grid();
    const Eigen::Vector3d& mm = grid.spacing_mm;
    patient_->say(QStringLiteral("%1: %2 x %3 x %4 voxels of %5 x %6 x %7 mm. Placement, plan and "
                                 "structures of another CT are not taken over.%8")
                      .arg(theme::plain(moment->ct->name()))
                      .arg(grid.size[0])
                      .arg(grid.size[1])
                      .arg(grid.size[2])
                      .arg(mm.x(), 0, 'f', 2)
                      .arg(mm.y(), 0, 'f', 2)
                      .arg(mm.z(), 0, 'f', 2)
                      .arg(moment->stored ? QStringLiteral(" Slices, 3D view and Plan can be used; "
                                                           "the step Devices says what is missing.")
                                          : QString()));
  } else {
    patient_->say(theme::plain(job.words) +
                  (moment ? QStringLiteral(". The session before stays.") : QStringLiteral(".")));
  }
}

void MainWindow::open_steps(const Moment& moment) {
  registration_.reset();
  PlanDraft draft;
  if (moment.plan) {
    draft.target = moment.plan->target_ct;
    draft.entry = moment.plan->entry_ct;
    draft.radius_mm = moment.plan->target_radius_mm;
    draft.margin_mm = moment.plan->margin_mm;
  }
  draft.structures = config_.critical_structures;
  plan_->open(std::move(draft));
  check_plan();
  patient_->set_path(QString::fromStdString(config_.ct.path.string()));
}

/// The draft has changed: shows it, and hands a complete plan to the session.
void MainWindow::use_plan() {
  config_.critical_structures = plan_->draft().structures;
  if (const auto plan = plan_->draft().plan()) {
    config_.plan = *plan;
    loop_.set_plan(*plan);
  }
  check_plan();
}

/// Checks the path on a thread of its own; only the newest check counts.
void MainWindow::check_plan() {
  edits_.structures.clear();
  for (const auto& one : plan_->draft().structures) {
    if (one.sphere) edits_.structures.push_back(*one.sphere);
  }
  push_edits();
  for (const ViewId id : kFlatViews) flat_[id]->set_structures(edits_.structures);
  const SharedMoment& moment = loop_.newest();
  const auto plan = plan_->draft().plan();
  const std::uint64_t number = ++plan_check_;
  numerals_->expect_structures(!plan_->draft().structures.empty());
  loop_.set_structures({number, nullptr});
  if (!plan || !moment) return;
  checkers_.emplace_back(
      [this, number, plan = *plan, structures = plan_->draft().structures, ct = moment->ct] {
        const auto check = session::check_path(plan, structures, *ct);
        QMetaObject::invokeMethod(
            this,
            [this, number, check] {
              if (number == plan_check_) plan_->show_check(check);
            },
            Qt::QueuedConnection);
        if (number != plan_check_) return;
        auto distances = std::make_shared<const session::StructureDistances>(
            session::StructureDistances::create(plan, structures, *ct));
        QMetaObject::invokeMethod(
            this,
            [this, number, distances] {
              if (number == plan_check_) loop_.set_structures({number, distances});
            },
            Qt::QueuedConnection);
      });
}

/// Handles to place the CT by eye, only while their step is open.
void MainWindow::show_handles() {
  const bool on = registration_page_->by_eye() && step_ == 3 && tool() == Tool::kStep;
  for (const ViewId id : kFlatViews) flat_[id]->set_by_eye(on);
  scene_->set_by_eye(on);
}

/// Says in each view what the next click does.
void MainWindow::show_pick() {
  const PlanPage::Pick pick = plan_->pick();
  const QString mode = pick == PlanPage::Pick::kTarget  ? QStringLiteral("CLICK: TARGET")
                       : pick == PlanPage::Pick::kEntry ? QStringLiteral("CLICK: ENTRY")
                                                        : QString();
  for (const ViewId id : kFlatViews) flat_[id]->set_mode(mode);
  scene_->set_mode(mode);
}

std::optional<QString> MainWindow::plan_value(const QString& what) const {
  const auto& check = plan_->check();
  const auto number = [](double value) { return QString::number(value, 'f', 1); };
  if (what == QLatin1String("state")) {
    if (!plan_->draft().plan()) return QStringLiteral("none");
    if (!check) return QStringLiteral("busy");
    for (const auto& one : check->clearances) {
      if (one.too_near) return QStringLiteral("too-near");
    }
    return QStringLiteral("clear");
  }
  if (what == QLatin1String("structures")) {
    return QString::number(plan_->draft().structures.size());
  }
  if (what == QLatin1String("length")) {
    return check ? number(check->length_mm) : QStringLiteral("none");
  }
  const auto point = [&](const std::optional<Point<frames::Ct>>& p) {
    if (!p) return QStringLiteral("none");
    return number(p->mm.x()) + QLatin1Char(',') + number(p->mm.y()) + QLatin1Char(',') +
           number(p->mm.z());
  };
  if (what == QLatin1String("target")) return point(plan_->draft().target);
  if (what == QLatin1String("entry")) return point(plan_->draft().entry);
  return std::nullopt;
}

}  // namespace nav::app
