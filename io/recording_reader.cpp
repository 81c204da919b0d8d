// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/recording_reader.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "io/recorded_calibration.hpp"
#include "io/sequence.hpp"
#include "io/transform_loops.hpp"

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

bool same_grid(const PixelGrid& a, const PixelGrid& b) {
  const double scale = b.mm_per_pixel.cwiseAbs().maxCoeff();
  return (a.mm_per_pixel - b.mm_per_pixel).cwiseAbs().maxCoeff() <= kGridTolerance * scale;
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
  RawPose pose(const Chain& chain, const SequenceImage& frame, Timestamp time) const {
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
    calibrating = *chain;
    if (uses_frames(*chain)) {
      auto found = first_calibration(*chain, reader);
      if (!found) return found.error();
      calibration = found->calibration;
      recorded = *chain;
      first = *std::move(found);
      return {};
    }
    const auto value = chain->evaluate(SequenceImage{});
    if (!value) return value.error();
    const auto found =
        calibration_from_matrix(value->to_from_from, reader.header().width, reader.header().height);
    if (!found) return found.error();
    calibration = *found;
    return {};
  }

  /// Rejects an image without a valid calibration of its own, which cannot be placed on the probe,
  /// whatever its pose, and one whose calibration differs from that of the images before.
  Result<void> check_calibration(const SequenceImage& frame) {
    auto own = calibration_of(*recorded, frame, reader.header());
    if (!own) return own.error();
    const FirstCalibration found{*std::move(own), frame.index};
    const SequenceHeader& header = reader.header();
    if (auto ok = same_calibration(*recorded, *first, found, header); ok) return ok;
    // One message for all images of the same other calibration.
    if (!other || !same_calibration(*recorded, *other, found, header)) other = found;
    return same_calibration(*recorded, *first, *other, header);
  }

  Result<UltrasoundImage> image(const SequenceImage& frame, Timestamp time) {
    if (recorded) {
      if (const auto ok = check_calibration(frame); !ok) return ok.error();
    }
    const GreyScale before = scale;
    auto pixels = sequence_image(reader.header(), frame, scale);
    if (!pixels) return pixels.error();
    say_scale(before, frame.index);
    UltrasoundImage out;
    out.acquired = time;
    out.received = time;
    out.sequence = static_cast<std::uint64_t>(frame.index);
    out.pixels = std::move(pixels->pixels);
    out.colours = std::move(pixels->colours);
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

  /// Warns of calibrations that no probe has, see placeholder_calibration().
  void warn_of_placeholder(const RecordingOptions& options) {
    if (!calibration || chains.form == RecordingForm::kImageInReference) return;
    auto finding = placeholder_calibration(*calibration);
    if (!finding) return;
    finding->subject = reader.header().path.string();
    finding->key = options.image_frame + "To" + options.probe_frame;
    finding->used = "as stated, as degraded";
    calibration_doubt = finding->key + ": " + finding->values.at(0);
    diagnostics.report("recording", *std::move(finding));
  }

  /// Names of the transforms that place images, patient and needle.
  [[nodiscard]] std::set<std::string> used() const {
    std::set<std::string> names;
    const auto add = [&](const std::optional<Chain>& chain) {
      if (!chain) return;
      for (const ChainLink& link : chain->links) names.insert(link.name);
    };
    add(chains.probe);
    add(chains.reference);
    add(chains.needle);
    add(calibrating);
    return names;
  }

  void report_header() const {
    for (const Finding& finding : reader.header().findings) {
      diagnostics.report("recording", finding);
    }
  }

  /// Reports a frame whose transforms contradict each other, and one whose needle has another tip
  /// than the first.
  void check_transforms(const SequenceImage& frame) {
    for (const Finding& finding : loops->findings(frame)) diagnostics.report("recording", finding);
    if (!tip || !first_tip) return;
    const auto found = tip->evaluate(frame);
    if (!found || !is_claimed(found->status)) return;
    constexpr double kSameMm = 0.1;
    constexpr double kSameTurn = 2e-3;
    const Eigen::Matrix4d change = (found->to_from_from - first_tip->tip).cwiseAbs();
    const double mm = (found->to_from_from - first_tip->tip).topRightCorner<3, 1>().norm();
    if (mm <= kSameMm && change.topLeftCorner<3, 3>().maxCoeff() <= kSameTurn) return;
    std::ostringstream text;
    text << "another in frame " << frame.index << ", " << mm << " mm away";
    diagnostics.report("recording",
                       {.subject = reader.header().path.string(),
                        .key = "position of " + tip->from + " on " + tip->to,
                        .values = {"that of frame " + std::to_string(first_tip->frame), text.str()},
                        .used = "that of each frame (a needle has one tip)"});
  }

  /// The part of the needle's chain that lies on the tracked body; absent: the needle is the body.
  /// \p moving: frames in which the body moves.
  void find_tip(const std::set<std::string>& moving) {
    Chain on_body = *chains.needle;
    std::vector<ChainLink> links;
    std::string at = on_body.from;
    for (const ChainLink& link : on_body.links) {
      const auto ends = split_transform_name(link.name);
      const std::string next = !ends ? "" : link.inverted ? ends->first : ends->second;
      if (next.empty() || moving.contains(next)) break;
      links.push_back(link);
      at = next;
    }
    if (links.empty()) return;
    tip = Chain{on_body.from, at, std::move(links)};
    for (std::int64_t i = 0; i < reader.header().frame_count; ++i) {
      const auto frame = reader.frame_fields(i);
      if (!frame) continue;
      const auto found = tip->evaluate(*frame);
      if (!found || !is_claimed(found->status)) continue;
      first_tip = FirstTip{found->to_from_from, i};
      break;
    }
    if (!first_tip) return;
    if (auto unit = tip_of_another_unit(first_tip->tip, tip->from + " on " + tip->to)) {
      diagnostics.report("recording", *std::move(unit));
    }
  }

  /// Warns of a needle whose tracked body lies ahead of its tip.
  void warn_of_needle() {
    constexpr double kAhead_mm = 5;
    if (!first_tip) return;
    const double ahead_mm = first_tip->tip.inverse()(2, 3);
    if (!(ahead_mm > kAhead_mm)) return;
    std::ostringstream text;
    text << "the tracked body " << ahead_mm
         << " mm ahead of the tip (expected +z from the hub to the tip)";
    diagnostics.report("recording", {.subject = reader.header().path.string(),
                                     .key = "direction of " + chains.needle->from,
                                     .values = {text.str()},
                                     .used = "+z of the tip as the direction of the needle"});
  }

  /// Says how 16-bit samples become 8 bits, when it is decided and when they exceed it.
  void say_scale(const GreyScale& before, std::int64_t frame) {
    const std::string path = reader.header().path.string();
    const std::string in_frame = "frame " + std::to_string(frame);
    if (scale.white != before.white) {
      const std::string found = scale.of_header
                                    ? "ElementMax " + reader.header().fields.at("ElementMax")
                                    : "up to " + std::to_string(scale.largest) + " in " + in_frame;
      diagnostics.report("recording", {.subject = path,
                                       .key = "samples of 16 bits",
                                       .values = {found},
                                       .used = "0 to " + std::to_string(scale.white) +
                                               " as 0 to 255, in all images"});
    }
    if (scale.largest > scale.white && before.largest <= before.white) {
      diagnostics.report(Severity::kWarning, "recording",
                         path + ": " + in_frame + ": expected samples up to " +
                             std::to_string(scale.white) + ", found " +
                             std::to_string(scale.largest) + ": larger ones are drawn white");
    }
  }

  SequenceReader reader;
  Chains chains;
  Diagnostics& diagnostics;
  std::optional<ImageCalibration> calibration;
  std::string calibration_doubt;
  std::int64_t calibrated_by = 0;         ///< Frame of the calibration in kImageInReference.
  std::optional<Chain> calibrating;       ///< Image to Probe.
  std::optional<Chain> recorded;          ///< Image to Probe, when it is in the frames.
  std::optional<FirstCalibration> first;  ///< The calibration in the frames, with recorded.
  std::optional<FirstCalibration> other;  ///< The newest that differs from it.
  std::optional<TransformLoops> loops;
  struct FirstTip {
    Eigen::Matrix4d tip;
    std::int64_t frame;
  };
  std::optional<Chain> tip;           ///< Tip of the needle to its tracked body.
  std::optional<FirstTip> first_tip;  ///< The first that is valid, with tip.
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
  // With a configuration either of the two files may lack a transform.
  const auto blame_both = [&](const Error& error) {
    const std::string with = config != nullptr ? " with " + config->path.string() : "";
    return Error{error.code, sequence.string() + with + ": " + error.message};
  };
  if (config != nullptr) {
    const auto alone = TransformTree::create({}, config->transforms);
    if (!alone) {
      return Error{alone.error().code, config->path.string() + ": " + alone.error().message};
    }
  }
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
  if (!chains) return blame_both(chains.error());
  if (const auto ok = choose_needle(*tree, chosen, *chains); !ok) return blame_both(ok.error());
  auto state = std::make_unique<State>(std::move(*reader), std::move(*chains), diagnostics);
  if (state->reader.header().width > 0) {
    if (const auto ok = state->calibrate(*tree, chosen); !ok) return blame_both(ok.error());
  }
  if (config != nullptr) state->warn_of_other_calibration(*config, chosen);
  state->warn_of_placeholder(chosen);
  state->report_header();
  if (state->chains.needle) {
    state->find_tip({chosen.tracker_frame, chosen.reference_frame, chosen.probe_frame});
    state->warn_of_needle();
  }
  if (const auto fields = state->reader.frame_fields(0); fields && !chosen.needle_frame.empty()) {
    if (auto tip = other_tip(*tree, chosen.needle_frame, *fields)) {
      diagnostics.report("recording", *std::move(tip));
    }
  }
  state->loops.emplace(*tree, state->used(), chosen.image_frame, chosen.probe_frame,
                       state->reader.header().width, state->reader.header().height,
                       sequence.string());
  state->reference_frame = chosen.reference_frame;
  if (state->calibrating) state->description = describe(*state->calibrating) + "; ";
  state->description += describe(state->chains.probe);
  if (state->chains.reference) state->description += "; " + describe(*state->chains.reference);
  if (state->chains.needle) state->description += "; " + describe(*state->chains.needle);
  return RecordingReader(std::move(state));
}

Result<RecordingImage> RecordingReader::next() {
  State& s = *state_;
  if (s.position >= total_images()) {
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
    RecordingImage event{.index = index, .image = error};
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
  RecordingImage event{
      .index = index,
      .acquired = time,
      .image = unreadable ? Result<UltrasoundImage>(*std::move(unreadable)) : s.image(*frame, time),
      .probe = s.pose(s.chains.probe, *frame, time)};
  if (s.chains.reference) event.reference = s.pose(*s.chains.reference, *frame, time);
  if (s.chains.needle) event.needle = s.pose(*s.chains.needle, *frame, time);
  s.check_transforms(*frame);
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
std::int64_t RecordingReader::total_images() const { return state_->reader.header().frame_count; }
const std::string& RecordingReader::calibration_doubt() const { return state_->calibration_doubt; }
const std::string& RecordingReader::description() const { return state_->description; }

}  // namespace nav::io
