// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/recording_reader.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "io/recorded_calibration.hpp"
#include "io/sequence.hpp"

namespace nav::io {
namespace {

/// Share by which the rounding of text to six digits may change a spacing between frames.
constexpr double kGridTolerance = 1e-3;

bool is_claimed(TrackingStatus status) {
  return status == TrackingStatus::kOk || status == TrackingStatus::kUnknown;
}

bool uses_frames(const Chain& chain) {
  return std::ranges::any_of(chain.links, [](const ChainLink& l) { return l.from_frame; });
}

std::string describe(const Chain& chain) {
  std::string text = chain.from + "→" + chain.to + ":";
  for (const ChainLink& link : chain.links) {
    text += " " + link.name + (link.inverted ? " inverted" : "") +
            (link.from_frame ? " (frames)" : " (configuration)");
  }
  return text;
}

struct Chains {
  RecordingForm form;
  Chain probe;                     ///< Image to reference in kImageInReference.
  std::optional<Chain> reference;  ///< Reference to tracker.
  /// Needle to tracker, or to the frame that is used as the tracker.
  std::optional<Chain> needle;
};

/// Finds a chain that contains transforms of the recording's frames.
std::optional<Chain> moving(const TransformTree& tree, const std::string& from,
                            const std::string& to) {
  auto chain = tree.find(from, to);
  if (!chain || !uses_frames(*chain)) return std::nullopt;
  return std::move(*chain);
}

Result<Chains> choose_chains(const TransformTree& tree, const RecordingOptions& o) {
  const bool no_reference = o.reference_frame == o.tracker_frame;
  const auto probe = moving(tree, o.probe_frame, o.tracker_frame);
  if (probe) {
    if (no_reference) return Chains{RecordingForm::kTracked, *probe, {}, {}};
    const auto reference = tree.find(o.reference_frame, o.tracker_frame);
    if (reference) return Chains{RecordingForm::kTracked, *probe, *reference, {}};
    return Error{reference.error().code,
                 reference.error().message +
                     "; without a reference body, name the tracker frame as the reference"};
  }
  if (const auto direct = moving(tree, o.probe_frame, o.reference_frame)) {
    return Chains{RecordingForm::kProbeInReference, *direct, {}, {}};
  }
  if (const auto image = moving(tree, o.image_frame, o.reference_frame)) {
    return Chains{RecordingForm::kImageInReference, *image, {}, {}};
  }
  return Error{ErrorCode::kNotFound, "expected frames that place " + o.probe_frame + " in " +
                                         o.tracker_frame + " or " + o.reference_frame + ", or " +
                                         o.image_frame + " in " + o.reference_frame + ", found " +
                                         tree.describe()};
}

/// Adds the chain of the needle, if one is named.
Result<void> choose_needle(const TransformTree& tree, const RecordingOptions& o, Chains& chains) {
  if (o.needle_frame.empty()) return {};
  const bool tracked = chains.form == RecordingForm::kTracked;
  const std::string& into = tracked ? o.tracker_frame : o.reference_frame;
  chains.needle = moving(tree, o.needle_frame, into);
  if (chains.needle) return {};
  return Error{ErrorCode::kUsage, "expected frames that place the needle " + o.needle_frame +
                                      " in " + into + ", found " + tree.describe()};
}

/// A second way from the probe to the reference, past the tracker, if the frames state one.
std::optional<Chain> contradicting_chain(const TransformTree& tree, const Chains& chains,
                                         const RecordingOptions& options) {
  if (chains.form != RecordingForm::kTracked || !chains.reference) return std::nullopt;
  auto direct = moving(tree, options.probe_frame, options.reference_frame);
  if (!direct || direct->links.size() != 1) return std::nullopt;
  return direct;
}

bool same_grid(const PixelGrid& a, const PixelGrid& b) {
  const double scale = b.mm_per_pixel.cwiseAbs().maxCoeff();
  return (a.mm_per_pixel - b.mm_per_pixel).cwiseAbs().maxCoeff() <= kGridTolerance * scale;
}

/// "0.2 x 0.3 mm"; with the angle between rows and columns where it is no right one.
std::string pixel_text(const PixelGrid& grid) {
  constexpr double kRight = 1e-3;
  std::ostringstream text;
  text << grid.mm_per_pixel.col(0).norm() << " x " << grid.mm_per_pixel.col(1).norm() << " mm";
  if (std::abs(grid.shear_rad()) > kRight) {
    text << ", sheared by " << grid.shear_rad() * 180 / M_PI << " degrees";
  }
  return text.str();
}

/// The image is used as the probe, so the transform between them is the identity.
ImageCalibration without_step(const ImageCalibration& calibration) {
  return {{Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()}, calibration.grid};
}

}  // namespace

struct RecordingReader::State {
  State(SequenceReader r, Chains c, Diagnostics& d)
      : reader(std::move(r)), chains(std::move(c)), diagnostics(d) {}

