// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/registration_file.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "io/digest.hpp"
#include "io/json_member.hpp"
#include "nav/positions.hpp"
#include "registration/acceptance.hpp"

namespace nav::session {

std::string ct_digest(const Volume& ct) {
  const VoxelGrid& grid = ct.grid();
  io::Json geometry;
  geometry["size"] = {grid.size[0], grid.size[1], grid.size[2]};
  for (int i = 0; i < 3; ++i) {
    geometry["numbers"].push_back(grid.spacing_mm[i]);
    geometry["numbers"].push_back(grid.origin_mm[i]);
    for (int k = 0; k < 3; ++k) geometry["numbers"].push_back(grid.directions(i, k));
  }
  return io::sha256_hex(geometry.dump() + io::sha256_hex(std::as_bytes(ct.hu())));
}

io::Json json_of(const RecordingRead& recording) {
  io::Json corners = io::Json::array();
  for (const auto& corner : recording.corners) {
    for (const double mm : corner.mm) corners.push_back(mm);
  }
  return {{"name", recording.name},
          {"frames", recording.frames ? io::Json(*recording.frames) : io::Json()},
          {"first_s", recording.first_s},
          {"last_s", recording.last_s ? io::Json(*recording.last_s) : io::Json()},
          {"temporal_offset_ms", recording.temporal_offset_ms},
          {"corners_probe_mm", std::move(corners)}};
}

namespace {

/// JSON as text for a message, shortened.
std::string json_excerpt(const io::Json& json) {
  constexpr std::size_t kMost = 300;
  std::string text = json.dump(-1, ' ', false, io::Json::error_handler_t::replace);
  if (text.size() > kMost) text = text.substr(0, kMost) + "…";
  return text;
}

/// The warnings of a registration; older files have neither a verdict nor warnings.
Result<std::vector<std::string>> warnings_of(const io::Json& registration,
                                             const std::string& file) {
  const auto reject = [&](const std::string& expected, const io::Json& found) {
    return Error{ErrorCode::kMalformedData,
                 file + ": expected " + expected + ", found " + json_excerpt(found)};
  };
  const io::Json verdict = registration.value("verdict", io::Json());
  if (!verdict.is_null() && verdict != "accept" && verdict != "warn") {
    return reject("registration.verdict of an accepted registration to be accept or warn", verdict);
  }
  const io::Json listed = registration.value("warnings", io::Json::array());
  if (!listed.is_array() || listed.empty() == (verdict == "warn")) {
    return reject(
        "registration.warnings to be a list, with entries exactly when the verdict is "
        "warn",
        listed);
  }
  std::vector<std::string> warnings;
  for (const io::Json& one : listed) {
    if (!one.is_string()) return reject("text in registration.warnings", one);
    warnings.push_back(one.get<std::string>());
  }
  return warnings;
}

/// Absent: it is not as json_of() writes one.
std::optional<RecordingRead> recording_of(const io::Json& json) {
  const auto number = [&](const char* key) { return json.value(key, io::Json()); };
  const io::Json name = json.value("name", io::Json());
  const io::Json corners = json.value("corners_probe_mm", io::Json());
  bool good = name.is_string() && number("frames").is_number_integer() && corners.is_array() &&
              corners.size() == 9;
  for (const char* key : {"first_s", "last_s", "temporal_offset_ms"}) {
    good = good && number(key).is_number();
  }
  for (std::size_t i = 0; good && i < corners.size(); ++i) good = corners[i].is_number();
  if (!good) return {};
  RecordingRead read{.name = name.get<std::string>(),
                     .frames = number("frames").get<std::int64_t>(),
                     .first_s = number("first_s").get<double>(),
                     .last_s = number("last_s").get<double>(),
                     .temporal_offset_ms = number("temporal_offset_ms").get<double>()};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    read.corners[i / 3].mm[static_cast<int>(i % 3)] = corners[i].get<double>();
  }
  return read;
}

/// True for the same name and times. Values that are unknown in one of them are not compared.
bool same_recording(const RecordingRead& a, const RecordingRead& b) {
  constexpr double kStampS = 1e-6;
  if (a.name != b.name || std::abs(a.first_s - b.first_s) > kStampS) return false;
  if (a.frames && b.frames && *a.frames != *b.frames) return false;
  return !a.last_s || !b.last_s || std::abs(*a.last_s - *b.last_s) <= kStampS;
}

/// The recording that a registration was made from; absent where the file names none.
Result<std::optional<RecordingRead>> registered_recording(const io::Json& json,
                                                          const std::string& file) {
  const io::Json found = json.value("recording", io::Json());
  if (found.is_null()) return std::optional<RecordingRead>();
  const auto read = found.is_object() ? recording_of(found) : std::nullopt;
  if (read) return read;
  return Error{ErrorCode::kMalformedData,
               file +
                   ": expected name, frames, first_s, last_s, temporal_offset_ms and 9 "
                   "corners_probe_mm in recording, found " +
                   json_excerpt(found)};
}

/// Covariance of the pose; absent where the file has none. kMalformedData: it is none.
Result<std::optional<registration::PoseUncertainty>> uncertainty_of(const io::Json& json,
                                                                    const std::string& file) {
  using Found = std::optional<registration::PoseUncertainty>;
  if (json.value("covariance_valid", io::Json(false)) != io::Json(true)) return Found();
  const io::Json numbers = json.value("covariance", io::Json());
  const io::Json centre = json.value("covariance_centre_ct_mm", io::Json());
  const auto all_numbers = [](const io::Json& list, std::size_t size) {
    return list.is_array() && list.size() == size &&
           std::all_of(list.begin(), list.end(), [](const io::Json& n) { return n.is_number(); });
  };
  const auto reject = [&](const std::string& expected, const std::string& found) {
    return Error{ErrorCode::kMalformedData, file + ": expected " + expected + ", found " + found};
  };
  if (!all_numbers(numbers, 36) || !all_numbers(centre, 3)) {
    return reject(
        "36 numbers in registration.covariance and 3 in registration.covariance_centre_ct_mm",
        "others");
  }
  registration::PoseUncertainty read{{Eigen::Vector3d::Zero()}, {}};
  for (int i = 0; i < 3; ++i) {
    read.centre_ct.mm[i] = centre[static_cast<std::size_t>(i)].get<double>();
  }
  for (int i = 0; i < 36; ++i) {
    read.covariance(i / 6, i % 6) = numbers[static_cast<std::size_t>(i)].get<double>();
  }
  const double largest = read.covariance.cwiseAbs().maxCoeff();
  constexpr double kRounding = 1e-6;
  const bool symmetric =
      (read.covariance - read.covariance.transpose()).cwiseAbs().maxCoeff() <= kRounding * largest;
  const bool variances = read.covariance.diagonal().minCoeff() >= 0;
  if (!symmetric || !variances) {
    return reject("a symmetric matrix with variances >= 0 in registration.covariance",
                  symmetric ? "a negative variance" : "one that is not symmetric");
  }
  return Found(read);
}

/// Rejects an accepted registration beside which the file says that it was refused.
Result<void> check_other_verdicts(const io::Json& json, const std::string& file) {
  const io::Json& registration = json.at("registration");
  const auto reject = [&](const char* key, const io::Json& other) {
    return Error{ErrorCode::kMalformedData,
                 file + ": expected " + key + " and registration." + key + " to agree, found " +
                     json_excerpt(json.at(key)) + " and " + json_excerpt(other)};
  };
  if (json.contains("accepted") && json.at("accepted") != true) {
    return reject("accepted", registration.at("accepted"));
  }
  const io::Json verdict = registration.value("verdict", io::Json());
  const bool named = json.contains("verdict") && !json.at("verdict").is_null();
  const bool unknown = named && json.at("verdict") != "accept" && json.at("verdict") != "warn";
  if (unknown || (named && !verdict.is_null() && json.at("verdict") != verdict)) {
    return reject("verdict", verdict);
  }
  return {};
}

/// Rejects an accepted registration with a number that no registration is accepted with.
Result<void> check_limits(const io::Json& json, const std::string& file) {
  // A number that was written and read again may differ in its last digit.
  constexpr double kRounding = 1e-6;
  const io::Json& registration = json.at("registration");
  const auto check = [&](const std::string& key, const io::Json& found,
                         double limit) -> Result<void> {
    if (found.is_number() && found.get<double>() <= limit * (1 + kRounding)) return {};
    std::ostringstream most;
    most << limit;
    return Error{ErrorCode::kMalformedData,
                 file + ": expected an accepted registration with registration." + key +
                     " of at most " + most.str() + ", found " + json_excerpt(found)};
  };
  const registration::LandmarkLimits landmarks;
  const registration::AcceptanceLimits images;
  std::vector<std::pair<const char*, double>> limits{
      {"predicted_target_error_rms_mm", images.max_tre_rms_mm},
      {"target_error_rms_mm", landmarks.max_tre_rms_mm},
      {"fre_rms_mm", landmarks.max_fre_rms_mm}};
  if (json.value("effort", io::Json()) == "usual") {
    limits.emplace_back("error_probability", images.max_error_probability);
  }
  for (const auto& [key, limit] : limits) {
    if (!registration.contains(key)) continue;
    if (auto ok = check(key, registration.at(key), limit); !ok) return ok;
  }
  // A number beside its own limit.
  for (const auto& [key, part] : registration.items()) {
    if (!part.is_object() || !part.contains("apart_mm") || !part.contains("limit_mm")) continue;
    const io::Json& limit = part.at("limit_mm");
    if (!limit.is_number()) continue;
    const auto ok = check(key + ".apart_mm", part.at("apart_mm"), limit.get<double>());
    if (!ok) return ok;
  }
  return {};
}

/// Rejects an accepted registration with entries that only a refused one has.
Result<void> check_accepted(const io::Json& registration, const std::string& file) {
  const auto reject = [&](const std::string& expected, const io::Json& found) {
    return Error{ErrorCode::kMalformedData, file + ": expected an accepted registration " +
                                                expected + ", found " + json_excerpt(found)};
  };
  const io::Json reasons = registration.value("reasons", io::Json::array());
  if (!reasons.is_array() || !reasons.empty()) {
    return reject("with empty registration.reasons", reasons);
  }
  if (registration.contains(kRefusedPose)) {
    return reject(std::string("without registration.") + kRefusedPose,
                  registration.at(kRefusedPose));
  }
  return {};
}

}  // namespace

