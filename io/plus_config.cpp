// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/plus_config.hpp"

#include <algorithm>
#include <cmath>
#include <pugixml.hpp>
#include <string_view>

#include "io/atomic_file.hpp"
#include "io/detail/text.hpp"

namespace nav::io {

namespace {

constexpr std::uint64_t kMaxConfigBytes = 64 << 20;

/// Reads one configuration; every message names the file and the element.
class ConfigReader {
 public:
  explicit ConfigReader(const std::filesystem::path& path) { config_.path = path; }

  Result<PlusConfig> read() {
    const auto content = read_file(config_.path, kMaxConfigBytes);
    if (!content) return content.error();
    pugi::xml_document document;
    // The default options expand only the five entities of XML; document types are skipped.
    const auto parsed = document.load_buffer(content->data(), content->size());
    if (!parsed) {
      const auto at = std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(parsed.offset, 0)),
                               content->size());
      const std::string found = detail::excerpt(std::string_view(*content).substr(at, 20));
      return malformed("expected XML, found " +
                       (found.empty() ? std::string("the end of the file") : "'" + found + "'") +
                       " at byte " + std::to_string(at));
    }
    const pugi::xml_node root = document.child("PlusConfiguration");
    if (!root) {
      return malformed("expected the root PlusConfiguration, found '" +
                       detail::excerpt(document.document_element().name()) + "'");
    }
    config_.version = root.attribute("version").as_string();
    for (const auto& definitions : root.children("CoordinateDefinitions")) {
      for (const auto& node : definitions.children("Transform")) {
        if (const auto ok = add_transform(node); !ok) return ok.error();
      }
    }
    for (const auto& collection : root.children("DataCollection")) {
      for (const auto& node : collection.children("Device")) {
        if (const auto ok = add_device(node); !ok) return ok.error();
      }
    }
    const auto is_scan = [](const pugi::xml_node& n) {
      return std::string_view(n.name()) == "ScanConversion";
    };
    if (const pugi::xml_node scan = root.find_node(is_scan)) {
      if (const auto ok = add_scan_conversion(scan); !ok) return ok.error();
    }
    if (const pugi::xml_node node = root.child("VolumeReconstruction")) {
      if (const auto ok = add_volume_reconstruction(node); !ok) return ok.error();
    }
    return std::move(config_);
  }

 private:
  Error malformed(const std::string& what) const {
    return {ErrorCode::kMalformedData, config_.path.string() + ": " + what};
  }

  static std::map<std::string, std::string> attributes(const pugi::xml_node& node) {
    std::map<std::string, std::string> out;
    for (const auto& attribute : node.attributes()) out[attribute.name()] = attribute.value();
    return out;
  }

  /// Reads \p count finite numbers of an attribute; empty when it is absent.
  Result<std::vector<double>> numbers(const pugi::xml_node& node, const char* name,
                                      std::size_t count, const std::string& element) const {
    const auto attribute = node.attribute(name);
    if (!attribute) return std::vector<double>();
    const auto values = detail::parse_doubles(attribute.value());
    bool good = values && values->size() == count;
    for (std::size_t i = 0; good && i < count; ++i) good = std::isfinite((*values)[i]);
    if (good) return *values;
    return malformed(element + ": " + name + ": expected " + std::to_string(count) +
                     " finite numbers, found '" + detail::excerpt(attribute.value()) + "'");
  }

  Result<void> add_transform(const pugi::xml_node& node) {
    CoordinateDefinition definition;
    definition.from = node.attribute("From").as_string();
    definition.to = node.attribute("To").as_string();
    const std::string element =
        "Transform " + detail::excerpt(definition.from) + "To" + detail::excerpt(definition.to);
    if (definition.from.empty() || definition.to.empty() || definition.from == definition.to) {
      return malformed(element + ": expected two different names in From and To");
    }
    if (config_.find(definition.from, definition.to) != nullptr) {
      return malformed(element + ": expected one definition, found two");
    }
    if (!node.attribute("Matrix")) return malformed(element + ": expected a Matrix, found none");
    const auto matrix = numbers(node, "Matrix", 16, element);
    if (!matrix) return matrix.error();
    for (Eigen::Index i = 0; i < 16; ++i) {
      definition.to_from_from(i / 4, i % 4) = (*matrix)[static_cast<std::size_t>(i)];
    }
    definition.date = node.attribute("Date").as_string();
    const auto error = detail::parse_double(node.attribute("Error").as_string());
    if (error && std::isfinite(*error)) definition.error = error;
    config_.transforms.push_back(std::move(definition));
    return {};
  }

  Result<void> flag(const pugi::xml_node& node, const char* name, const std::string& element,
                    bool& out) const {
    const auto attribute = node.attribute(name);
    if (!attribute) return {};
    const std::string_view text = detail::trim(attribute.value());
    out = detail::equals_ignoring_case(text, "TRUE");
    if (out || detail::equals_ignoring_case(text, "FALSE")) return {};
    return malformed(element + ": " + name + ": expected TRUE or FALSE, found '" +
                     detail::excerpt(text) + "'");
  }

