// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/registration_desk.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <sstream>
#include <utility>

#include "app/verbs/register/landmark_outcome.hpp"
#include "app/window/theme.hpp"
#include "io/atomic_file.hpp"
#include "io/json_member.hpp"
#include "registration/acceptance.hpp"
#include "session/registration_file.hpp"

namespace nav::app {
namespace {

constexpr std::uint64_t kMostReportBytes = 64 << 20;
constexpr double kRadOfStep = M_PI / 180;

std::string mm_words(double mm) {
  std::ostringstream text;
  text << std::fixed << std::setprecision(1) << mm << " mm";
  return text.str();
}

std::string list_of(const io::Json& texts) {
  std::string all;
  for (const auto& one : texts) {
    if (one.is_string()) all += (all.empty() ? "" : "; ") + one.get<std::string>();
  }
  return all;
}

/// Sentence about the report of a registration: verdict, predicted error, residuals, causes.
std::string words_of_report(const io::Json& report) {
  const io::Json registration = report.value("registration", io::Json::object());
  std::string words = "Verdict of the limits: " + registration.value("verdict", std::string("?"));
  const io::Json error = registration.value("target_error_rms_mm", io::Json());
  words += error.is_number()
               ? ". Predicted error at the target: " + mm_words(error.get<double>()) + " rms"
               : ". The error at the target is not known";
  const io::Json landmarks = registration.value("landmarks", io::Json());
  if (landmarks.is_array() && !landmarks.empty()) {
    words += ". Residuals:";
    for (const auto& one : landmarks) {
      words +=
          " " + one.value("name", std::string()) + " " + mm_words(one.value("residual_mm", 0.0));
    }
  }
  const std::string causes = list_of(registration.value("reasons", io::Json::array()));
  const std::string warnings = list_of(registration.value("warnings", io::Json::array()));
  if (!causes.empty()) words += ". Refused: " + causes;
  if (!warnings.empty()) words += ". Warning: " + warnings;
  return words + ".";
}

/// Landmarks as `sonde register --landmarks` reads them.
std::string csv_of(const std::vector<registration::LandmarkPair>& pairs) {
  std::ostringstream text;
  text << std::setprecision(17)
       << "name,reference_x_mm,reference_y_mm,reference_z_mm,ct_x_mm,ct_y_mm,ct_z_mm\n";
  for (const auto& pair : pairs) {
    const auto& r = pair.reference.mm;
    const auto& c = pair.ct.mm;
    text << pair.name << ',' << r.x() << ',' << r.y() << ',' << r.z() << ',' << c.x() << ','
         << c.y() << ',' << c.z() << '\n';
  }
  return text.str();
}

}  // namespace

RegistrationDesk::RegistrationDesk(RegistrationPage& page, Hears hears)
    : page_(page), hears_(std::move(hears)) {
  page_.point = [this] { add_point(); };
  page_.touch = [this] { touch(); };
  page_.remove = [this] { remove(); };
  page_.fit = [this] { fit(); };
  page_.sweep = [this] { sweep(); };
  page_.cancel = [this] { cancel(); };
  page_.accept = [this] { judge(true); };
  page_.reject = [this] { judge(false); };
  page_.before = [this](bool on) { show_before(on); };
  page_.by_eye_changed = [this](bool on) { by_eye(on); };
  page_.nudged = [this](const RegistrationPage::Nudge& one) { nudge(one); };
  page_.undo = [this] { undo(); };
  page_.redo = [this] { redo(); };
  job_.progressed = [this](double share, const QString& stage) {
    hears_.job({JobNews::Stage::kRunning, "register", stage.toStdString(), share}, 0, 0);
  };
}

void RegistrationDesk::stop() {
  job_.cancel();
  workers_.clear();
}

void RegistrationDesk::reset() {
  job_.cancel();
  ++session_;
  landmarks_.clear();
  candidate_.reset();
  before_.reset();
  eye_ = {};
  state_ = "none";
  page_.set_by_eye(false);
  page_.set_running(false);
  page_.set_waiting(false, false);
  page_.say({});
  show_landmarks();
}

std::optional<Point<frames::Ct>> RegistrationDesk::target() const {
  const SharedMoment moment = hears_.moment();
  if (!moment || !moment->plan) return std::nullopt;
  return moment->plan->target_ct;
}

void RegistrationDesk::show_landmarks() {
  QStringList names;
  for (const Landmark& one : landmarks_) {
    const char* state = one.ct && one.reference ? "pair" : one.ct ? "in the CT" : "touched";
    names.append(QString::fromStdString(one.name + " (" + state + ")"));
  }
  page_.show_landmarks(names);
}

/// A point completes the chosen landmark if it lacks that part; otherwise it begins a new one.
void RegistrationDesk::add_point() {
  const auto cursor = hears_.cursor();
  if (!cursor) return page_.say(QStringLiteral("There is no CT with a cursor yet."));
  const auto waits = std::ranges::find_if(landmarks_, [](const auto& one) { return !one.ct; });
  if (waits != landmarks_.end()) {
    waits->ct = *cursor;
  } else {
    landmarks_.push_back({"L" + std::to_string(landmarks_.size() + 1), *cursor, {}});
  }
  show_landmarks();
}

void RegistrationDesk::touch() {
  const SharedMoment moment = hears_.moment();
  const bool tip = moment && moment->epoch.ct_from_needle && moment->placement &&
                   moment->epoch.needle.state <= SafetyState::kDegraded;
  if (!tip) {
    return page_.say(QStringLiteral("The tip of the needle is not tracked now: %1.")
                         .arg(theme::plain(moment ? moment->epoch.needle.cause
                                                  : std::string("there is no session"))));
  }
  const auto reference_from_ct = moment->placement->placement.ct_from_reference.inverse();
  const Point<frames::Reference> touched =
      reference_from_ct * (*moment->epoch.ct_from_needle * Point<frames::Needle>{{0, 0, 0}});
  const auto waits =
      std::ranges::find_if(landmarks_, [](const auto& one) { return !one.reference; });
  if (waits != landmarks_.end()) {
    waits->reference = touched;
  } else {
    landmarks_.push_back({"L" + std::to_string(landmarks_.size() + 1), {}, touched});
  }
  show_landmarks();
}

void RegistrationDesk::remove() {
  const int chosen = page_.chosen_landmark();
  if (chosen < 0 || chosen >= static_cast<int>(landmarks_.size())) return;
  landmarks_.erase(landmarks_.begin() + chosen);
  show_landmarks();
}

void RegistrationDesk::fit() {
  const SharedMoment moment = hears_.moment();
  std::vector<registration::LandmarkPair> pairs;
  for (const Landmark& one : landmarks_) {
    if (one.ct && one.reference) pairs.push_back({one.name, *one.reference, *one.ct});
  }
  if (!moment || pairs.size() < 3) {
    return page_.say(QStringLiteral("A fit needs at least 3 landmarks that are both pointed at in "
                                    "the CT and touched; there are %1.")
                         .arg(pairs.size()));
  }
  page_.say(QStringLiteral("Fitting the landmarks…"));
  const std::filesystem::path points = hears_.file("landmarks.csv");
  const std::filesystem::path file = hears_.file("registration.json");
  const SessionConfig config = hears_.config();
  const std::string ct_name = config.ct.path.empty() ? moment->ct->name() : config.ct.path.string();
  read(
      "landmarks",
      [pairs, points, file, ct_name, ct = moment->ct, frame = moment->reference_frame,
       target = target()]() -> Result<std::string> {
        if (auto ok = io::write_file(points, std::string_view(csv_of(pairs))); !ok) {
          return ok.error();
        }
        CollectingDiagnostics said;
        const auto outcome = register_landmark_file(points, {}, ct.get(), said);
        if (!outcome) return outcome.error();
        const Point<frames::Ct> at = target.value_or(outcome->fit.uncertainty.centre_ct);
        const auto decision = decide(*outcome, at);
        const io::Json report = landmark_report(*outcome, decision, at, {ct.get(), ct_name}, frame);
        if (auto ok = io::write_file(file, std::string_view(report.dump(2) + "\n")); !ok) {
          return ok.error();
        }
        return std::string();
      },
      file);
}

void RegistrationDesk::sweep() {
  if (job_.runs()) return;
  const SharedMoment moment = hears_.moment();
  if (!moment) return page_.say(QStringLiteral("There is no session to register yet."));
  const SessionConfig config = hears_.config();
  std::optional<Eigen::Matrix4d> start;
  const auto& placement = moment->placement;
  if (placement && placement->kind != "centred") {
    start = placement->placement.ct_from_reference.matrix();
  }
  std::optional<Eigen::Vector3d> at;
  if (const auto point = target()) at = point->mm;
  const std::filesystem::path file = hears_.file("registration.json");
  const auto words = register_words(config, start, at, file);
  if (!words) return page_.say(theme::plain(words.error().message));
  state_ = "running";
  begun_ = std::chrono::steady_clock::now();
  page_.set_running(true);
  page_.say(QStringLiteral("Registering by the sweep…"));
  hears_.job({JobNews::Stage::kRunning, "register", "registering by the sweep", {}}, 0, 0);
  job_.done = [this, file](int code, const QString& said) {
    page_.set_running(false);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - *begun_).count();
    std::error_code none;
    const bool reported = std::filesystem::exists(file, none);
    if (code != 0 && !reported) {
      state_ = "none";
      page_.say(QStringLiteral("The registration failed: %1").arg(said));
      return hears_.job({JobNews::Stage::kFailed, "register", said.toStdString(), {}}, seconds, 0);
    }
    hears_.job({JobNews::Stage::kDone, "register", "the registration has ended", {}}, seconds, 0);
    read(
        "sweep", [] { return Result<std::string>(std::string()); }, file);
  };
  job_.start(*words);
}