  /// Pose of a frame; NaN, with the reason reported, when it is unreadable.
  RawPose pose(const Chain& chain, const SequenceFrame& frame, Timestamp time) const {
    RawPose out;
    out.acquired = time;
    out.received = time;
    out.status = TrackingStatus::kInvalid;
    const auto value = chain.evaluate(frame);
    if (!value) {
      diagnostics.report(Severity::kWarning, "recording", value.error().message);
      return out;
    }
    out.status = value->status;
    out.tracker_from_body = value->to_from_from;
    if (&chain == &chains.probe && chains.form == RecordingForm::kImageInReference) {
      take_scale_out(frame.index, out);
    }
    return out;
  }

  /// Removes the pixel grid: ImageToReference maps pixels; the rest is rigid.
  void take_scale_out(std::int64_t index, RawPose& pose) const {
    const Eigen::Matrix4d m = pose.tracker_from_body;
    pose.tracker_from_body.setConstant(std::nan(""));
    if (!is_claimed(pose.status) || !calibration) return;
    const auto placed = calibration_from_matrix(m, reader.header().width, reader.header().height);
    if (placed && same_grid(placed->grid, calibration->grid)) {
      pose.tracker_from_body = placed->probe_from_image.matrix();
      return;
    }
    pose.status = TrackingStatus::kInvalid;
    const std::string fault =
        placed ? "expected the pixel size of frame " + std::to_string(calibrated_by) + ", " +
                     pixel_text(calibration->grid) + ", found " + pixel_text(placed->grid)
               : placed.error().message;
    diagnostics.report(Severity::kWarning, "recording",
                       "frame " + std::to_string(index) + ": " + fault);
  }

  /// Takes the calibration of the recording, or of the configuration when the frames have none.
  Result<void> calibrate(const TransformTree& tree, const RecordingOptions& options) {
    if (chains.form == RecordingForm::kImageInReference) {
      const auto found = first_calibration(chains.probe, reader);
      if (!found) return found.error();
      calibration = without_step(found->calibration);
      calibrated_by = found->frame;
      return {};
    }
    const auto chain = tree.find(options.image_frame, options.probe_frame);
    if (!chain) return chain.error();
    if (uses_frames(*chain)) {
      auto found = first_calibration(*chain, reader);
      if (!found) return found.error();
      calibration = found->calibration;
      recorded = *chain;
      first = *std::move(found);
      return {};
    }
    const auto value = chain->evaluate(SequenceFrame{});
    if (!value) return value.error();
    const auto found =
        calibration_from_matrix(value->to_from_from, reader.header().width, reader.header().height);
    if (!found) return found.error();
    calibration = *found;
    return {};
  }

  /// Rejects an image without a valid calibration of its own, which cannot be placed on the probe,
  /// whatever its pose, and one whose calibration differs from that of the images before.
  Result<void> check_calibration(const SequenceFrame& frame) {
    auto own = calibration_of(*recorded, frame, reader.header());
    if (!own) return own.error();
    const FirstCalibration found{*std::move(own), frame.index};
    const SequenceHeader& header = reader.header();
    if (auto ok = same_calibration(*recorded, *first, found, header); ok) return ok;
    // One message for all images of the same other calibration.
    if (!other || !same_calibration(*recorded, *other, found, header)) other = found;
    return same_calibration(*recorded, *first, *other, header);
  }

