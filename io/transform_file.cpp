// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/transform_file.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <locale>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "io/atomic_file.hpp"
#include "io/detail/text.hpp"

namespace nav::io {
namespace {

constexpr std::string_view kFirstLine = "#Insight Transform File V1.0";

/// Between the LPS of files and the RAS of 3D Slicer.
Eigen::Matrix4d lps_from_ras() { return Eigen::Vector4d(-1, -1, 1, 1).asDiagonal(); }

/// Fields of the one transform of a file.
struct ItkTransform {
  std::string file;
  std::string type;  ///< Without precision and dimensions: "AffineTransform".
  std::vector<double> parameters, fixed;

  [[nodiscard]] Error reject(const std::string& what) const {
    return {ErrorCode::kMalformedData, file + ": " + what};
  }
};

std::string count_text(std::size_t count) { return std::to_string(count) + " numbers"; }

/// Numbers of a field; every one is finite.
Result<std::vector<double>> numbers_of(const std::string& file, std::string_view key,
                                       std::string_view text) {
  if (detail::trim(text).empty()) return std::vector<double>{};
  auto numbers = detail::parse_doubles(text);
  const bool finite =
      numbers && std::ranges::all_of(*numbers, [](double x) { return std::isfinite(x); });
  if (finite) return *std::move(numbers);
  return Error{ErrorCode::kMalformedData, file + ": " + std::string(key) +
                                              ": expected finite numbers, found '" +
                                              detail::excerpt(text) + "'"};
}

/// "AffineTransform" of "AffineTransform_double_3_3"; nothing for other dimensions than three.
std::optional<std::string> base_type(std::string_view type) {
  const std::size_t end = type.find('_');
  if (end == type.npos) return std::nullopt;
  const std::string_view rest = type.substr(end);
  if (rest != "_double_3_3" && rest != "_float_3_3") return std::nullopt;
  return std::string(type.substr(0, end));
}

/// Fields "Key: value" of the file, by key.
Result<std::map<std::string, std::string, std::less<>>> fields_of(const std::string& file,
                                                                  const std::string& text) {
  std::map<std::string, std::string, std::less<>> fields;
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    const std::string_view trimmed = detail::trim(line);
    if (trimmed.empty() || trimmed.front() == '#') continue;
    const std::string where = file + ":" + std::to_string(number) + ": ";
    const std::size_t colon = trimmed.find(':');
    const std::string key(detail::trim(trimmed.substr(0, colon)));
    const bool known = key == "Transform" || key == "Parameters" || key == "FixedParameters";
    if (colon == trimmed.npos || !known) {
      return Error{ErrorCode::kMalformedData,
                   where + "expected Transform, Parameters or FixedParameters, found '" +
                       detail::excerpt(trimmed) + "'"};
    }
    if (!fields.emplace(key, detail::trim(trimmed.substr(colon + 1))).second) {
      return Error{ErrorCode::kUnsupportedData,
                   where + key + ": expected one transform, found another"};
    }
  }
  return fields;
}

Result<ItkTransform> parse(const std::filesystem::path& path) {
  constexpr std::uint64_t kMostBytes = 1 << 20;
  const auto text = read_file(path, kMostBytes);
  if (!text) return text.error();
  ItkTransform read{.file = path.string(), .type = {}, .parameters = {}, .fixed = {}};
  if (!text->starts_with(kFirstLine)) {
    return read.reject("expected '" + std::string(kFirstLine) + "' in the first line, found '" +
                       detail::excerpt(text->substr(0, text->find('\n'))) + "'");
  }
  const auto fields = fields_of(read.file, *text);
  if (!fields) return fields.error();
  const auto value = [&](const char* key) {
    const auto found = fields->find(key);
    return found == fields->end() ? std::string() : found->second;
  };
  const auto type = base_type(value("Transform"));
  if (!type) {
    return read.reject(
        "Transform: expected a transform of three dimensions such as "
        "AffineTransform_double_3_3, found '" +
        detail::excerpt(value("Transform")) + "'");
  }
  read.type = *type;
  auto parameters = numbers_of(read.file, "Parameters", value("Parameters"));
  if (!parameters) return parameters.error();
  auto fixed = numbers_of(read.file, "FixedParameters", value("FixedParameters"));
  if (!fixed) return fixed.error();
  read.parameters = *std::move(parameters);
  read.fixed = *std::move(fixed);
  return read;
}

/// Rotation of three angles, rad, in the order of ITK: Z X Y, or Z Y X.
Eigen::Matrix3d euler(const Eigen::Vector3d& rad, bool zyx) {
  const Eigen::AngleAxisd x(rad.x(), Eigen::Vector3d::UnitX());
  const Eigen::AngleAxisd y(rad.y(), Eigen::Vector3d::UnitY());
  const Eigen::AngleAxisd z(rad.z(), Eigen::Vector3d::UnitZ());
  return zyx ? (z * y * x).toRotationMatrix() : (z * x * y).toRotationMatrix();
}

/// Rotation of a versor, the vector part of a unit quaternion with a scalar part of 0 or more.
Result<Eigen::Matrix3d> versor(const ItkTransform& of) {
  constexpr double kRounding = 1e-9;
  const Eigen::Map<const Eigen::Vector3d> v(of.parameters.data());
  const double squared = v.squaredNorm();
  if (squared > 1 + kRounding) {
    return of.reject("Parameters: expected a versor of length 1 at most, found " +
                     std::to_string(std::sqrt(squared)));
  }
  const double w = std::sqrt(std::max(0.0, 1 - squared));
  return Eigen::Quaterniond(w, v.x(), v.y(), v.z()).normalized().toRotationMatrix();
}

/// The map of the file's points, 4 x 4, LPS on both sides.
Result<Eigen::Matrix4d> matrix_of(const ItkTransform& of) {
  struct Kind {
    std::size_t parameters;
    std::size_t translation;  ///< Index of its first number; none where it is `parameters`.
  };
  const std::map<std::string_view, Kind> kinds{
      {"AffineTransform", {12, 9}}, {"MatrixOffsetTransformBase", {12, 9}},
      {"Euler3DTransform", {6, 3}}, {"VersorRigid3DTransform", {6, 3}},
      {"VersorTransform", {3, 3}},  {"TranslationTransform", {3, 0}},
      {"IdentityTransform", {0, 0}}};
  const auto kind = kinds.find(of.type);
  if (kind == kinds.end()) {
    std::string names;
    for (const auto& [name, unused] : kinds) {
      names += (names.empty() ? "" : ", ") + std::string(name);
    }
    return Error{ErrorCode::kUnsupportedData, of.file + ": Transform: expected one of " + names +
                                                  ", found " + detail::excerpt(of.type)};
  }
  const auto& [count, at] = kind->second;
  if (of.parameters.size() != count) {
    return of.reject("Parameters: expected " + count_text(count) + " of " + of.type + ", found " +
                     std::to_string(of.parameters.size()));
  }
  // Euler3DTransform has the order of the angles behind its centre.
  const bool ordered = of.type == "Euler3DTransform" && of.fixed.size() == 4;
  if (!of.fixed.empty() && of.fixed.size() != 3 && !ordered) {
    return of.reject("FixedParameters: expected " + count_text(3) +
                     ", the centre of rotation, found " + std::to_string(of.fixed.size()));
  }
  Eigen::Matrix3d linear = Eigen::Matrix3d::Identity();
  const double* numbers = of.parameters.data();
  if (count == 12) {
    linear = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers);
  } else if (of.type == "Euler3DTransform") {
    linear = euler(Eigen::Map<const Eigen::Vector3d>(numbers), ordered && of.fixed[3] != 0);
  } else if (of.type.starts_with("Versor")) {
    const auto rotation = versor(of);
    if (!rotation) return rotation.error();
    linear = *rotation;
  }
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
  if (of.fixed.size() >= 3) centre = Eigen::Map<const Eigen::Vector3d>(of.fixed.data());
  if (at < count) shift = Eigen::Map<const Eigen::Vector3d>(numbers + at);
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() = linear;
  matrix.topRightCorner<3, 1>() = centre + shift - linear * centre;
  return matrix;
}

}  // namespace