void RegistrationDesk::cancel() {
  if (!job_.runs()) return;
  const auto asked = std::chrono::steady_clock::now();
  job_.cancel();
  state_ = "none";
  page_.set_running(false);
  page_.say(QStringLiteral("The registration was cancelled; nothing has changed."));
  const auto now = std::chrono::steady_clock::now();
  hears_.job({JobNews::Stage::kCancelled, "register", "the registration was cancelled", {}},
             std::chrono::duration<double>(now - *begun_).count(),
             std::chrono::duration<double, std::milli>(now - asked).count());
}

void RegistrationDesk::read(const std::string& method, std::function<Result<std::string>()> make,
                            const std::filesystem::path& file) {
  const SharedMoment moment = hears_.moment();
  workers_.emplace_back([this, method, make = std::move(make), file, ct = moment->ct,
                         frame = moment->reference_frame, session = session_] {
    RegistrationCandidate made{.method = method, .words = {}, .placement = {}, .file = file};
    const auto fail = [&](const Error& error) { made.words = error.message; };
    if (const auto ready = make(); !ready) {
      fail(ready.error());
    } else if (const auto report = io::read_json(file, kMostReportBytes); !report) {
      fail(report.error());
    } else {
      made.words = words_of_report(*report);
      const io::Json registration = report->value("registration", io::Json::object());
      if (registration.value("accepted", false)) {
        session::PlacementOptions options;
        options.registration = file;
        auto placement = session::given_placement(options, *ct, frame);
        if (placement) {
          made.placement = *std::move(placement);
        } else {
          fail(placement.error());
        }
      }
    }
    QMetaObject::invokeMethod(
        &page_,
        [this, made = std::move(made), session] {
          if (session == session_) take(made);
        },
        Qt::QueuedConnection);
  });
}

