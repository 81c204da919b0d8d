// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicate_scribbles.hpp"

#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>

#include "io/json_member.hpp"
#include "render/predicates/predicate_sampler.hpp"

namespace nav::app {
namespace {

using render::features::Paint;
using render::features::ScribbleMask;
using render::features::Stroke;
using Points = std::vector<Point<frames::Ct>>;

constexpr int kScribblesVersion = 1;

/// Normal of the plane through the points; absent for points on a line, which lies in many planes.
std::optional<Eigen::Vector3d> normal_of(const Points& points) {
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  double reach = 0;
  for (const auto& p : points) {
    reach = std::max(reach, (p.mm - points.front().mm).norm());
    for (const auto& q : points) {
      const Eigen::Vector3d cross = (p.mm - points.front().mm).cross(q.mm - points.front().mm);
      if (cross.norm() > best.norm()) best = cross;
    }
  }
  constexpr double kFlat =
      1e-3;  // Share of the length; allows for rounding in a hand-written file.
  if (!(best.norm() > kFlat * reach * reach)) return {};
  return best.normalized();
}

/// Sets the normal of a stroke. A stroke without a plane of its own becomes a tube: as thick as it
/// is wide.
void complete(const std::optional<Eigen::Vector3d>& normal, Stroke& stroke) {
  const auto found = normal ? normal : normal_of(stroke.points);
  stroke.plane_normal = {found.value_or(Eigen::Vector3d::UnitZ())};
  // Divided by the largest first: squares of finite numbers may not be finite.
  const double largest = stroke.plane_normal.v.cwiseAbs().maxCoeff();
  if (largest > 0) stroke.plane_normal.v = (stroke.plane_normal.v / largest).normalized();
  if (found) return;
  double reach = stroke.radius_mm;
  for (const auto& p : stroke.points) reach += (p.mm - stroke.points.front().mm).norm();
  stroke.half_thickness_mm = std::clamp(reach, 1e-3, 1000.0);
}

Paint read_paint(io::JsonMember& member) {
  std::string paint = "show";
  member.text("paint", paint);
  if (paint != "show" && paint != "hide" && paint != "erase") {
    member.fail("paint", "show, hide or erase", paint);
  }
  return paint == "hide" ? Paint::kHide : paint == "erase" ? Paint::kErase : Paint::kShow;
}

/// Stroke with the numbers as the user gave them.
struct GivenStroke {
  Stroke stroke;  ///< Without normal and thickness.
  std::optional<Eigen::Vector3d> normal;
  double thickness_mm = 0;
};

/// Error in a number of a stroke.
struct StrokeFault {
  std::string member;  ///< Name of the member in the file.
  std::string expected;
  io::Json found;
};

io::Json json_of_point(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

/// Finds numbers that the mask would reject. It is checked here because the mask cannot name the
/// file or option of the stroke.
std::optional<StrokeFault> fault_of(const GivenStroke& given) {
  constexpr double kMost = 1000;
  for (const auto& p : given.stroke.points) {
    if ((p.mm.cwiseAbs().array() <= Stroke::kFurthestMm).all()) continue;
    return StrokeFault{"points_mm", "numbers within 1e6 mm", json_of_point(p.mm)};
  }
  if (given.normal && !(given.normal->cwiseAbs().maxCoeff() > 1e-12)) {
    return StrokeFault{"normal", "3 numbers, not all 0", json_of_point(*given.normal)};
  }
  const double radius = given.stroke.radius_mm;
  if (!(radius > 0 && radius <= kMost)) {
    return StrokeFault{"radius_mm", "a number in (0, 1000]", radius};
  }
  if (!(given.thickness_mm >= 0 && given.thickness_mm <= 2 * kMost)) {
    return StrokeFault{"thickness_mm", "a number in [0, 2000]", given.thickness_mm};
  }
  return {};
}

/// Stroke with normal and thickness. Precondition: fault_of() found no error.
Stroke completed(GivenStroke given) {
  given.stroke.half_thickness_mm = 0.5 * given.thickness_mm;
  complete(given.normal, given.stroke);
  return std::move(given.stroke);
}

Stroke read_stroke(const io::Json& json, const std::string& where, std::optional<Error>& error) {
  io::JsonMember member(json, where, error);
  GivenStroke given;
  Stroke& stroke = given.stroke;
  stroke.paint = read_paint(member);
  member.list("points_mm", [&](const io::Json& one, const std::string& at) {
    const bool good =
        one.is_array() && one.size() == 3 &&
        std::all_of(one.begin(), one.end(), [](const io::Json& x) { return x.is_number(); });
    if (good) {
      stroke.points.push_back({{one[0].get<double>(), one[1].get<double>(), one[2].get<double>()}});
    } else {
      io::JsonMember(io::Json::object(), at, error).fail("", "3 numbers", one);
    }
  });
  if (stroke.points.empty()) member.fail("points_mm", "at least one point", nullptr);
  std::vector<double> normal;
  member.numbers("normal", 3, normal);
  member.number("radius_mm", stroke.radius_mm);
  member.number("thickness_mm", given.thickness_mm);
  member.finish();
  if (error) return stroke;
  if (!normal.empty()) given.normal = Eigen::Vector3d(normal[0], normal[1], normal[2]);
  if (const auto fault = fault_of(given)) {
    member.fail(fault->member, fault->expected, fault->found);
    return stroke;
  }
  return completed(std::move(given));
}

Result<std::vector<Stroke>> strokes_of(const std::string& name, const io::Json& root) {
  std::optional<Error> error;
  io::JsonMember member(root, name, error);
  member.version("sonde_scribbles", kScribblesVersion);
  std::vector<Stroke> strokes;
  member.list("strokes", [&](const io::Json& json, const std::string& at) {
    strokes.push_back(read_stroke(json, at, error));
  });
  if (strokes.empty()) member.fail("strokes", "at least one", nullptr);
  member.finish();
  if (error) return *error;
  return strokes;
}

std::string name_of_stroke(std::size_t n) { return "stroke " + std::to_string(n + 1); }

bool read_number(const std::string& text, double& number) {
  const char* const end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number);
  return read.ec == std::errc() && read.ptr == end;
}

/// Parses "a,b,c"; absent for anything else.
std::optional<Eigen::Vector3d> vector_of(const std::string& text) {
  Eigen::Vector3d v;
  const char* at = text.data();
  const char* const end = text.data() + text.size();
  for (int axis = 0; axis < 3; ++axis) {
    const auto read = std::from_chars(at, end, v[axis]);
    if (read.ec != std::errc() || !std::isfinite(v[axis])) return {};
    at = read.ptr;
    if (axis < 2 && (at == end || *at++ != ',')) return {};
  }
  if (at != end) return {};
  return v;
}

}  // namespace

Result<std::vector<Stroke>> read_scribble_file(const std::filesystem::path& path) {
  constexpr std::uint64_t kMostBytes = 1 << 20;
  const auto root = io::read_json(path, kMostBytes);
  if (!root) return root.error();
  return strokes_of(path.string(), *root);
}

Result<std::vector<Stroke>> parse_scribble_text(const std::string& name, const std::string& text) {
  const auto root = io::parse_json(name, text);
  if (!root) return root.error();
  return strokes_of(name, *root);
}

std::string to_json_text(const std::vector<Stroke>& strokes) {
  io::Json list = io::Json::array();
  for (const Stroke& stroke : strokes) {
    io::Json points = io::Json::array();
    for (const auto& p : stroke.points) points.push_back(json_of_point(p.mm));
    list.push_back({{"paint", stroke.paint == Paint::kHide    ? "hide"
                              : stroke.paint == Paint::kErase ? "erase"
                                                              : "show"},
                    {"points_mm", std::move(points)},
                    {"normal", json_of_point(stroke.plane_normal.v)},
                    {"radius_mm", stroke.radius_mm},
                    {"thickness_mm", 2 * stroke.half_thickness_mm}});
  }
  return io::Json{{"sonde_scribbles", kScribblesVersion}, {"strokes", std::move(list)}}.dump() +
         "\n";
}

Result<Stroke> parse_stroke(const std::string& option, Paint paint, const std::string& text) {
  const Error reject{ErrorCode::kUsage, option +
                                            ": expected 'x,y,z x,y,z … [radius=MM] [thickness=MM] "
                                            "[normal=x,y,z]', found '" +
                                            text + "'"};
  GivenStroke given;
  given.stroke.paint = paint;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (word.starts_with("radius=")) {
      if (!read_number(word.substr(7), given.stroke.radius_mm)) return reject;
    } else if (word.starts_with("thickness=")) {
      if (!read_number(word.substr(10), given.thickness_mm)) return reject;
    } else if (word.starts_with("normal=")) {
      given.normal = vector_of(word.substr(7));
      if (!given.normal) return reject;
    } else {
      const auto point = vector_of(word);
      if (!point) return reject;
      given.stroke.points.push_back({*point});
    }
  }
  if (given.stroke.points.empty()) return reject;
  if (const auto fault = fault_of(given)) {
    return Error{ErrorCode::kUsage, option + ": " + fault->member + ": expected " +
                                        fault->expected + ", found " + fault->found.dump() +
                                        " in '" + text + "'"};
  }
  return completed(std::move(given));
}

