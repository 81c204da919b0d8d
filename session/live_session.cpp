// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/live_session.hpp"

#include <algorithm>
#include <utility>

#include "io/plus_config.hpp"
#include "io/sequence.hpp"
#include "io/transform_tree.hpp"

namespace nav::session {
namespace {

bool gives(const LiveDevice& device, StreamKind kind, ToolRole role) {
  return std::ranges::any_of(device.source->streams(), [&](const StreamInfo& stream) {
    return stream.kind == kind && (kind == StreamKind::kImages || stream.role == role);
  });
}

const LiveDevice* first_that_gives(const std::vector<LiveDevice>& devices, StreamKind kind,
                                   ToolRole role = ToolRole::kOther) {
  for (const LiveDevice& device : devices) {
    if (gives(device, kind, role)) return &device;
  }
  return nullptr;
}

/// Transforms of the first frame of a PLUS sequence that do not lead to the tracker or the patient:
/// its calibrations.
Result<std::vector<io::CoordinateDefinition>> recorded_calibrations(const SourceOptions& options) {
  auto reader = io::SequenceReader::open(options.plus_config);
  if (!reader) return reader.error();
  const auto frame = reader->frame_fields(0);
  if (!frame) return frame.error();
  std::vector<io::CoordinateDefinition> found;
  for (const std::string& name : io::transform_names(*frame)) {
    const auto frames = io::split_transform_name(name);
    if (!frames || frames->second == options.tracker_frame || frames->second == "Reference") {
      continue;
    }
    const auto value = io::transform(*frame, name);
    if (!value) return value.error();
    found.push_back(
        {.from = frames->first, .to = frames->second, .to_from_from = value->to_from_from});
  }
  return found;
}

/// Calibrations of a configuration of PLUS, or of a sequence; absent without either.
Result<std::optional<io::TransformTree>> calibrations_of(const SourceOptions& options) {
  if (options.plus_config.empty()) return std::optional<io::TransformTree>();
  std::vector<io::CoordinateDefinition> definitions;
  const auto extension = options.plus_config.extension();
  if (extension == ".mha" || extension == ".mhd" || extension == ".nrrd") {
    auto recorded = recorded_calibrations(options);
    if (!recorded) return recorded.error();
    definitions = *std::move(recorded);
  } else {
    auto plus = io::read_plus_config(options.plus_config);
    if (!plus) return plus.error();
    definitions = std::move(plus->transforms);
  }
  auto tree = io::TransformTree::create({}, definitions);
  if (!tree) {
    return Error{tree.error().code, options.plus_config.string() + ": " + tree.error().message};
  }
  return std::optional(*std::move(tree));
}

Result<Eigen::Matrix4d> matrix_between(const io::TransformTree& tree, const std::string& from,
                                       const std::string& to) {
  const auto chain = tree.find(from, to);
  if (!chain) return chain.error();
  const auto found = chain->evaluate({});
  if (!found) return found.error();
  return found->to_from_from;
}

/// ImageToProbe of the calibrations, if it can place an image.
Result<Eigen::Matrix4d> pixels_of(const io::TransformTree& tree, const SourceOptions& options) {
  const auto named = [&](const Error& error) {
    return Error{error.code, options.plus_config.string() + ": " + error.message};
  };
  const auto matrix = matrix_between(tree, options.image_frame, options.probe_frame);
  if (!matrix) return named(matrix.error());
  constexpr int kAnySize = 512;
  const auto calibration = io::calibration_from_matrix(*matrix, kAnySize, kAnySize);
  if (!calibration) return named(calibration.error());
  return *matrix;
}

/// Finds which body of the devices carries the needle: the one of that name, or one that the
/// configuration says where the tip lies on.
Result<void> find_needle(const SourceOptions& options, const std::optional<io::TransformTree>& tree,
                         const std::vector<DeviceOptions>& devices, std::string& needle_body,
                         std::optional<Eigen::Matrix4d>& body_from_tip) {
  std::string bodies;
  for (const DeviceOptions& device : devices) {
    for (const DeviceBody& body : device.bodies) {
      bodies.append(bodies.empty() ? "" : ", ").append(body.name);
      if (body.name != options.needle_frame) continue;
      needle_body = body.name;
      return {};
    }
  }
  for (const DeviceOptions& device : devices) {
    for (const DeviceBody& body : device.bodies) {
      if (!tree) continue;
      const auto found = matrix_between(*tree, options.needle_frame, body.name);
      if (!found) continue;
      needle_body = body.name;
      body_from_tip = *found;
      return {};
    }
  }
  return Error{ErrorCode::kUsage,
               "source.needle_frame: expected a tracked body, or a tip that the calibration places "
               "on one, found '" +
                   options.needle_frame + "' and the bodies " + (bodies.empty() ? "none" : bodies)};
}

}  // namespace

Result<Eigen::Matrix4d> probe_from_pixels(const SourceOptions& options) {
  const auto tree = calibrations_of(options);
  if (!tree) return tree.error();
  NAV_CHECK(tree->has_value(), "a configuration");
  return pixels_of(**tree, options);
}

Result<LiveSession> LiveSession::open(
    const SourceOptions& options, const Clock& clock, Diagnostics& diagnostics,
    std::function<void(std::size_t source, const Sample& sample)> tap, bool any_devices) {
  if (options.devices.empty()) {
    return Error{ErrorCode::kUsage, "devices: expected at least one device, found none"};
  }
  if (const auto ok = validate(options.devices); !ok) return ok.error();
  const auto tree = calibrations_of(options);
  if (!tree) return tree.error();
  LiveSession live;
  live.clock_ = &clock;
  SessionSetup setup;
  setup.tap = std::move(tap);
  setup.queue_capacity = 8192;  // Two seconds of ten bodies at 400 Hz.
  setup.learn_outline = !options.whole_image;
  setup.navigator.frame_period.reset();
  setup.navigator.needle_period.reset();
  setup.navigator.pairing.temporal_offset = from_seconds(options.temporal_offset_ms * 1e-3);

  std::string needle_body;
  const bool by_frames = std::ranges::any_of(
      options.devices, [](const DeviceOptions& device) { return !device.bodies.empty(); });
  const bool recorded = std::ranges::any_of(
      options.devices, [](const DeviceOptions& device) { return device.kind == "recording"; });
  if (!options.needle_frame.empty() && !by_frames && !recorded) {
    return Error{ErrorCode::kUsage, "source.needle_frame: expected a device with bodies, found '" +
                                        options.needle_frame +
                                        "' and none (a simulated device has needle = true)"};
  }
  if (!options.needle_frame.empty() && by_frames) {
    if (auto ok = find_needle(options, *tree, options.devices, needle_body, setup.body_from_tip);
        !ok) {
      return ok.error();
    }
    if (auto tip = *tree ? io::other_tip(**tree, options.needle_frame, {}) : std::nullopt) {
      diagnostics.report("session", *std::move(tip));
    }
  }
  for (const DeviceOptions& device : options.devices) {
    auto opened = open_device(device, needle_body, options, clock, diagnostics);
    if (!opened) return opened.error();
    live.devices_.push_back(*std::move(opened));
  }
  const LiveDevice* images = first_that_gives(live.devices_, StreamKind::kImages);
  const bool probe =
      first_that_gives(live.devices_, StreamKind::kPoses, ToolRole::kProbe) != nullptr;
  if (images == nullptr || !probe) {
    const std::string lack =
        images == nullptr
            ? "devices: expected one that gives ultrasound images (image = \"…\"), found none"
            : "devices: expected one that tracks the probe (a body '" + options.probe_frame +
                  "'), found none";
    if (!any_devices) return Error{ErrorCode::kUsage, lack};
    diagnostics.report(Severity::kWarning, "session", lack + ": no ultrasound plane can be shown");
  }
  if (images != nullptr && images->calibration) {
    setup.calibration = images->calibration;
    live.calibration_statement_ = images->options.id + " knows where its images lie on the probe";
  } else if (images != nullptr && *tree) {
    const auto matrix = pixels_of(**tree, options);
    if (!matrix) return matrix.error();
    setup.probe_from_pixels = *matrix;
    live.calibration_statement_ =
        options.image_frame + "To" + options.probe_frame + " of " + options.plus_config.string();
  } else if (images != nullptr) {
    const std::string lack = "source.calibration: expected a PLUS configuration with " +
                             options.image_frame + "To" + options.probe_frame + ", because " +
                             images->options.id +
                             " does not say where its images lie on the probe; found none";
    if (!any_devices) return Error{ErrorCode::kUsage, lack};
    diagnostics.report(Severity::kWarning, "session", lack);
  }
  if (const LiveDevice* needle =
          first_that_gives(live.devices_, StreamKind::kPoses, ToolRole::kNeedle);
      needle != nullptr && needle->body_from_tip) {
    setup.body_from_tip = needle->body_from_tip;
  }
  if (setup.body_from_tip && setup.body_from_tip->inverse()(2, 3) > 5) {
    diagnostics.report(Severity::kWarning, "session",
                       options.needle_frame +
                           ": expected +z from the hub to the tip, found the tracked body ahead of "
                           "the tip: the needle is drawn on the wrong side");
  }
  const LiveDevice* patient =
      first_that_gives(live.devices_, StreamKind::kPoses, ToolRole::kReference);
  if (patient != nullptr && patient->tracks_patient) {
    live.reference_frame_ = options.reference_frame.empty() ? "Reference" : options.reference_frame;
    live.reference_statement_ = live.reference_frame_ + " is the patient's frame";
  } else {
    live.reference_frame_ = options.tracker_frame;
    live.reference_statement_ = "nothing tracks the patient: the tracker itself (" +
                                options.tracker_frame + ") is taken as the patient's frame";
    diagnostics.report(Severity::kWarning, "session", live.reference_statement_);
    setup.fixed_reference.emplace(Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero());
  }
  live.setup_ = setup;
  live.session_ = std::make_unique<Session>(setup, diagnostics);
  for (const LiveDevice& device : live.devices_) live.session_->add(device.source);
  return live;
}

std::vector<DeviceStatus> LiveSession::status() const {
  std::vector<DeviceStatus> all;
  const std::vector<StreamAccount> accounts = session_->accounts();
  std::size_t stream = 0;
  for (const LiveDevice& device : devices_) {
    DeviceStatus one{.id = device.options.id,
                     .kind = device.options.kind,
                     .address = device.options.address,
                     .health = device.source->health(),
                     .streams = {}};
    for (std::size_t i = 0; i < device.source->streams().size(); ++i, ++stream) {
      one.streams.push_back({accounts[stream], session_->clock(stream)});
    }
    all.push_back(std::move(one));
  }
  return all;
}

}  // namespace nav::session
