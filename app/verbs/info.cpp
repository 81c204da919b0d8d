// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/verbs/info.hpp"

#include <algorithm>
#include <cctype>
#include <iostream>

#include "app/report.hpp"
#include "io/ct.hpp"
#include "io/mcap/device_recording.hpp"
#include "io/plus_config.hpp"
#include "io/sequence.hpp"
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

/// Plays a recording without drawing it, so that what a replay reports is reported here, too.
Result<void> play_for_reports(const session::SourceOptions& source, Console& console) {
  auto session = session::RecordedSession::open(source, console);
  if (!session) return session.error();
  if (auto played = session->play({}); !played) return played;
  if (session->bad_frames() > 0) {
    console.report("recording",
                   {.subject = session->name(),
                    .key = "frames",
                    .values = {std::to_string(session->bad_frames()) + " of " +
                               std::to_string(session->total_frames()) +
                               " that are bad, the first: " + session->first_bad_frame()},
                    .used = "none, or with --skip-bad-frames the others"});
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

Result<io::Json> describe_devices(const std::filesystem::path& path, Console& console) {
  const auto recording = io::mcap::DeviceRecording::open(path, {.read_all = true});
  if (!recording) return recording.error();
  for (const std::string& warning : recording->warnings()) {
    console.report(Severity::kWarning, "recording", warning);
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
      const bool images = device.streams[i].kind == StreamKind::kImages;
      streams[device.streams[i].name] = {
          {"type", images ? "image" : "pose"},
          {"role", images ? io::Json() : io::Json(to_string(device.streams[i].role))},
          {"samples", device.samples[i]}};
    }
  }
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

io::Json describe_ct(const Volume& ct) {
  const VoxelGrid& grid = ct.grid();
  io::Json json;
  json["kind"] = "ct";
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
  json["hu_min"] = *low;
  json["hu_max"] = *high;
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
    return describe_config(*config);
  }
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
  return describe_ct(*ct);
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
  return {};
}

}  // namespace nav::app