void RegistrationDesk::take(RegistrationCandidate candidate) {
  const SharedMoment moment = hears_.moment();
  page_.say(theme::plain(candidate.words));
  state_ = candidate.placement ? "waiting" : "refused";
  if (!candidate.placement) return page_.set_waiting(false, false);
  if (!before_ && moment) before_ = moment->placement;
  candidate_ = std::move(candidate);
  preview(*candidate_->placement);
  page_.set_waiting(true, true);
}

void RegistrationDesk::preview(const session::Placement& placement) {
  session::Placement shown = placement;
  shown.placement.safety = {SafetyState::kDegraded,
                            "this registration waits for the user's verdict"};
  hears_.place(shown);
}

void RegistrationDesk::show_before(bool before) {
  if (!candidate_ || !before_) return;
  if (before) {
    hears_.place(*before_);
  } else {
    preview(*candidate_->placement);
  }
}

void RegistrationDesk::judge(bool accepts) {
  if (!candidate_) {
    if (accepts) return;
    state_ = "rejected";
    page_.set_waiting(false, false);
    page_.say(QStringLiteral("The registration in use was rejected by the user: it is degraded."));
    return hears_.judged({.method = "in use", .words = {}, .placement = {}, .file = {}}, false);
  }
  const RegistrationCandidate judged = *std::exchange(candidate_, std::nullopt);
  if (accepts) {
    hears_.place(*judged.placement);
  } else if (before_) {
    hears_.place(*before_);
  }
  before_.reset();
  eye_ = {};
  state_ = accepts ? "accepted" : "rejected";
  page_.set_waiting(false, false);
  page_.set_undo(false, false);
  page_.set_by_eye(false);
  page_.say(accepts ? QStringLiteral("Accepted by the user: %1").arg(theme::plain(judged.words))
                    : QStringLiteral("Rejected by the user; the CT lies where it was."));
  hears_.judged(judged, accepts);
}

