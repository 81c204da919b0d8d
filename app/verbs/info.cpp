// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/info.hpp"

#include <algorithm>
#include <cctype>
#include <iostream>

#include "app/report.hpp"
#include "app/verbs/describe_shapes.hpp"
#include "io/config_findings.hpp"
#include "io/ct.hpp"
#include "io/markups.hpp"
#include "io/mcap/device_recording.hpp"
#include "io/plus_config.hpp"
#include "io/sequence.hpp"
#include "io/transform_file.hpp"
#include "nav/hounsfield.hpp"
#include "render/transfer/transfer_presets.hpp"
#include "session/recorded_session.hpp"

namespace nav::app {
namespace {

/// Counts transforms by status and reads the times of a whole sequence.
Result<void> describe_frames(io::SequenceReader& reader, io::Json& json) {
  io::Json transforms = io::Json::object();
  std::optional<double> first;
  std::optional<double> last;
  std::int64_t without_time = 0;
  std::int64_t without_image = 0;
  for (std::int64_t i = 0; i < reader.header().frame_count; ++i) {
    const auto frame = reader.frame_fields(i);
    if (!frame) return frame.error();
    if (!frame->image_valid) ++without_image;
    if (frame->timestamp_s) {
      first = first.value_or(*frame->timestamp_s);
      last = frame->timestamp_s;
    } else {
      ++without_time;
    }
    for (const std::string& name : io::transform_names(*frame)) {
      const auto transform = io::transform(*frame, name);
      const std::string status = transform ? to_string(transform->status) : "unreadable";
      io::Json& count = transforms[name][status];
      count = count.is_null() ? 1 : count.get<int>() + 1;
    }
  }
  json["transforms"] = transforms;
  json["frames_without_image"] = without_image;
  json["frames_without_timestamp"] = without_time;
  json["first_timestamp_s"] = first ? io::Json(*first) : io::Json(nullptr);
  json["last_timestamp_s"] = last ? io::Json(*last) : io::Json(nullptr);
  return {};
}

/// The frame of a needle's tip that the transforms name: "NeedleTip" of NeedleTipToNeedle. Empty:
/// none.
std::string needle_tip_of(const io::Json& transforms) {
  for (const auto& [name, counts] : transforms.items()) {
    const auto to = name.find("TipTo");
    const bool of_needle = name.find("Needle") < to;
    if (to != std::string::npos && of_needle) return name.substr(0, to + 3);
  }
  return "";
}

/// True if a finding with that key was reported.
bool is_reported(const Console& console, const std::string& key) {
  return std::ranges::any_of(console.entries(), [&](const DiagnosticEntry& entry) {
    return entry.finding && entry.finding->key == key;
  });
}

/// Plays a recording without drawing it, so that what a replay reports is reported here, too.
Result<void> play_for_reports(const session::SourceOptions& source, Console& console) {
  auto session = session::RecordedSession::open(source, console);
  if (!session) return session.error();
  if (auto played = session->play({}); !played) return played;
  if (auto bad = session::bad_frames_finding(*session)) {
    bad->used = "none, or with --skip-bad-frames the others";
    console.report("recording", *std::move(bad));
  }
  return {};
}

/// Reports what a replay with the usual options would. Poses or a calibration that only options of
/// a replay give are no fault of the file.
Result<void> report_as_replay(const std::filesystem::path& path, const std::string& needle_frame,
                              Console& console) {
  session::SourceOptions source;
  source.recording = path;
  source.needle_frame = needle_frame;
  auto played = play_for_reports(source, console);
  if (!played && played.error().code == ErrorCode::kUsage && !needle_frame.empty()) {
    source.needle_frame.clear();
    played = play_for_reports(source, console);
  }
  if (played) return {};
  const Error& error = played.error();
  if (error.code == ErrorCode::kIo) return error;
  const bool damaged = error.code == ErrorCode::kMalformedData;
  console.report(damaged ? Severity::kWarning : Severity::kInfo, "recording",
                 "cannot be replayed as it is: " + error.message);
  return {};
}

Result<io::Json> describe_sequence(io::SequenceReader& reader, Console& console) {
  const io::SequenceHeader& header = reader.header();
  io::Json json;
  json["kind"] = "sequence";
  json["format"] = header.format;
  json["dimensions"] = header.depth > 1 ? io::Json{header.width, header.height, header.depth}
                                        : io::Json{header.width, header.height};
  // The file has no pixel size: millimetres come from ImageToProbe.
  json["spacing_mm"] = nullptr;
  json["directions"] = nullptr;
  json["frames"] = header.frame_count;
  json["readable_frames"] = header.readable_frames;
  json["components"] = header.components;
  json["pixel_type"] = io::to_string(header.pixel_type);
  json["orientation"] = header.orientation;
  json["image_type"] = header.image_type;
  json["compressed"] = header.compressed;
  if (const auto whole = io::check_complete(reader); !whole) return whole.error();
  if (const auto described = describe_frames(reader, json); !described) return described.error();
  const auto ok = report_as_replay(header.path, needle_tip_of(json["transforms"]), console);
  if (!ok) return ok.error();
  return json;
}

/// Buttons that were pressed in a recording, in order: session time, time since its first sample,
/// and the action.
Result<io::Json> recorded_presses(const io::mcap::DeviceRecording& recording) {
  std::vector<std::pair<Timestamp, io::Json>> presses;
  for (std::size_t i = 0; i < recording.devices().size(); ++i) {
    const auto& device = recording.devices()[i];
    const auto is_button = [](const StreamInfo& info) { return info.kind == StreamKind::kButtons; };
    if (std::ranges::none_of(device.streams, is_button)) continue;
    auto source = recording.source(i);
    if (!source) return source.error();
    for (;;) {
      const auto sample = (*source)->next(Deadline::max());
      if (!sample && sample.error().code == ErrorCode::kEndOfStream) break;
      if (!sample) return sample.error();
      const auto* button = std::get_if<ButtonSample>(&sample->what);
      if (button == nullptr || !button->pressed) continue;
      const Timestamp time = button->acquired;
      const StreamInfo& info = device.streams[sample->stream];
      presses.emplace_back(
          time,
          io::Json{{"time_s", to_seconds(time)},
                   {"since_begin_s", to_seconds(time - recording.first_time().value_or(time))},
                   {"device", device.id},
                   {"button", info.name},
                   {"action", to_string(info.action)}});
    }
  }
  std::ranges::stable_sort(presses, {}, [](const auto& one) { return one.first; });
  io::Json list = io::Json::array();
  for (auto& [time, press] : presses) list.push_back(std::move(press));
  return list;
}

Result<io::Json> describe_devices(const std::filesystem::path& path, Console& console) {
  const auto recording = io::mcap::DeviceRecording::open(path, {.read_all = true});
  if (!recording) return recording.error();
  if (!recording->warnings().empty()) {
    console.report("recording", session::damage_finding(path.string(), recording->warnings()));
  }
  io::Json json;
  json["kind"] = "devices";
  json["format"] = "MCAP";
  json["id"] = recording->id();
  json["finished"] = recording->is_finished();
  json["samples"] = recording->samples();
  json["duration_s"] = to_seconds(recording->duration());
  json["devices"] = io::Json::object();
  for (const auto& device : recording->devices()) {
    io::Json& streams = json["devices"][device.id] = io::Json::object();
    for (std::size_t i = 0; i < device.streams.size(); ++i) {
      const StreamInfo& info = device.streams[i];
      const bool poses = info.kind == StreamKind::kPoses;
      io::Json& stream = streams[info.name];
      stream = {{"type", to_string(info.kind)},
                {"role", poses ? io::Json(to_string(info.role)) : io::Json()},
                {"samples", device.samples[i]}};
      if (info.kind == StreamKind::kButtons) stream["action"] = to_string(info.action);
    }
  }
  const auto buttons = recorded_presses(*recording);
  if (!buttons) return buttons.error();
  json["buttons"] = *buttons;
  json["attachments"] = io::Json::array();
  for (const auto& attachment : recording->attachments()) {
    json["attachments"].push_back(attachment.head.name);
  }
  json["session"] = io::Json::object();
  for (const auto& [key, value] : recording->session()) {
    if (key != "session") json["session"][key] = value;
  }
  for (const auto& metadata : recording->metadata()) json[metadata.name] = metadata.values;
  return json;
}

/// True for a volume in Hounsfield units: by its DICOM attributes, or else by its values, as
/// read_ct() judges them.
bool is_ct(const Volume& volume, const std::filesystem::path& path, const Console& console) {
  if (is_reported(console, "Modality")) return false;
  if (is_hounsfield(volume)) return true;
  std::error_code failed;
  const bool dicom = std::filesystem::is_directory(path, failed) || io::is_dicom(path);
  return !is_reported(console, dicom ? "RescaleType" : "unit of the values");
}

io::Json describe_volume(const Volume& ct, bool hounsfield) {
  const VoxelGrid& grid = ct.grid();
  io::Json json;
  json["kind"] = hounsfield ? "ct" : "volume";
  json["dimensions"] = {grid.size[0], grid.size[1], grid.size[2]};
  json["spacing_mm"] = {grid.spacing_mm.x(), grid.spacing_mm.y(), grid.spacing_mm.z()};
  json["origin_mm"] = {grid.origin_mm.x(), grid.origin_mm.y(), grid.origin_mm.z()};
  io::Json directions = io::Json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) directions.push_back(grid.directions(row, column));
  }
  json["directions"] = directions;
  json["coordinate_system"] = "LPS";
  const auto [low, high] = std::minmax_element(ct.hu().begin(), ct.hu().end());
  json["hu_min"] = hounsfield ? io::Json(*low) : io::Json();
  json["hu_max"] = hounsfield ? io::Json(*high) : io::Json();
  json["value_min"] = *low;
  json["value_max"] = *high;
  const render::ValueRange range = render::value_range(ct);
  json["value_range"] = {range.low, range.high};
  json["frames"] = 1;
  json["transforms"] = io::Json::object();
  json["first_timestamp_s"] = nullptr;
  json["last_timestamp_s"] = nullptr;
  return json;
}