  Result<UltrasoundFrame> image(const SequenceFrame& frame, Timestamp time) {
    if (recorded) {
      if (const auto ok = check_calibration(frame); !ok) return ok.error();
    }
    const GreyScale before = scale;
    auto pixels = brightness_image(reader.header(), frame, scale);
    if (!pixels) return pixels.error();
    say_scale(before, frame.index);
    UltrasoundFrame out;
    out.acquired = time;
    out.received = time;
    out.sequence = static_cast<std::uint64_t>(frame.index);
    out.pixels = std::move(*pixels);
    out.grid = calibration->grid;
    return out;
  }

  /// Warns when the configuration places the images elsewhere than the frames, which are used.
  void warn_of_other_calibration(const PlusConfig& config, const RecordingOptions& options) const {
    constexpr double kTolerance_mm = 0.01;
    if (!recorded || !calibration) return;
    const auto* configured = config.find(options.image_frame, options.probe_frame);
    if (configured == nullptr) return;
    const SequenceHeader& header = reader.header();
    const auto placed =
        calibration_from_matrix(configured->to_from_from, header.width, header.height);
    if (!placed) return;
    double apart_mm = 0;
    for (const double column : {0.0, header.width - 1.0}) {
      for (const double row : {0.0, header.height - 1.0}) {
        const auto at = [&](const ImageCalibration& one) {
          return one.probe_from_image * one.grid.at(column, row);
        };
        apart_mm = std::max(apart_mm, (at(*placed) - at(*calibration)).v.norm());
      }
    }
    if (!(apart_mm > kTolerance_mm)) return;
    std::ostringstream text;
    text << config.path.string() << ": pixels of " << pixel_text(placed->grid) << ", corners up to "
         << apart_mm << " mm apart";
    diagnostics.report(
        "recording",
        {.subject = header.path.string(),
         .key = options.image_frame + "To" + options.probe_frame,
         .values = {"the frames: pixels of " + pixel_text(calibration->grid), text.str()},
         .used = "that of the frames"});
  }

  /// Warns of calibrations that no probe has: the identity of an uncalibrated one, and metres.
  void warn_of_placeholder(const RecordingOptions& options) const {
    constexpr double kSmallest_mm = 0.01;
    if (!calibration || chains.form == RecordingForm::kImageInReference) return;
    const auto doubt = [&](const std::string& value) {
      diagnostics.report("recording", {.subject = reader.header().path.string(),
                                       .key = options.image_frame + "To" + options.probe_frame,
                                       .values = {value},
                                       .used = "as stated"});
    };
    const PixelGrid& grid = calibration->grid;
    const Eigen::Vector3d corner = (calibration->probe_from_image * grid.at(0, 0)).mm;
    const bool unit = grid.mm_per_pixel.isApprox(Eigen::Matrix2d::Identity(), 1e-9);
    const bool unturned =
        calibration->probe_from_image.rotation().isApprox(Eigen::Quaterniond::Identity(), 1e-9);
    if (unit && unturned && corner.norm() < 1e-9) {
      doubt("the identity (is the probe calibrated?)");
    } else if (grid.mm_per_pixel.colwise().norm().maxCoeff() < kSmallest_mm) {
      doubt("pixels of " + pixel_text(grid) + " (is the calibration in metres?)");
    }
  }

  void report_header() const {
    for (const Finding& finding : reader.header().findings) {
      diagnostics.report("recording", finding);
    }
  }

  /// Reports a frame whose direct transform from the probe to the reference contradicts the way
  /// over the tracker.
  void check_direct(const SequenceFrame& frame, const RecordingFrame& event) const {
    constexpr double kTolerance_mm = 1;
    if (!direct || !event.reference) return;
    const auto stated = direct->evaluate(frame);
    const bool claimed = stated && is_claimed(stated->status) && is_claimed(event.probe.status) &&
                         is_claimed(event.reference->status);
    if (!claimed) return;
    const Eigen::Matrix4d over =
        event.reference->tracker_from_body.inverse() * event.probe.tracker_from_body;
    const double apart_mm = (over - stated->to_from_from).topRightCorner<3, 1>().norm();
    if (!(apart_mm > kTolerance_mm)) return;
    std::ostringstream text;
    text << direct->links.front().name << ", which places the probe " << apart_mm
         << " mm away in frame " << frame.index;
    const std::string over_tracker =
        chains.probe.links.back().name + " and " + chains.reference->links.back().name;
    diagnostics.report("recording", {.subject = reader.header().path.string(),
                                     .key = "position of the probe",
                                     .values = {over_tracker, text.str()},
                                     .used = over_tracker});
  }