std::vector<Finding> findings_of(const ReadRegistration& registration,
                                 const std::filesystem::path& path) {
  if (registration.names_frame) return {};
  return {{.subject = path.string(),
           .key = "reference_frame",
           .values = {"none (register with --reference-frame)"},
           .used = "the patient's frame of the recording, as degraded"}};
}

Result<ReadRegistration> read_registration(const std::filesystem::path& path) {
  constexpr std::uint64_t kMaxBytes = 64 << 20;
  const auto reject = [&](const std::string& expected, const std::string& found) {
    return Error{ErrorCode::kMalformedData,
                 path.string() + ": expected " + expected + ", found " + found};
  };
  const auto parsed = io::read_json(path, kMaxBytes);
  if (!parsed) return parsed.error();
  const io::Json& json = *parsed;
  if (!json.is_object()) {
    return reject("the JSON object of 'sonde register'", json_excerpt(json));
  }
  const io::Json verb = json.value("verb", io::Json("register"));
  if (verb != "register") {
    return reject("the JSON of 'sonde register' in verb", json_excerpt(verb));
  }
  const auto found = json.find("registration");
  if (found == json.end() || !found->is_object()) {
    return reject("a key 'registration'", "none");
  }
  const io::Json& registration = *found;
  const io::Json accepted = registration.value("accepted", io::Json());
  if (!accepted.is_boolean())
    return reject("registration.accepted to be true or false", json_excerpt(accepted));
  if (!accepted.get<bool>()) {
    return Error{ErrorCode::kRefused, path.string() + ": this registration was not accepted"};
  }
  if (const auto ok = check_accepted(registration, path.string()); !ok) return ok.error();
  if (const auto ok = check_other_verdicts(json, path.string()); !ok) return ok.error();
  if (const auto ok = check_limits(json, path.string()); !ok) return ok.error();
  auto warnings = warnings_of(registration, path.string());
  if (!warnings) return warnings.error();
  const io::Json deformable = json.value("deformable", io::Json());
  if (deformable.is_object() && deformable.value("accepted", io::Json(false)) == io::Json(true)) {
    return Error{ErrorCode::kRefused,
                 path.string() +
                     ": expected a registration of the CT as it is, found one of the CT bent by "
                     "a deformation; register without --deformable"};
  }
  auto recording = registered_recording(json, path.string());
  if (!recording) return recording.error();
  const io::Json numbers = registration.value(kAcceptedPose, io::Json());
  if (!numbers.is_array() || numbers.size() != 16) {
    return reject("16 numbers in registration.ct_from_reference_mm", json_excerpt(numbers));
  }
  Eigen::Matrix4d matrix;
  for (std::size_t i = 0; i < 16; ++i) {
    if (!numbers[i].is_number()) {
      return reject("16 numbers in registration.ct_from_reference_mm", json_excerpt(numbers[i]));
    }
    matrix(static_cast<int>(i / 4), static_cast<int>(i % 4)) = numbers[i].get<double>();
  }
  auto rigid = rigid_from_matrix<frames::Ct, frames::Reference>(matrix);
  if (!rigid) {
    return Error{rigid.error().code,
                 path.string() + ": registration.ct_from_reference_mm: " + rigid.error().message};
  }
  if (!is_place(rigid->translation_mm())) {
    return reject("a translation within 1e7 mm in registration.ct_from_reference_mm",
                  json_excerpt(io::Json{numbers[3], numbers[7], numbers[11]}));
  }
  auto uncertainty = uncertainty_of(registration, path.string());
  if (!uncertainty) return uncertainty.error();
  return ReadRegistration{.ct_from_reference = *rigid,
                          .warnings = std::move(*warnings),
                          .recording = *std::move(recording),
                          .uncertainty = *uncertainty,
                          .names_frame = !json.value("reference_frame", io::Json()).is_null(),
                          .json = json};
}