void RegistrationDesk::by_eye(bool on) {
  if (hears_.by_eye) hears_.by_eye(on);
  if (!on) return;
  const SharedMoment moment = hears_.moment();
  if (!moment || !moment->placement) {
    page_.set_by_eye(false);
    return page_.say(QStringLiteral("There is no CT beside an ultrasound image yet."));
  }
  if (!before_) before_ = moment->placement;
  eye_ = render::UndoHistory<std::optional<Transform<frames::Ct, frames::Reference>>>(
      moment->placement->placement.ct_from_reference);
  page_.say(
      QStringLiteral("Shift and turn the CT until it fits. A position by eye is degraded: no "
                     "numbers."));
}

void RegistrationDesk::nudge(const RegistrationPage::Nudge& nudge) {
  const double step = page_.step();
  EyeMovement movement;
  // Turned about the cursor, which stays where it is.
  movement.about = hears_.cursor().value_or(Point<frames::Ct>{{0, 0, 0}});
  movement.shift_mm = step * nudge.shift;
  if (nudge.turn.norm() > 0) movement.turn_rad = step * kRadOfStep * nudge.turn.normalized();
  move(movement);
}

void RegistrationDesk::move(const EyeMovement& movement) {
  if (!page_.by_eye() || !eye_.value()) return;
  const auto& now = *eye_.value();
  // The patient's image moves against the CT.
  const double angle = movement.turn_rad.norm();
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  if (angle > 0) turn = Eigen::AngleAxisd(-angle, movement.turn_rad / angle);
  const Eigen::Vector3d about = movement.about.mm;
  const Eigen::Vector3d shifted = turn * (now.translation_mm() - about) + about - movement.shift_mm;
  eye_.change(
      Transform<frames::Ct, frames::Reference>((turn * now.rotation()).normalized(), shifted));
  show_eye();
}

void RegistrationDesk::drag(bool begins) {
  if (begins) {
    eye_.begin();
  } else {
    eye_.end();
  }
}

void RegistrationDesk::show_eye() {
  page_.set_undo(eye_.can_undo(), eye_.can_redo());
  const Safety by_eye{SafetyState::kDegraded, "the CT was placed by eye, not registered"};
  session::Placement placement{.placement = {*eye_.value(), by_eye},
                               .kind = "declared",
                               .statement = "The CT is not registered: the user placed it by eye."};
  candidate_ = RegistrationCandidate{.method = "eye",
                                     .words =
                                         "placed by eye: degraded until landmarks or images "
                                         "confirm it.",
                                     .placement = placement,
                                     .file = {}};
  state_ = "waiting";
  hears_.place(placement);
  page_.set_waiting(true, true);
}

bool RegistrationDesk::undo() {
  if (!page_.by_eye() || !eye_.undo()) return false;
  show_eye();
  return true;
}

bool RegistrationDesk::redo() {
  if (!page_.by_eye() || !eye_.redo()) return false;
  show_eye();
  return true;
}

}  // namespace nav::app