io::Json describe_config(const io::PlusConfig& config) {
  io::Json json;
  json["kind"] = "plus_config";
  json["version"] = config.version;
  json["transforms"] = io::Json::object();
  for (const auto& definition : config.transforms) {
    json["transforms"][definition.from + "To" + definition.to] = json_of(definition.to_from_from);
  }
  json["devices"] = io::Json::array();
  for (const auto& device : config.devices) {
    json["devices"].push_back({{"id", device.id},
                               {"type", device.type},
                               {"local_time_offset_s", device.local_time_offset_s}});
  }
  return json;
}

Result<io::Json> describe_registration(const std::filesystem::path& path, Console& console) {
  const auto registration = session::read_registration(path);
  if (!registration) return registration.error();
  for (const Finding& finding : session::findings_of(*registration, path)) {
    console.report("placement", finding);
  }
  const io::Json& file = registration->json;
  io::Json json;
  json["kind"] = "registration";
  for (const char* key : {"method", "ct", "ct_sha256", "sweep", "reference_frame"}) {
    json[key] = file.value(key, io::Json());
  }
  json["verdict"] = file["registration"].value("verdict", io::Json("accept"));
  json["warnings"] = registration->warnings;
  json["ct_from_reference_mm"] = json_of(registration->ct_from_reference.matrix());
  return json;
}