Result<void> check_strokes(const std::vector<Stroke>& strokes, const VoxelGrid& grid) {
  for (std::size_t n = 0; n < strokes.size(); ++n) {
    const auto ok = render::features::check(strokes[n], grid);
    if (!ok) return Error{ok.error().code, name_of_stroke(n) + ": " + ok.error().message};
  }
  return {};
}

Result<ScribbleOutcome> scribble(const render::Scene& scene, const std::vector<Stroke>& strokes,
                                 double share) {
  const render::PredicateScene& predicates = *scene.predicates;
  const auto set = render::PredicateSet::create(predicates, scene.ct, render::position_of(scene));
  if (!set) return set.error();
  ScribbleMask mask(scene.ct->grid());
  for (std::size_t n = 0; n < strokes.size(); ++n) {
    const std::string name = name_of_stroke(n);
    const auto painted = mask.add(strokes[n]);
    if (!painted) return Error{painted.error().code, name + ": " + painted.error().message};
    if (!painted->covers_any) {
      return Error{
          ErrorCode::kUsage,
          name + ": expected at least one voxel of the volume under the stroke, found none"};
    }
  }
  std::vector<std::size_t> shown, hidden;
  for (std::size_t voxel = 0; voxel < mask.bits().size(); ++voxel) {
    if (mask.bits()[voxel] == ScribbleMask::kShowBit) shown.push_back(voxel);
    if (mask.bits()[voxel] == ScribbleMask::kHideBit) hidden.push_back(voxel);
  }
  ScribbleOutcome outcome{predicates.model.histogram, shown.size(), hidden.size()};
  const auto show = render::count_true(*set, shown);
  const auto hide = render::count_true(*set, hidden);
  outcome.histogram.scribble(show, hide, share);
  constexpr double kChange = 1e-9;
  outcome.decisive =
      !std::ranges::equal(outcome.histogram.bars(), predicates.model.histogram.bars(),
                          [](const auto& a, const auto& b) {
                            return std::abs(a.importance - b.importance) <= kChange;
                          });
  return outcome;
}

}  // namespace nav::app