  /// Warns of a needle whose tracked body lies ahead of its tip.
  void warn_of_needle() {
    constexpr double kAhead_mm = 5;
    if (!chains.needle || chains.needle->links.size() < 2) return;
    Chain on_body = *chains.needle;
    on_body.links.pop_back();
    for (std::int64_t i = 0; i < reader.header().frame_count; ++i) {
      const auto frame = reader.frame_fields(i);
      const auto body_from_tip =
          frame ? on_body.evaluate(*frame) : Result<NamedTransform>(frame.error());
      if (!body_from_tip || !is_claimed(body_from_tip->status)) continue;
      const double ahead_mm = body_from_tip->to_from_from.inverse()(2, 3);
      if (!(ahead_mm > kAhead_mm)) return;
      std::ostringstream text;
      text << "the tracked body " << ahead_mm
           << " mm ahead of the tip (expected +z from the hub to the tip)";
      diagnostics.report("recording", {.subject = reader.header().path.string(),
                                       .key = "direction of " + chains.needle->from,
                                       .values = {text.str()},
                                       .used = "+z of the tip as the direction of the needle"});
      return;
    }
  }

  /// Says what the conversion to 8-bit grey changes, when it begins to.
  void say_scale(const GreyScale& before, std::int64_t frame) {
    const std::string where =
        reader.header().path.string() + ": frame " + std::to_string(frame) + ": ";
    if (scale.white != before.white) {
      diagnostics.report(Severity::kInfo, "recording",
                         where + "samples of 16 bits: 0 to " + std::to_string(scale.white) +
                             " are drawn from black to white");
    }
    if (scale.largest > scale.white && before.largest <= before.white) {
      diagnostics.report(Severity::kWarning, "recording",
                         where + "expected samples up to " + std::to_string(scale.white) +
                             ", as in the first image, found " + std::to_string(scale.largest) +
                             ": larger ones are drawn white");
    }
    if (scale.colour && !before.colour) {
      diagnostics.report(Severity::kWarning, "recording",
                         where + "the image has colours, which are drawn as grey");
    }
  }

