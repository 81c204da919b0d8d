// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/session_config.hpp"

#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <toml++/toml.h>

namespace nav::app {
namespace {

/// One table of the file: hands out its values by type and, at the end, refuses what nobody asked
/// for. The first problem is kept; later calls do nothing.
class Section {
 public:
  Section(const std::string& file, const std::string& name, const toml::table* table,
          std::optional<Error>& error)
      : file_(file), name_(name), table_(table), error_(error) {}

  void text(const char* key, std::string& value) {
    take<std::string>(key, "text", [&](const toml::node& node) {
      const auto found = node.value_exact<std::string>();
      if (found) value = *found;
      return found.has_value();
    });
  }
  void path(const char* key, std::filesystem::path& value) {
    std::string text_value;
    text(key, text_value);
    if (!text_value.empty()) value = std::filesystem::path(file_).parent_path() / text_value;
  }
  void number(const char* key, std::optional<double>& value) {
    double found = std::numeric_limits<double>::quiet_NaN();
    number(key, found);
    if (std::isfinite(found)) value = found;
  }
  void number(const char* key, double& value) {
    take<double>(key, "a finite number", [&](const toml::node& node) {
      const auto found = node.is_number() ? node.value<double>() : std::nullopt;
      if (found && std::isfinite(*found)) value = *found;
      return found && std::isfinite(*found);
    });
  }
  template <class Integer>
  void integer(const char* key, Integer& value) {
    take<Integer>(key, "a whole number >= 0", [&](const toml::node& node) {
      const auto found = node.value_exact<std::int64_t>();
      const bool good = found && *found >= 0 && std::in_range<Integer>(*found);
      if (good) value = static_cast<Integer>(*found);
      return good;
    });
  }
  void flag(const char* key, bool& value) {
    take<bool>(key, "true or false", [&](const toml::node& node) {
      const auto found = node.value_exact<bool>();
      if (found) value = *found;
      return found.has_value();
    });
  }
  void numbers(const char* key, std::size_t count, std::vector<double>& value) {
    take<double>(key, std::to_string(count) + " finite numbers", [&](const toml::node& node) {
      const toml::array* array = node.as_array();
      if (array == nullptr || array->size() != count) return false;
      std::vector<double> found;
      for (const toml::node& element : *array) {
        const auto one = element.is_number() ? element.value<double>() : std::nullopt;
        if (!one || !std::isfinite(*one)) return false;
        found.push_back(*one);
      }
      value = std::move(found);
      return true;
    });
  }
  const toml::array* tables(const char* key) {
    const toml::array* found = nullptr;
    take<double>(key, "a list of tables", [&](const toml::node& node) {
      found = node.as_array();
      if (found == nullptr) return false;
      for (const toml::node& element : *found) {
        if (!element.is_table()) return false;
      }
      return true;
    });
    return found;
  }
  void refuse_unknown() {
    if (table_ == nullptr || error_) return;
    for (const auto& [key, node] : *table_) {
      if (known_.contains(std::string(key.str()))) continue;
      std::string keys;
      for (const std::string& known : known_) keys.append(keys.empty() ? "" : ", ").append(known);
      fail(node, "unknown key '" + full(std::string(key.str())) + "', expected one of " + keys);
      return;
    }
  }
  void refuse(const char* key, const std::string& expected, const std::string& found) {
    if (error_ || table_ == nullptr) return;
    const toml::node* node = table_->get(key);
    if (node != nullptr) fail(*node, full(key) + ": expected " + expected + ", found " + found);
  }

 private:
  std::string full(const std::string& key) const { return name_.empty() ? key : name_ + "." + key; }
  void fail(const toml::node& node, const std::string& message) {
    error_ = Error{ErrorCode::kMalformedData,
                   file_ + ":" + std::to_string(node.source().begin.line) + ": " + message};
  }
  template <class T, class Use>
  void take(const char* key, const std::string& expected, Use use) {
    known_.insert(key);
    if (table_ == nullptr || error_) return;
    const toml::node* node = table_->get(key);
    if (node == nullptr) return;
    if (use(*node)) return;
    std::ostringstream found;
    node->visit([&](const auto& value) { found << value; });
    std::string text = found.str();
    for (char& c : text) c = c == '\n' ? ' ' : c;
    fail(*node, full(key) + ": expected " + expected + ", found " + text);
  }

