// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "session/arm_file.hpp"

#include <cmath>
#include <vector>

#include "io/json_member.hpp"

namespace nav::session {
namespace {

constexpr std::uint64_t kMostArmBytes = 1 << 20;
constexpr int kArmFileVersion = 1;

void read_matrix(io::JsonMember& from, const char* key, Eigen::Matrix4d& matrix) {
  std::vector<double> numbers;
  from.numbers(key, 16, numbers);
  if (numbers.size() != 16) return;
  matrix = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(numbers.data());
}

/// A whole number; anything else is left for the limits of the arm to reject.
template <class T>
void read_whole(io::JsonMember& from, const char* key, double largest, T& value) {
  auto number = static_cast<double>(value);
  from.required_number(key, number);
  if (number == std::floor(number) && number >= 0 && number <= largest) {
    value = static_cast<T>(number);
  } else {
    from.fail(key, "a whole number from 0 to " + io::Json(largest).dump(), io::Json(number));
  }
}

void read_joint(io::JsonMember& from, devices::ArmJoint& joint) {
  constexpr double kMostNodes = 127, kMostCounts = 2147483648.0;
  read_whole(from, "node", kMostNodes, joint.node);
  read_whole(from, "counts_per_turn", kMostCounts, joint.counts_per_turn);
  read_whole(from, "zero_counts", kMostCounts, joint.zero_counts);
  read_matrix(from, "previous_from_joint", joint.previous_from_joint);
  from.flag("reversed", joint.reversed);
  from.angle("zero_sigma_deg", joint.zero_sigma_rad);
  from.number("link_sigma_mm", joint.link_sigma_mm);
  from.finish();
}

void read_rest(io::JsonMember& from, std::size_t joints, devices::ArmRest& rest) {
  from.numbers("angles_deg", joints, rest.angles_rad);
  for (double& angle : rest.angles_rad) angle *= io::kRadPerDeg;
  from.angle("tolerance_deg", rest.tolerance_rad);
  from.finish();
}

io::Json rows_of(const Eigen::Matrix4d& matrix) {
  io::Json numbers = io::Json::array();
  for (int i = 0; i < 16; ++i) numbers.push_back(matrix(i / 4, i % 4));
  return numbers;
}

}  // namespace

Result<devices::ArmModel> read_arm_file(const std::filesystem::path& path) {
  const auto json = io::read_json(path, kMostArmBytes);
  if (!json) return json.error();
  std::optional<Error> error;
  devices::ArmModel arm;
  io::JsonMember root(*json, path.string(), error);
  root.version("version", kArmFileVersion);
  root.list("joints", [&](const io::Json& one, const std::string& where) {
    io::JsonMember member(one, where, error);
    read_joint(member, arm.joints.emplace_back());
  });
  read_matrix(root, "last_from_body", arm.last_from_body);
  root.object("rest", [&](io::JsonMember& member) {
    read_rest(member, arm.joints.size(), arm.rest.emplace());
  });
  root.finish();
  if (error) return *error;
  if (const auto ok = validate(arm); !ok) {
    return Error{ErrorCode::kMalformedData, path.string() + "." + ok.error().message};
  }
  return arm;
}

std::string arm_file_text(const devices::ArmModel& arm) {
  io::Json json{{"version", kArmFileVersion}, {"joints", io::Json::array()}};
  for (const devices::ArmJoint& joint : arm.joints) {
    json["joints"].push_back({{"node", joint.node},
                              {"counts_per_turn", joint.counts_per_turn},
                              {"zero_counts", joint.zero_counts},
                              {"reversed", joint.reversed},
                              {"previous_from_joint", rows_of(joint.previous_from_joint)},
                              {"zero_sigma_deg", joint.zero_sigma_rad / io::kRadPerDeg},
                              {"link_sigma_mm", joint.link_sigma_mm}});
  }
  json["last_from_body"] = rows_of(arm.last_from_body);
  if (arm.rest) {
    io::Json angles = io::Json::array();
    for (const double angle : arm.rest->angles_rad) angles.push_back(angle / io::kRadPerDeg);
    json["rest"] = {{"angles_deg", std::move(angles)},
                    {"tolerance_deg", arm.rest->tolerance_rad / io::kRadPerDeg}};
  }
  return json.dump(2) + "\n";
}

}  // namespace nav::session