bool has_extension(const std::filesystem::path& path, std::initializer_list<const char*> endings) {
  std::string name = path.filename().string();
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return std::any_of(endings.begin(), endings.end(),
                     [&](const char* ending) { return name.ends_with(ending); });
}

/// True when a metafile has a frame field or an ultrasound key, so that it is a sequence.
bool is_sequence(io::SequenceReader& reader) {
  const io::SequenceHeader& header = reader.header();
  if (!header.orientation.empty() || !header.image_type.empty()) return true;
  if (header.frame_count < 1) return true;
  const auto frame = reader.frame_fields(0);
  return frame && !frame->fields.empty();
}

Result<io::Json> describe(const std::filesystem::path& path, bool accept_unknown_orientation,
                          Console& console) {
  std::error_code status;
  if (!std::filesystem::exists(path, status)) {
    return Error{ErrorCode::kNotFound,
                 path.string() + ": expected a file or folder, found nothing"};
  }
  if (has_extension(path, {".xml"})) {
    const auto config = io::read_plus_config(path);
    if (!config) return config.error();
    for (const Finding& finding : io::findings_of(*config)) console.report("config", finding);
    return describe_config(*config);
  }
  if (io::is_markups_file(path)) return describe_markups(path, console);
  if (io::is_transform_file(path)) return describe_transform(path, console);
  if (has_extension(path, {".stl", ".ply", ".vtk"})) return describe_surface(path);
  if (has_extension(path, {".csv"})) return describe_landmarks(path);
  if (has_extension(path, {".json"})) return describe_registration(path, console);
  if (session::is_device_recording(path)) return describe_devices(path, console);
  if (has_extension(path, {".mha", ".mhd", ".nrrd", ".nhdr"})) {
    auto reader = io::SequenceReader::open(path);
    if (reader && is_sequence(*reader)) return describe_sequence(*reader, console);
    if (!reader && has_extension(path, {".igs.mha", ".igs.mhd", ".igs.nrrd"})) {
      return reader.error();
    }
  }
  io::CtOptions options;
  options.accept_unknown_orientation = accept_unknown_orientation;
  const auto ct = io::read_ct(path, console, options);
  if (!ct) return ct.error();
  return describe_volume(*ct, is_ct(*ct, path, console));
}

void print(const io::Json& json, const std::string& indent) {
  for (const auto& [key, value] : json.items()) {
    if (value.is_object() && !value.empty()) {
      std::cout << indent << key << '\n';
      print(value, indent + "  ");
    } else {
      std::cout << indent << key << ": "
                << value.dump(-1, ' ', false, io::Json::error_handler_t::replace) << '\n';
    }
  }
}

}  // namespace

Result<void> run_info(const std::filesystem::path& path, const std::optional<std::string>& json,
                      bool accept_unknown_orientation, Console& console) {
  auto described = describe(path, accept_unknown_orientation, console);
  if (!described) return described.error();
  io::Json report;
  report["file"] = path.string();
  report.update(*described);
  if (json) {
    add_messages(report, console.entries());
    return write_json(report, *json);
  }
  print(report, "");
  // Warnings were shown as they came.
  for (const DiagnosticEntry& entry : console.entries()) {
    if (!entry.finding || entry.severity != Severity::kInfo) continue;
    std::cout << "note: " << without_controls(entry.message) << '\n';
  }
  return {};
}

}  // namespace nav::app