  const std::string& file_;
  std::string name_;
  const toml::table* table_;
  std::optional<Error>& error_;
  std::set<std::string> known_;
};

void read_nodes(Section& look, const std::string& file, std::optional<Error>& error,
                SessionConfig& config) {
  const toml::array* nodes = look.tables("nodes");
  if (nodes == nullptr) return;
  for (const toml::node& element : *nodes) {
    Section one(file, "look.nodes", element.as_table(), error);
    render::TransferNode node{0, {1, 1, 1}, 0, 0.5};
    std::vector<double> rgb = {1, 1, 1};
    one.number("hu", node.hu);
    one.numbers("rgb", 3, rgb);
    one.number("opacity_per_mm", node.opacity);
    one.number("importance", node.importance);
    one.refuse_unknown();
    node.rgb = {rgb[0], rgb[1], rgb[2]};
    config.look.nodes.push_back(node);
  }
}

SessionConfig read_tables(const toml::table& root, const std::string& file,
                          std::optional<Error>& error) {
  SessionConfig config;
  config.file = file;
  const std::set<std::string> sections = {"ct", "source", "placement", "look", "view", "output"};
  for (const auto& [key, node] : root) {
    if (error) break;
    const std::string name(key.str());
    if (!sections.contains(name) || !node.is_table()) {
      error = Error{ErrorCode::kMalformedData,
                    file + ":" + std::to_string(node.source().begin.line) + ": unknown section '" +
                        name + "', expected one of ct, look, output, placement, source, view"};
    }
  }
  const auto section = [&](const char* name) {
    return Section(file, name, root[name].as_table(), error);
  };

  Section ct = section("ct");
  ct.path("path", config.ct.path);
  ct.text("series_uid", config.ct.series_uid);
  ct.flag("accept_unknown_orientation", config.ct.accept_unknown_orientation);
  ct.refuse_unknown();

  Section source = section("source");
  std::string kind = "recording";
  source.text("kind", kind);
  source.path("recording", config.source.recording);
  source.path("plus_config", config.source.plus_config);
  source.text("image_frame", config.source.image_frame);
  source.text("probe_frame", config.source.probe_frame);
  source.text("tracker_frame", config.source.tracker_frame);
  source.text("reference_frame", config.source.reference_frame);
  source.number("temporal_offset_ms", config.source.temporal_offset_ms);
  source.flag("skip_bad_frames", config.source.skip_bad_frames);
  source.integer("seed", config.source.seed);
  source.refuse_unknown();
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
  if (!matrix.empty() && !config.placement.registration.empty()) {
    placement.refuse("registration", "it or placement.ct_from_reference_mm", "both");
  }
  placement.refuse_unknown();
  if (!matrix.empty()) {
    config.placement.ct_from_reference =
        Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(matrix.data());
  }

  Section look = section("look");
  look.text("transfer_function", config.look.preset);
  look.flag("shading", config.look.shading);
  look.number("plane_opacity", config.look.plane_opacity);
  read_nodes(look, file, error, config);
  look.refuse_unknown();

  Section view = section("view");
  view.number("azimuth_deg", config.view.azimuth_deg);
  view.number("elevation_deg", config.view.elevation_deg);
  view.number("distance_mm", config.view.distance_mm);
  view.number("fov_deg", config.view.fov_deg);
  view.refuse_unknown();

  Section output = section("output");
  output.path("folder", config.output.folder);
  output.text("engine", config.output.engine);
  output.integer("threads", config.output.threads);
  output.integer("width_px", config.output.width);
  output.integer("height_px", config.output.height);
  output.number("step_voxels", config.output.step_voxels);
  output.integer("frames", config.output.frames);
  output.flag("window", config.output.window);
  output.refuse_unknown();
  return config;
}

/// Readable from any folder; empty stays empty.
std::string absolute_text(const std::filesystem::path& path) {
  return path.empty() ? "" : std::filesystem::absolute(path).lexically_normal().string();
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
  if (!within(output.step_voxels, 1.0 / 64, 16)) {
    return refuse("output.step_voxels", "1/64 to 16", output.step_voxels);
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
  if (!within(config.look.plane_opacity, 0.01, 1)) {
    return refuse("look.plane_opacity", "0.01 to 1", config.look.plane_opacity);
  }
  if (!within(config.source.temporal_offset_ms, -10000, 10000)) {
    return refuse("source.temporal_offset_ms", "-10000 to 10000", config.source.temporal_offset_ms);
  }
  return {};
}

std::string to_toml(const SessionConfig& config) {
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
  source.insert("temporal_offset_ms", config.source.temporal_offset_ms);
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
  toml::table look;
  look.insert("transfer_function", config.look.preset);
  look.insert("shading", config.look.shading);
  look.insert("plane_opacity", config.look.plane_opacity);
  if (!config.look.nodes.empty()) {
    toml::array nodes;
    for (const render::TransferNode& node : config.look.nodes) {
      nodes.push_back(toml::table{{"hu", node.hu},
                                  {"rgb", toml::array{node.rgb[0], node.rgb[1], node.rgb[2]}},
                                  {"opacity_per_mm", node.opacity},
                                  {"importance", node.importance}});
    }
    look.insert("nodes", std::move(nodes));
  }
  toml::table view{{"distance_mm", config.view.distance_mm}, {"fov_deg", config.view.fov_deg}};
  if (config.view.azimuth_deg) view.insert("azimuth_deg", *config.view.azimuth_deg);
  if (config.view.elevation_deg) view.insert("elevation_deg", *config.view.elevation_deg);
  toml::table output{{"folder", absolute_text(config.output.folder)},
                     {"engine", config.output.engine},
                     {"threads", config.output.threads},
                     {"width_px", config.output.width},
                     {"height_px", config.output.height},
                     {"step_voxels", config.output.step_voxels},
                     {"frames", config.output.frames},
                     {"window", config.output.window}};
  root.insert("ct", std::move(ct));
  root.insert("source", std::move(source));
  root.insert("placement", std::move(placement));
  root.insert("look", std::move(look));
  root.insert("view", std::move(view));
  root.insert("output", std::move(output));
  std::ostringstream text;
  text << root << '\n';
  return text.str();
}

}  // namespace nav::app