bool is_transform_file(const std::filesystem::path& path) {
  return detail::equals_ignoring_case(path.extension().string(), ".tfm");
}

Result<Eigen::Matrix4d> read_ct_from_reference(const std::filesystem::path& path) {
  const auto read = parse(path);
  if (!read) return read.error();
  const auto reference_from_ct = matrix_of(*read);
  if (!reference_from_ct) return reference_from_ct.error();
  constexpr double kSmallest = 1e-12;
  if (!(std::abs(reference_from_ct->topLeftCorner<3, 3>().determinant()) > kSmallest)) {
    return read->reject(
        "Parameters: expected a transform that can be inverted, found one of "
        "determinant " +
        std::to_string(reference_from_ct->topLeftCorner<3, 3>().determinant()));
  }
  return Eigen::Matrix4d((lps_from_ras() * *reference_from_ct).inverse());
}

Result<void> write_ct_from_reference(const Eigen::Matrix4d& ct_from_reference,
                                     const std::filesystem::path& path) {
  // lps_from_ras() is its own inverse.
  const Eigen::Matrix4d lps_from_ct = lps_from_ras() * ct_from_reference.inverse();
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(17);
  text << kFirstLine << "\n#Transform 0\nTransform: AffineTransform_double_3_3\nParameters:";
  for (int i = 0; i < 9; ++i) text << ' ' << lps_from_ct(i / 3, i % 3);
  for (int i = 0; i < 3; ++i) text << ' ' << lps_from_ct(i, 3);
  text << "\nFixedParameters: 0 0 0\n";
  return write_file(path, text.str());
}

}  // namespace nav::io