  Result<void> add_device(const pugi::xml_node& node) {
    PlusDevice device;
    device.id = node.attribute("Id").as_string();
    device.type = node.attribute("Type").as_string();
    device.attributes = attributes(node);
    device.tool_reference_frame = node.attribute("ToolReferenceFrame").as_string();
    device.sequence_file = node.attribute("SequenceFile").as_string();
    device.use_data = node.attribute("UseData").as_string();
    const std::string element = "Device " + detail::excerpt(device.id);
    const auto offset = numbers(node, "LocalTimeOffsetSec", 1, element);
    if (!offset) return offset.error();
    if (!offset->empty()) device.local_time_offset_s = offset->front();
    if (const auto ok =
            flag(node, "UseOriginalTimestamps", element, device.use_original_timestamps);
        !ok) {
      return ok;
    }
    if (const auto ok = flag(node, "RepeatEnabled", element, device.repeat); !ok) return ok;
    for (const auto& source : node.child("DataSources").children("DataSource")) {
      device.data_sources.push_back(
          {source.attribute("Id").as_string(), source.attribute("Type").as_string(),
           source.attribute("PortUsImageOrientation").as_string(), attributes(source)});
    }
    config_.devices.push_back(std::move(device));
    return {};
  }

  Result<void> pair(const pugi::xml_node& node, const char* name,
                    std::optional<Eigen::Vector2d>& out) const {
    const auto values = numbers(node, name, 2, "ScanConversion");
    if (!values) return values.error();
    if (!values->empty()) out = Eigen::Vector2d((*values)[0], (*values)[1]);
    return {};
  }

  Result<void> number(const pugi::xml_node& node, const char* name, double scale,
                      std::optional<double>& out) const {
    const auto values = numbers(node, name, 1, "ScanConversion");
    if (!values) return values.error();
    if (!values->empty()) out = values->front() * scale;
    return {};
  }

  Result<void> add_scan_conversion(const pugi::xml_node& node) {
    ScanConversion scan;
    const std::string geometry = node.attribute("TransducerGeometry").as_string();
    if (geometry != "LINEAR" && geometry != "CURVILINEAR") {
      return malformed(
          "ScanConversion: TransducerGeometry: expected LINEAR or CURVILINEAR, found '" +
          detail::excerpt(geometry) + "'");
    }
    scan.geometry =
        geometry == "LINEAR" ? TransducerGeometry::kLinear : TransducerGeometry::kCurvilinear;
    scan.attributes = attributes(node);
    constexpr double kRadPerDeg = M_PI / 180;
    for (const auto& ok : {pair(node, "OutputImageSpacingMmPerPixel", scan.output_spacing_mm),
                           pair(node, "OutputImageSizePixel", scan.output_size_px),
                           pair(node, "TransducerCenterPixel", scan.transducer_centre_px),
                           number(node, "RadiusStartMm", 1, scan.radius_start_mm),
                           number(node, "RadiusStopMm", 1, scan.radius_stop_mm),
                           number(node, "ThetaStartDeg", kRadPerDeg, scan.theta_start_rad),
                           number(node, "ThetaStopDeg", kRadPerDeg, scan.theta_stop_rad),
                           number(node, "ImagingDepthMm", 1, scan.imaging_depth_mm),
                           number(node, "TransducerWidthMm", 1, scan.transducer_width_mm)}) {
      if (!ok) return ok;
    }
    config_.scan_conversion = std::move(scan);
    return {};
  }

  template <int N>
  Result<void> vector_of(const pugi::xml_node& node, const char* name,
                         std::optional<Eigen::Matrix<double, N, 1>>& out) const {
    const auto values = numbers(node, name, N, "VolumeReconstruction");
    if (!values) return values.error();
    if (!values->empty()) out = Eigen::Map<const Eigen::Matrix<double, N, 1>>(values->data());
    return {};
  }

  Result<void> add_volume_reconstruction(const pugi::xml_node& node) {
    VolumeReconstruction volume;
    std::optional<Eigen::Matrix<double, 1, 1>> start, stop;
    for (const auto& ok : {vector_of<3>(node, "OutputSpacing", volume.output_spacing_mm),
                           vector_of<2>(node, "ClipRectangleOrigin", volume.clip_origin_px),
                           vector_of<2>(node, "ClipRectangleSize", volume.clip_size_px),
                           vector_of<2>(node, "FanAnglesDeg", volume.fan_angles_deg),
                           vector_of<2>(node, "FanOriginPixel", volume.fan_origin_px),
                           vector_of<1>(node, "FanRadiusStartPixel", start),
                           vector_of<1>(node, "FanRadiusStopPixel", stop)}) {
      if (!ok) return ok;
    }
    if (start) volume.fan_radius_start_px = start->value();
    if (stop) volume.fan_radius_stop_px = stop->value();
    config_.volume_reconstruction = volume;
    return {};
  }

  PlusConfig config_;
};

}  // namespace

const CoordinateDefinition* PlusConfig::find(const std::string& from, const std::string& to) const {
  for (const CoordinateDefinition& definition : transforms) {
    if (definition.from == from && definition.to == to) return &definition;
  }
  return nullptr;
}

Result<PlusConfig> read_plus_config(const std::filesystem::path& path) {
  return ConfigReader(path).read();
}

}  // namespace nav::io
