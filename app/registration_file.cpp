// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/registration_file.hpp"

#include "io/atomic_file.hpp"

namespace nav::app {

std::string ct_digest(const Volume& ct) {
  const VoxelGrid& grid = ct.grid();
  Json geometry;
  geometry["size"] = {grid.size[0], grid.size[1], grid.size[2]};
  for (int i = 0; i < 3; ++i) {
    geometry["numbers"].push_back(grid.spacing_mm[i]);
    geometry["numbers"].push_back(grid.origin_mm[i]);
    for (int k = 0; k < 3; ++k) geometry["numbers"].push_back(grid.directions(i, k));
  }
  return digest_of(geometry.dump() + io::sha256_hex(std::as_bytes(ct.hu())));
}

namespace {

/// The warnings of a registration; older files have neither a verdict nor warnings.
Result<std::vector<std::string>> warnings_of(const Json& registration, const std::string& file) {
  const auto refuse = [&](const std::string& expected, const Json& found) {
    return Error{ErrorCode::kMalformedData,
                 file + ": expected " + expected + ", found " +
                     found.dump(-1, ' ', false, Json::error_handler_t::replace)};
  };
  const Json verdict = registration.value("verdict", Json());
  if (!verdict.is_null() && verdict != "accept" && verdict != "warn") {
    return refuse("registration.verdict of an accepted registration to be accept or warn", verdict);
  }
  const Json listed = registration.value("warnings", Json::array());
  if (!listed.is_array() || listed.empty() == (verdict == "warn")) {
    return refuse(
        "registration.warnings to be a list, with entries exactly when the verdict is "
        "warn",
        listed);
  }
  std::vector<std::string> warnings;
  for (const Json& one : listed) {
    if (!one.is_string()) return refuse("text in registration.warnings", one);
    warnings.push_back(one.get<std::string>());
  }
  return warnings;
}

}  // namespace

Result<ReadRegistration> read_registration(const std::filesystem::path& path, const Volume& ct,
                                           const std::string& reference_frame, bool follows) {
  constexpr std::uint64_t kMaxBytes = 64 << 20;
  const auto refuse = [&](const std::string& expected, const std::string& found) {
    return Error{ErrorCode::kMalformedData,
                 path.string() + ": expected " + expected + ", found " + found};
  };
  const auto text = io::read_file(path, kMaxBytes);
  if (!text) return text.error();
  const Json json = Json::parse(*text, nullptr, false);
  if (json.is_discarded() || !json.is_object()) {
    return refuse("the JSON of 'sonde register'", "something that is not JSON");
  }
  const auto found = json.find("registration");
  if (found == json.end() || !found->is_object()) {
    return refuse("a key 'registration'", "none");
  }
  const Json& registration = *found;
  const Json accepted = registration.value("accepted", Json());
  if (!accepted.is_boolean())
    return refuse("registration.accepted to be true or false", accepted.dump());
  if (!accepted.get<bool>()) {
    return Error{ErrorCode::kRefused, path.string() + ": this registration was not accepted"};
  }
  auto warnings = warnings_of(registration, path.string());
  if (!warnings) return warnings.error();
  // Its pose holds at rest only, and what is shown with it has no phase.
  const Json breath = json.value("breath", Json());
  if (!follows && breath.is_object() && breath.value("accepted", Json(false)) == Json(true)) {
    return Error{
        ErrorCode::kRefused,
        path.string() +
            ": expected a registration that holds at all times, found one with the breath; "
            "follow the tissue from it with --follow, or declare the pose of a phase by "
            "--ct-from-reference"};
  }
  const Json deformable = json.value("deformable", Json());
  if (deformable.is_object() && deformable.value("accepted", Json(false)) == Json(true)) {
    return Error{ErrorCode::kRefused,
                 path.string() +
                     ": expected a registration of the CT as it is, found one of the CT bent by "
                     "a deformation; register without --deformable"};
  }
  const Json digest = json.value("ct_sha256", Json());
  if (digest != ct_digest(ct)) {
    return Error{ErrorCode::kMalformedData, path.string() + ": expected a registration of " +
                                                ct.name() +
                                                ", found one of another CT (ct_sha256 differs)"};
  }
  // Landmarks alone do not know the name of the frame that they were touched in.
  const Json frame = json.value("reference_frame", Json());
  if (!frame.is_null() && frame != reference_frame) {
    return refuse("a registration to the patient's frame " + reference_frame,
                  "one to " + frame.dump(-1, ' ', false, Json::error_handler_t::replace));
  }
  const Json numbers = registration.value(kAcceptedPose, Json());
  if (!numbers.is_array() || numbers.size() != 16) {
    return refuse("16 numbers in registration.ct_from_reference_mm", numbers.dump());
  }
  Eigen::Matrix4d matrix;
  for (std::size_t i = 0; i < 16; ++i) {
    if (!numbers[i].is_number()) {
      return refuse("16 numbers in registration.ct_from_reference_mm", numbers[i].dump());
    }
    matrix(static_cast<int>(i / 4), static_cast<int>(i % 4)) = numbers[i].get<double>();
  }
  auto rigid = rigid_from_matrix<frames::Ct, frames::Reference>(matrix);
  if (!rigid) return Error{rigid.error().code, path.string() + ": " + rigid.error().message};
  return ReadRegistration{*rigid, std::move(*warnings)};
}

}  // namespace nav::app
