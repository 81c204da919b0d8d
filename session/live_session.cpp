// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/live_session.hpp"

#include <algorithm>
#include <utility>

#include "io/transform_tree.hpp"
#include "session/calibration_file.hpp"
#include "session/live_cameras.hpp"

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

/// Calibrations of a configuration of PLUS, or of a sequence; absent without either.
Result<std::optional<io::TransformTree>> calibrations_of(const SourceOptions& options) {
  if (options.plus_config.empty()) return std::optional<io::TransformTree>();
  const auto calibrations = read_calibrations(options);
  if (!calibrations) return calibrations.error();
  auto tree = io::TransformTree::create({}, calibrations->transforms);
  if (!tree) {
    return Error{tree.error().code, options.plus_config.string() + ": " + tree.error().message};
  }
  return std::optional(*std::move(tree));
}

/// Reports each body, and the images, that several devices give: one of them is used.
void report_several(const std::vector<LiveDevice>& devices, Diagnostics& diagnostics) {
  const auto report = [&](StreamKind kind, ToolRole role, const std::string& key) {
    std::vector<std::string> ids;
    for (const LiveDevice& device : devices) {
      const auto count =
          std::ranges::count_if(device.source->streams(), [&](const StreamInfo& stream) {
            return stream.kind == kind && (kind == StreamKind::kImages || stream.role == role);
          });
      ids.insert(ids.end(), static_cast<std::size_t>(count), device.options.id);
    }
    if (ids.size() < 2) return;
    const std::string used = ids.front();
    diagnostics.report("session", {.subject = "devices",
                                   .key = "source of " + key,
                                   .values = std::move(ids),
                                   .used = used + "; what the others give of it is not used"});
  };
  for (const ToolRole role : {ToolRole::kProbe, ToolRole::kReference, ToolRole::kNeedle}) {
    report(StreamKind::kPoses, role, std::string("the poses of ") + to_string(role));
  }
  report(StreamKind::kImages, ToolRole::kOther, "the images");
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
  report_several(live.devices_, diagnostics);
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
    diagnostics.report(
        "session",
        {.subject = "needle",
         .key = "direction of " + options.needle_frame,
         .values = {"the tracked body ahead of the tip (expected +z from the hub to the tip)"},
         .used = "+z of the tip as the direction of the needle"});
  }
  if (setup.body_from_tip) {
    auto unit = io::tip_of_another_unit(*setup.body_from_tip, "the tip on its body");
    if (unit) diagnostics.report("session", *std::move(unit));
  }
  if (images != nullptr) setup.image_watch = screen_watch_of(images->options);
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
