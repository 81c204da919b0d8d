// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_config.hpp"

#include <sstream>

#include "app/options/retired.hpp"
#include "app/options/session_look.hpp"
#include "app/options/session_objects.hpp"
#include "app/options/session_predicates.hpp"
#include "app/options/session_section.hpp"
#include "io/json.hpp"
#include "nav/places.hpp"

namespace nav::app {
namespace {

/// Absent where the file has no such section.
std::optional<NeedlePlan> read_plan(Section section, bool present) {
  if (!present) return std::nullopt;
  std::vector<double> entry(3);
  std::vector<double> target(3);
  NeedlePlan plan{{{}}, {{}}, 0, 0};
  section.required_numbers("entry_mm", 3, entry);
  section.required_numbers("target_mm", 3, target);
  section.required_number("target_radius_mm", plan.target_radius_mm);
  section.number("margin_mm", plan.margin_mm);
  section.finish();
  plan.entry_ct = {Eigen::Vector3d(entry[0], entry[1], entry[2])};
  plan.target_ct = {Eigen::Vector3d(target[0], target[1], target[2])};
  return plan;
}

SessionConfig read_tables(const toml::table& root, const std::string& file,
                          std::optional<Error>& error) {
  SessionConfig config;
  config.file = file;
  const std::set<std::string> sections = {"ct",   "source", "placement", "look",   "predicates",
                                          "view", "output", "plan",      "quality"};
  for (const auto& [key, node] : root) {
    if (error) break;
    const std::string name(key.str());
    if (name == "cutaway_objects") continue;
    if (!sections.contains(name) || !node.is_table()) {
      error = Error{ErrorCode::kMalformedData,
                    file + ":" + std::to_string(node.source().begin.line) + ": unknown section '" +
                        name +
                        "', expected one of ct, cutaway_objects, look, output, "
                        "placement, plan, predicates, quality, source, "
                        "view"};
    }
  }
  const auto section = [&](const char* name) {
    return Section(file, name, root[name].as_table(), error);
  };

  Section ct = section("ct");
  ct.path("path", config.ct.path);
  ct.text("series_uid", config.ct.series_uid);
  ct.flag("accept_unknown_orientation", config.ct.accept_unknown_orientation);
  ct.finish();

  Section source = section("source");
  std::string kind = "recording";
  source.text("kind", kind);
  source.path("recording", config.source.recording);
  source.path("plus_config", config.source.plus_config);
  source.text("image_frame", config.source.image_frame);
  source.text("probe_frame", config.source.probe_frame);
  source.text("tracker_frame", config.source.tracker_frame);
  source.text("reference_frame", config.source.reference_frame);
  source.text("needle_frame", config.source.needle_frame);
  source.number("needle_length_mm", config.source.needle_size.length_mm);
  source.number("needle_diameter_mm", config.source.needle_size.diameter_mm);
  source.number("temporal_offset_ms", config.source.temporal_offset_ms);
  source.flag("whole_picture", config.source.whole_picture);
  source.flag("skip_bad_frames", config.source.skip_bad_frames);
  source.integer("seed", config.source.seed);
  source.finish();
  if (kind == "simulated") {
    config.source.kind = SessionConfig::SourceKind::kSimulated;
  } else if (kind == "device" && !error) {
    error = Error{ErrorCode::kUnavailable,
                  file +
                      ": source.kind: expected recording or simulated, found device, for which "
                      "this build has no adapter"};
  } else if (kind != "recording") {
    source.refuse("kind", "recording or simulated", kind);
  }

  Section placement = section("placement");
  std::vector<double> matrix;
  placement.numbers("ct_from_reference_mm", 16, matrix);
  placement.path("registration", config.placement.registration);
  placement.flag("follow", config.placement.follow);
  if (!matrix.empty() && !config.placement.registration.empty()) {
    placement.refuse("registration", "it or placement.ct_from_reference_mm", "both");
  }
  placement.finish();
  if (!matrix.empty()) {
    config.placement.ct_from_reference =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(matrix.data());
  }

  config.plan = read_plan(section("plan"), root.contains("plan"));

  Section look = section("look");
  read_look(look, file, error, config.look);

  Section whole(file, "", &root, error);
  read_cutaway_objects(whole, file, error, config.cutaway_objects);

  Section quality = section("quality");
  quality.text("classification", config.quality.classification);
  quality.flag("jitter", config.quality.jitter);
  double adaptive_error = 0;  // Session files of earlier versions have it, usually 0.
  quality.number("adaptive_error", adaptive_error);
  if (adaptive_error != 0) warn_retired("quality.adaptive_error", kNoAdaptiveStep);
  quality.finish();

  Section predicates = section("predicates");
  read_predicates(predicates, file, error, config.predicates);

  Section view = section("view");
  view.number("azimuth_deg", config.view.azimuth_deg);
  view.number("elevation_deg", config.view.elevation_deg);
  view.number("distance_mm", config.view.distance_mm);
  view.number("fov_deg", config.view.fov_deg);
  view.flag("orthographic", config.view.orthographic);
  view.number("window_level", config.view.window_level);
  view.number("window_width", config.view.window_width);
  view.finish();

  Section output = section("output");
  output.path("folder", config.output.folder);
  output.text("engine", config.output.engine);
  output.integer("threads", config.output.threads);
  output.integer("width_px", config.output.width);
  output.integer("height_px", config.output.height);
  output.number("step_voxels", config.output.step_voxels);
  output.number("rms_error", config.output.rms_error);
  output.number("pixel_error", config.output.pixel_error);
  output.integer("frames", config.output.frames);
  output.flag("window", config.output.window);
  output.finish();
  return config;
}

bool is_utf8(const std::string& text) {
  try {
    (void)io::Json(text).dump();
    return true;
  } catch (const io::Json::exception&) {
    return false;
  }
}

/// The first text that TOML cannot hold: the library would write another in its place.
Result<void> check_texts(const toml::node& node, const std::string& key) {
  if (const auto* table = node.as_table()) {
    for (const auto& [name, value] : *table) {
      const std::string full = key.empty() ? std::string(name) : key + "." + std::string(name);
      if (const auto ok = check_texts(value, full); !ok) return ok;
    }
  } else if (const auto* list = node.as_array()) {
    for (const toml::node& value : *list) {
      if (const auto ok = check_texts(value, key); !ok) return ok;
    }
  } else if (const auto* text = node.as_string(); text != nullptr && !is_utf8(text->get())) {
    return Error{ErrorCode::kUsage,
                 key + ": expected UTF-8, as a session file is, found " + text->get()};
  }
  return {};
}

}  // namespace

Result<SessionConfig> read_session_config(const std::filesystem::path& path) {
  std::error_code status;
  if (!std::filesystem::is_regular_file(path, status)) {
    return Error{ErrorCode::kNotFound,
                 path.string() + ": expected a session file, found " +
                     (std::filesystem::exists(path, status) ? "something that is not a file"
                                                            : "nothing of that name")};
  }
  toml::table root;
  try {
    root = toml::parse_file(path.string());
  } catch (const toml::parse_error& problem) {
    std::ostringstream text;
    text << path.string() << ":" << problem.source().begin.line << ": expected TOML, found "
         << problem.description();
    return Error{ErrorCode::kMalformedData, text.str()};
  }
  std::optional<Error> error;
  SessionConfig config = read_tables(root, path.string(), error);
  if (error) return *error;
  if (const auto ok = validate(config); !ok) {
    return Error{ErrorCode::kMalformedData, path.string() + ": " + ok.error().message};
  }
  return config;
}

Result<void> validate(const SessionConfig& config) {
  const auto refuse = [](const std::string& key, const std::string& expected, auto found) {
    std::ostringstream text;
    text << key << ": expected " << expected << ", found " << found;
    return Error{ErrorCode::kUsage, text.str()};
  };
  const auto within = [](double value, double low, double high) {
    return value >= low && value <= high;
  };
  const auto& output = config.output;
  if (output.engine != "cpu" && output.engine != "gl" && output.engine != "reference") {
    return refuse("output.engine", "cpu, gl or reference", output.engine);
  }
  if (!within(output.width, 16, 8192)) return refuse("output.width_px", "16 to 8192", output.width);
  if (!within(output.height, 16, 8192)) {
    return refuse("output.height_px", "16 to 8192", output.height);
  }
  if (!within(output.threads, 0, 1024)) {
    return refuse("output.threads", "0 (all cores) to 1024", output.threads);
  }
  if (output.step_voxels && !within(*output.step_voxels, 1.0 / 64, 16)) {
    return refuse("output.step_voxels", "1/64 to 16", *output.step_voxels);
  }
  if (!within(output.rms_error, 1e-5, 1)) {
    return refuse("output.rms_error", "1e-5 to 1", output.rms_error);
  }
  if (!within(output.pixel_error, 0, 1)) {
    return refuse("output.pixel_error", "0 to 1", output.pixel_error);
  }
  if (!within(output.frames, 0, 1e6)) return refuse("output.frames", "0 to 10^6", output.frames);
  if (!within(config.view.fov_deg, 1, 120)) {
    return refuse("view.fov_deg", "1 to 120", config.view.fov_deg);
  }
  if (!within(config.view.elevation_deg.value_or(0), -89, 89)) {
    return refuse("view.elevation_deg", "-89 to 89", *config.view.elevation_deg);
  }
  if (!within(config.view.azimuth_deg.value_or(0), -360, 360)) {
    return refuse("view.azimuth_deg", "-360 to 360", *config.view.azimuth_deg);
  }
  if (!within(config.view.distance_mm, 0, 1e5)) {
    return refuse("view.distance_mm", "0 (fit) to 10^5", config.view.distance_mm);
  }
  if (!within(config.view.window_level.value_or(0), -1e6, 1e6)) {
    return refuse("view.window_level", "-10^6 to 10^6", *config.view.window_level);
  }
  if (!within(config.view.window_width.value_or(1), 1e-3, 1e6)) {
    return refuse("view.window_width", "0.001 to 10^6", *config.view.window_width);
  }
  const auto& placement = config.placement;
  if (placement.ct_from_reference) {
    const Eigen::Vector3d place = placement.ct_from_reference->topRightCorner<3, 1>();
    if (!is_place(place)) {
      return refuse("placement.ct_from_reference_mm", "a translation within 1e7 mm",
                    place.transpose());
    }
  }
  if (placement.follow && placement.registration.empty()) {
    return refuse("placement.follow", "a CT that was registered (placement.registration)",
                  placement.ct_from_reference ? "one that is only declared" : "none");
  }
  if (placement.follow && config.source.kind != SessionConfig::SourceKind::kRecording) {
    return refuse("placement.follow", "a recording", "the simulated procedure");
  }
  if (config.plan) {
    const NeedlePlan& plan = *config.plan;
    for (const auto& [key, point] :
         {std::pair("plan.entry_mm", plan.entry_ct.mm), {"plan.target_mm", plan.target_ct.mm}}) {
      if (!(point.norm() <= 1e6)) {
        return refuse(key, "a place within 10^6 mm", point.transpose());
      }
    }
    if (!within(plan.target_radius_mm, 0.1, 500)) {
      return refuse("plan.target_radius_mm", "0.1 to 500", plan.target_radius_mm);
    }
    if (!within(plan.margin_mm, 0, 500)) {
      return refuse("plan.margin_mm", "0 to 500", plan.margin_mm);
    }
    if (const auto ok = validate(plan); !ok) return Error{ErrorCode::kUsage, ok.error().message};
    if (config.source.kind != SessionConfig::SourceKind::kRecording) {
      return refuse("plan", "a recording", "the simulated procedure, which has its own");
    }
  }
  const auto& quality = config.quality;
  const bool pre_integrated = quality.classification == "pre-integrated";
  if (!pre_integrated && quality.classification != "post-classified") {
    return refuse("quality.classification", "pre-integrated or post-classified",
                  quality.classification);
  }
  if (quality.jitter && config.output.pixel_error > 0) {
    return refuse("output.pixel_error", "0 beside quality.jitter, under which no ray is spared",
                  config.output.pixel_error);
  }
  if (const auto ok = validate(config.cutaway_objects); !ok) return ok;
  if (const auto ok = validate(config.look); !ok) return ok;
  if (const auto ok = validate(config.predicates); !ok) return ok;
  if (!within(config.source.needle_size.length_mm, 1, 1000)) {
    return refuse("source.needle_length_mm", "1 to 1000", config.source.needle_size.length_mm);
  }
  if (!within(config.source.needle_size.diameter_mm, 0.1, 20)) {
    return refuse("source.needle_diameter_mm", "0.1 to 20", config.source.needle_size.diameter_mm);
  }
  if (!within(config.source.temporal_offset_ms, -10000, 10000)) {
    return refuse("source.temporal_offset_ms", "-10000 to 10000", config.source.temporal_offset_ms);
  }
  return {};
}

Result<void> require_path(const std::filesystem::path& path, const char* option, const char* what) {
  if (!path.empty()) return {};
  return Error{ErrorCode::kUsage, std::string(option) + ": expected " + what + ", found nothing"};
}

Result<std::string> to_toml(const SessionConfig& config) {
  toml::table root;
  toml::table ct;
  ct.insert("path", absolute_text(config.ct.path));
  ct.insert("series_uid", config.ct.series_uid);
  ct.insert("accept_unknown_orientation", config.ct.accept_unknown_orientation);
  toml::table source;
  const bool simulated = config.source.kind == SessionConfig::SourceKind::kSimulated;
  source.insert("kind", simulated ? "simulated" : "recording");
  source.insert("recording", absolute_text(config.source.recording));
  source.insert("plus_config", absolute_text(config.source.plus_config));
  source.insert("image_frame", config.source.image_frame);
  source.insert("probe_frame", config.source.probe_frame);
  source.insert("tracker_frame", config.source.tracker_frame);
  source.insert("reference_frame", config.source.reference_frame);
  source.insert("needle_frame", config.source.needle_frame);
  source.insert("needle_length_mm", config.source.needle_size.length_mm);
  source.insert("needle_diameter_mm", config.source.needle_size.diameter_mm);
  source.insert("temporal_offset_ms", config.source.temporal_offset_ms);
  source.insert("whole_picture", config.source.whole_picture);
  source.insert("skip_bad_frames", config.source.skip_bad_frames);
  source.insert("seed", static_cast<std::int64_t>(config.source.seed));
  toml::table placement;
  if (config.placement.ct_from_reference) {
    toml::array numbers;
    for (int row = 0; row < 4; ++row) {
      for (int column = 0; column < 4; ++column) {
        numbers.push_back((*config.placement.ct_from_reference)(row, column));
      }
    }
    placement.insert("ct_from_reference_mm", std::move(numbers));
  }
  placement.insert("registration", absolute_text(config.placement.registration));
  placement.insert("follow", config.placement.follow);
  toml::table view{{"distance_mm", config.view.distance_mm},
                   {"fov_deg", config.view.fov_deg},
                   {"orthographic", config.view.orthographic}};
  if (config.view.azimuth_deg) view.insert("azimuth_deg", *config.view.azimuth_deg);
  if (config.view.elevation_deg) view.insert("elevation_deg", *config.view.elevation_deg);
  if (config.view.window_level) view.insert("window_level", *config.view.window_level);
  if (config.view.window_width) view.insert("window_width", *config.view.window_width);
  toml::table output{{"folder", absolute_text(config.output.folder)},
                     {"engine", config.output.engine},
                     {"threads", config.output.threads},
                     {"width_px", config.output.width},
                     {"height_px", config.output.height},
                     {"rms_error", config.output.rms_error},
                     {"pixel_error", config.output.pixel_error},
                     {"frames", config.output.frames},
                     {"window", config.output.window}};
  if (config.output.step_voxels) output.insert("step_voxels", *config.output.step_voxels);
  root.insert("ct", std::move(ct));
  root.insert("source", std::move(source));
  root.insert("placement", std::move(placement));
  root.insert("look", look_to_toml(config.look));
  if (config.plan) {
    const auto point = [](const Eigen::Vector3d& p) { return toml::array{p.x(), p.y(), p.z()}; };
    root.insert("plan", toml::table{{"entry_mm", point(config.plan->entry_ct.mm)},
                                    {"target_mm", point(config.plan->target_ct.mm)},
                                    {"target_radius_mm", config.plan->target_radius_mm},
                                    {"margin_mm", config.plan->margin_mm}});
  }
  root.insert("quality", toml::table{{"classification", config.quality.classification},
                                     {"jitter", config.quality.jitter}});
  if (!config.cutaway_objects.empty()) {
    root.insert("cutaway_objects", cutaway_objects_to_toml(config.cutaway_objects));
  }
  root.insert("predicates", predicates_to_toml(config.predicates));
  root.insert("view", std::move(view));
  root.insert("output", std::move(output));
  if (const auto ok = check_texts(root, ""); !ok) return ok.error();
  std::ostringstream text;
  text << root << '\n';
  return text.str();
}

}  // namespace nav::app