  SequenceReader reader;
  Chains chains;
  Diagnostics& diagnostics;
  std::optional<ImageCalibration> calibration;
  std::int64_t calibrated_by = 0;         ///< Frame of the calibration in kImageInReference.
  std::optional<Chain> recorded;          ///< Image to Probe, when it is in the frames.
  std::optional<FirstCalibration> first;  ///< The calibration in the frames, with recorded.
  std::optional<FirstCalibration> other;  ///< The newest that differs from it.
  std::optional<Chain> direct;            ///< Probe to reference, stated beside the chains.
  std::string description;
  std::string reference_frame;
  std::int64_t position = 0;
  GreyScale scale;
};

RecordingReader::RecordingReader(std::unique_ptr<State> state) : state_(std::move(state)) {}
RecordingReader::RecordingReader(RecordingReader&&) noexcept = default;
RecordingReader& RecordingReader::operator=(RecordingReader&&) noexcept = default;
RecordingReader::~RecordingReader() = default;

Result<RecordingReader> RecordingReader::open(const std::filesystem::path& sequence,
                                              const PlusConfig* config,
                                              const RecordingOptions& options,
                                              Diagnostics& diagnostics) {
  auto reader = SequenceReader::open(sequence);
  if (!reader) return reader.error();
  const auto blame = [&](const Error& error) {
    return Error{error.code, sequence.string() + ": " + error.message};
  };
  // The names of all frames: the first frames may lack some that later frames have.
  std::set<std::string> names;
  std::optional<Error> unreadable;
  for (std::int64_t i = 0; i < reader->header().frame_count; ++i) {
    const auto frame = reader->frame_fields(i);
    // The error is reported when the frame itself is replayed, unless no other frame is readable.
    if (!frame) {
      unreadable = unreadable.value_or(frame.error());
      continue;
    }
    for (auto& name : transform_names(*frame)) names.insert(std::move(name));
  }
  if (names.empty() && unreadable) return *unreadable;
  const auto tree = TransformTree::create(
      {names.begin(), names.end()},
      config != nullptr ? config->transforms : std::vector<CoordinateDefinition>{});
  if (!tree) return blame(tree.error());
  RecordingOptions chosen = options;
  const bool choose = options.reference_frame.empty();
  if (choose) chosen.reference_frame = "Reference";
  auto chains = choose_chains(*tree, chosen);
  if (!chains && choose && chains.error().code == ErrorCode::kNotFound) {
    chosen.reference_frame = options.tracker_frame;
    chains = choose_chains(*tree, chosen);
  }
  if (!chains) return blame(chains.error());
  if (const auto ok = choose_needle(*tree, chosen, *chains); !ok) return blame(ok.error());
  auto state = std::make_unique<State>(std::move(*reader), std::move(*chains), diagnostics);
  if (state->reader.header().width > 0) {
    if (const auto ok = state->calibrate(*tree, chosen); !ok) return blame(ok.error());
  }
  if (config != nullptr) state->warn_of_other_calibration(*config, chosen);
  state->warn_of_placeholder(chosen);
  state->report_header();
  state->warn_of_needle();
  if (const auto fields = state->reader.frame_fields(0); fields && !chosen.needle_frame.empty()) {
    if (auto tip = other_tip(*tree, chosen.needle_frame, *fields)) {
      diagnostics.report("recording", *std::move(tip));
    }
  }
  state->direct = contradicting_chain(*tree, state->chains, chosen);
  state->reference_frame = chosen.reference_frame;
  state->description = describe(state->chains.probe);
  if (state->chains.reference) state->description += "; " + describe(*state->chains.reference);
  if (state->chains.needle) state->description += "; " + describe(*state->chains.needle);
  return RecordingReader(std::move(state));
}

Result<RecordingFrame> RecordingReader::next() {
  State& s = *state_;
  if (s.position >= total_frames()) {
    return Error{ErrorCode::kEndOfStream, s.reader.header().path.string() + ": no more frames"};
  }
  const std::int64_t index = s.position++;
  auto frame = s.reader.read(index);
  if (!frame && frame.error().code != ErrorCode::kMalformedData) return frame.error();
  // Poses and stamp are in the header: they hold also if the pixels cannot be read.
  std::optional<Error> unreadable;
  if (!frame) {
    unreadable = frame.error();
    if (auto fields = s.reader.frame_fields(index)) frame = *std::move(fields);
  }
  const auto reject = [&](const Error& error) {
    RecordingFrame event{.index = index, .image = error};
    event.probe.status = TrackingStatus::kInvalid;
    if (s.chains.reference) event.reference = event.probe;
    if (s.chains.needle) event.needle = event.probe;
    return event;
  };
  if (!frame) return reject(frame.error());
  if (!frame->timestamp_s || !is_representable_seconds(*frame->timestamp_s)) {
    return reject({ErrorCode::kMalformedData,
                   "frame " + std::to_string(index) + ": expected a Timestamp, found none usable"});
  }
  const Timestamp time(from_seconds(*frame->timestamp_s));
  RecordingFrame event{
      .index = index,
      .acquired = time,
      .image = unreadable ? Result<UltrasoundFrame>(*std::move(unreadable)) : s.image(*frame, time),
      .probe = s.pose(s.chains.probe, *frame, time)};
  if (s.chains.reference) event.reference = s.pose(*s.chains.reference, *frame, time);
  if (s.chains.needle) event.needle = s.pose(*s.chains.needle, *frame, time);
  s.check_direct(*frame, event);
  return event;
}

void RecordingReader::rewind() {
  state_->position = 0;
  state_->other.reset();
}
const std::optional<ImageCalibration>& RecordingReader::calibration() const {
  return state_->calibration;
}
RecordingForm RecordingReader::form() const { return state_->chains.form; }
const std::string& RecordingReader::reference_frame() const { return state_->reference_frame; }
std::int64_t RecordingReader::total_frames() const { return state_->reader.header().frame_count; }
const std::string& RecordingReader::description() const { return state_->description; }

}  // namespace nav::io