Result<ReadRegistration> read_registration(const std::filesystem::path& path, const Volume& ct,
                                           const RegistrationUse& use) {
  auto read = read_registration(path);
  if (!read) return read;
  const io::Json& json = read->json;
  const auto reject = [&](const std::string& expected, const std::string& found) {
    return Error{ErrorCode::kMalformedData,
                 path.string() + ": expected " + expected + ", found " + found};
  };
  // Its pose holds at rest only, and what is shown with it has no phase.
  const io::Json breath = json.value("breath", io::Json());
  if (!use.follows && breath.is_object() &&
      breath.value("accepted", io::Json(false)) == io::Json(true)) {
    return Error{
        ErrorCode::kRefused,
        path.string() +
            ": expected a registration that holds at all times, found one with the breath; "
            "follow the tissue from it with --follow, or declare the pose of a phase by "
            "--ct-from-reference"};
  }
  const io::Json digest = json.value("ct_sha256", io::Json());
  if (digest.is_null()) {
    return reject("a registration of " + ct.name(),
                  "one that was made without a CT (register with --ct)");
  }
  if (digest != ct_digest(ct)) {
    return Error{ErrorCode::kMalformedData, path.string() + ": expected a registration of " +
                                                ct.name() +
                                                ", found one of another CT (ct_sha256 differs)"};
  }
  // Landmarks alone do not know the name of the frame that they were touched in.
  const io::Json frame = json.value("reference_frame", io::Json());
  if (!frame.is_null() && frame != use.reference_frame) {
    return reject(
        "a registration to the patient's frame " + use.reference_frame + " in reference_frame",
        json_excerpt(frame));
  }
  return read;
}

Result<void> check_recording(const RecordingRead& registered, const RecordingRead& now,
                             const std::filesystem::path& path) {
  constexpr double kSameMs = 1e-6;
  constexpr double kSameMm = 1e-4;
  if (!same_recording(registered, now)) return {};
  std::ostringstream text;
  text << path.string() << ": expected ";
  const auto reject = [&] { return Error{ErrorCode::kMalformedData, text.str()}; };
  if (!(std::abs(registered.temporal_offset_ms - now.temporal_offset_ms) <= kSameMs)) {
    text << "the temporal offset that " << now.name << " was registered with, "
         << registered.temporal_offset_ms << " ms, found " << now.temporal_offset_ms << " ms";
    return reject();
  }
  double apart_mm = 0;
  for (std::size_t i = 0; i < now.corners.size(); ++i) {
    apart_mm = std::max(apart_mm, (registered.corners[i] - now.corners[i]).v.norm());
  }
  if (apart_mm <= kSameMm) return {};
  text.precision(3);
  text << "the calibration of the probe that " << now.name
       << " was registered with, found one that puts a corner of its images " << apart_mm
       << " mm elsewhere";
  return reject();
}

}  // namespace nav::session
