// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/transform_tree.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <deque>
#include <map>
#include <sstream>

namespace nav::io {

namespace {

/// Inverse of a matrix, or nothing when it is not invertible.
std::optional<Eigen::Matrix4d> inverse_of(const Eigen::Matrix4d& m) {
  if (!m.allFinite()) return {};
  const Eigen::FullPivLU<Eigen::Matrix4d> lu(m);
  if (!lu.isInvertible()) return {};
  return Eigen::Matrix4d(lu.inverse());
}

/// Worse of two statuses: ok, then unknown, then the statuses without a pose; the first of these is
/// returned.
TrackingStatus worse(TrackingStatus a, TrackingStatus b) {
  const auto rank = [](TrackingStatus s) {
    return s == TrackingStatus::kOk ? 0 : s == TrackingStatus::kUnknown ? 1 : 2;
  };
  return rank(b) > rank(a) ? b : a;
}

std::string edge_name(const std::string& from, const std::string& to) { return from + "To" + to; }

/// True when two matrices are inverse to each other within the rounding of a rotation to four
/// decimals.
bool are_inverse(const Eigen::Matrix4d& a, const Eigen::Matrix4d& b) {
  constexpr double kRounding = 1e-4;
  const auto largest = [](const auto& block) { return block.cwiseAbs().maxCoeff(); };
  const double turn_a = largest(a.topLeftCorner<3, 3>());
  const double turn_b = largest(b.topLeftCorner<3, 3>());
  const double shift_a = largest(a.topRightCorner<3, 1>());
  const double shift_b = largest(b.topRightCorner<3, 1>());
  const Eigen::Matrix4d left = a * b - Eigen::Matrix4d::Identity();
  return largest(left.topLeftCorner<3, 3>()) <= kRounding * 3 * turn_a * turn_b &&
         largest(left.topRightCorner<3, 1>()) <= kRounding * (3 * turn_a * shift_b + shift_a);
}

bool is_claimed(const NamedTransform& transform) {
  return transform.status == TrackingStatus::kOk || transform.status == TrackingStatus::kUnknown;
}

/// Rejects a pose that contradicts the pose of the opposite direction in the same sequence frame.
/// Poses with an invalid status are not compared.
Result<void> check_reverse(const SequenceImage& frame, const NamedTransform& pose) {
  const auto ends = split_transform_name(pose.name);
  if (!ends || !is_claimed(pose)) return {};
  const auto reverse = transform(frame, edge_name(ends->second, ends->first));
  if (!reverse || !is_claimed(*reverse)) return {};
  if (are_inverse(pose.to_from_from, reverse->to_from_from)) return {};
  return Error{ErrorCode::kMalformedData,
               "frame " + std::to_string(frame.index) + ": " + pose.name + "Transform and " +
                   reverse->name +
                   "Transform: expected each other's inverse, found two that differ"};
}

}  // namespace

std::optional<std::pair<std::string, std::string>> split_transform_name(std::string_view name) {
  const auto starts_name = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); };
  std::optional<std::pair<std::string, std::string>> found;
  for (auto at = name.find("To", 1); at != std::string_view::npos; at = name.find("To", at + 1)) {
    if (at + 2 >= name.size() || !starts_name(name[at + 2])) continue;
    if (found) return {};  // The name could be split in two ways, such as "AToBToC".
    found.emplace(name.substr(0, at), name.substr(at + 2));
  }
  return found;
}

Result<TransformTree> TransformTree::create(const std::vector<std::string>& frame_transforms,
                                            const std::vector<CoordinateDefinition>& definitions) {
  TransformTree tree;
  for (const std::string& name : frame_transforms) {
    const auto ends = split_transform_name(name);
    if (!ends || ends->first == ends->second) continue;
    tree.edges_.push_back(
        {ends->first, ends->second, true, Eigen::Matrix4d::Constant(std::nan(""))});
  }
  for (const CoordinateDefinition& definition : definitions) {
    if (!inverse_of(definition.to_from_from)) {
      std::ostringstream found;
      found << definition.to_from_from.reshaped<Eigen::RowMajor>().transpose();
      return Error{ErrorCode::kMalformedData,
                   "configuration transform " + edge_name(definition.from, definition.to) +
                       ": expected a finite matrix that can be inverted, found " + found.str()};
    }
    for (const Edge& edge : tree.edges_) {
      if (edge.from_frame || edge.from != definition.to || edge.to != definition.from) continue;
      if (are_inverse(edge.to_from_from, definition.to_from_from)) continue;
      return Error{ErrorCode::kMalformedData,
                   "configuration transforms " + edge_name(edge.from, edge.to) + " and " +
                       edge_name(edge.to, edge.from) +
                       ": expected each other's inverse, found two that differ"};
    }
    tree.edges_.push_back({definition.from, definition.to, false, definition.to_from_from});
  }
  return tree;
}

std::string TransformTree::describe() const {
  std::string text;
  for (const Edge& edge : edges_) {
    text += (text.empty() ? "" : ", ") + edge.from + "→" + edge.to +
            (edge.from_frame ? " (frames)" : " (configuration)");
  }
  return text.empty() ? "nothing" : text;
}

std::vector<std::pair<ChainLink, Chain>> TransformTree::loops(
    const std::set<std::string>& first) const {
  TransformTree open;  // Without loops.
  std::vector<std::pair<ChainLink, Chain>> loops;
  for (const bool preferred : {true, false}) {
    for (const Edge& edge : edges_) {
      const std::string name = edge_name(edge.from, edge.to);
      if (first.contains(name) != preferred) continue;
      auto other = open.find(edge.from, edge.to);
      if (!other) {
        open.edges_.push_back(edge);
        continue;
      }
      const bool reverse =
          other->links.size() == 1 && edge.from_frame && other->links.front().from_frame;
      if (!reverse) {
        loops.emplace_back(ChainLink{name, edge.from_frame, false, edge.to_from_from},
                           *std::move(other));
      }
    }
  }
  return loops;
}

Result<Chain> TransformTree::find(const std::string& from, const std::string& to) const {
  struct Step {
    const Edge* edge;
    bool inverted;
    std::string before;
  };
  std::map<std::string, Step> reached = {{from, {nullptr, false, ""}}};
  std::deque<std::string> queue = {from};
  while (!queue.empty() && reached.count(to) == 0) {
    const std::string here = queue.front();
    queue.pop_front();
    for (const Edge& edge : edges_) {  // Edges of frames come first: they take precedence.
      for (const bool inverted : {false, true}) {
        const std::string& start = inverted ? edge.to : edge.from;
        const std::string& end = inverted ? edge.from : edge.to;
        if (start != here || reached.count(end) != 0) continue;
        reached.emplace(end, Step{&edge, inverted, here});
        queue.push_back(end);
      }
    }
  }
  if (reached.count(to) == 0) {
    return Error{ErrorCode::kNotFound, "no transform from " + from + " to " + to +
                                           ": expected a chain between them, known: " + describe()};
  }
  Chain chain{from, to, {}};
  for (std::string at = to; reached.at(at).edge != nullptr; at = reached.at(at).before) {
    const auto& [edge, inverted, before] = reached.at(at);
    ChainLink link{edge_name(edge->from, edge->to), edge->from_frame, inverted, edge->to_from_from};
    if (inverted && !edge->from_frame) link.step = *inverse_of(edge->to_from_from);
    chain.links.insert(chain.links.begin(), std::move(link));
  }
  return chain;
}

Result<NamedTransform> Chain::evaluate(const SequenceImage& frame) const {
  NamedTransform out{edge_name(from, to), Eigen::Matrix4d::Identity(), TrackingStatus::kOk};
  for (const ChainLink& link : links) {
    Eigen::Matrix4d step = link.step;
    if (link.from_frame) {
      const auto found = transform(frame, link.name);
      if (!found) return found.error();
      if (const auto ok = check_reverse(frame, *found); !ok) return ok.error();
      out.status = worse(out.status, found->status);
      step = found->to_from_from;
      if (link.inverted && step.allFinite()) {
        const auto inverse = inverse_of(step);
        if (!inverse && is_claimed(*found)) {
          return Error{ErrorCode::kMalformedData,
                       "frame " + std::to_string(frame.index) + ": " + link.name +
                           "Transform: expected a matrix that can be inverted"};
        }
        step = inverse.value_or(Eigen::Matrix4d::Constant(std::nan("")));
      }
    }
    out.to_from_from = step * out.to_from_from;
  }
  return out;
}

Result<ImageCalibration> calibration_from_matrix(const Eigen::Matrix4d& probe_from_pixels,
                                                 int width, int height) {
  const auto reject = [](const std::string& expected, const auto& found) {
    std::ostringstream text;
    text << "ImageToProbe: expected " << expected << ", found " << found;
    return Error{ErrorCode::kMalformedData, text.str()};
  };
  if (width < 1 || height < 1) {
    return reject("an image with pixels", std::to_string(width) + " x " + std::to_string(height));
  }
  // Columns, rows, origin. The third column does not describe the plane.
  Eigen::Matrix<double, 4, 3> used;
  used << probe_from_pixels.col(0), probe_from_pixels.col(1), probe_from_pixels.col(3);
  if (!used.allFinite()) return reject("finite numbers", used.reshaped().transpose());
  constexpr double kLastRowTolerance = 1e-6;
  const Eigen::RowVector3d affine(0, 0, 1);
  if ((used.row(3) - affine).cwiseAbs().maxCoeff() > kLastRowTolerance) {
    return reject("the last row 0 0 0 1", probe_from_pixels.row(3));
  }
  const Eigen::Vector3d along_columns = used.col(0).head<3>();
  const Eigen::Vector3d along_rows = used.col(1).head<3>();
  constexpr double kMinSpacingMm = 1e-4;
  if (along_columns.norm() < kMinSpacingMm || along_rows.norm() < kMinSpacingMm) {
    return reject("pixels of at least 1e-4 mm",
                  Eigen::RowVector2d(along_columns.norm(), along_rows.norm()));
  }
  const Eigen::Vector3d x = along_columns.normalized();
  PixelGrid grid;
  // The shear is the deviation of the row step from the normal of the columns. It stays in the
  // grid.
  const Eigen::Vector3d across = along_rows - x.dot(along_rows) * x;
  grid.mm_per_pixel << along_columns.norm(), x.dot(along_rows), 0, across.norm();
  const double middle = 0.5 * (width - 1);
  grid.origin_mm << -middle * along_columns.norm(), 0;
  if (const auto ok = validate(grid); !ok) {
    return Error{ok.error().code, "ImageToProbe: " + ok.error().message};
  }
  const Eigen::Vector3d y = across.normalized();
  Eigen::Matrix3d axes;
  axes << x, y, x.cross(y);
  return ImageCalibration{
      Transform<frames::Probe, frames::Image>(Eigen::Quaterniond(axes).normalized(),
                                              used.col(2).head<3>() + middle * along_columns),
      grid};
}

std::optional<Finding> other_tip(const TransformTree& tree, const std::string& needle,
                                 const SequenceImage& frame) {
  constexpr double kSamePlaceMm = 5;
  const std::string tip = needle + "Tip";
  const auto chain = tree.find(tip, needle);
  if (!chain) return std::nullopt;
  const auto found = chain->evaluate(frame);
  if (!found) return std::nullopt;
  const double mm = found->to_from_from.topRightCorner<3, 1>().norm();
  if (!(mm > kSamePlaceMm)) return std::nullopt;
  std::ostringstream distance;
  distance << tip << " lies " << std::lround(mm) << " mm from " << needle;
  return Finding{.subject = "needle",
                 .key = "tip (--needle-frame)",
                 .values = {"the origin of " + needle + " is taken as the tip", distance.str()},
                 .used = needle + "; if it is the hub, name " + tip};
}

std::optional<Finding> tip_of_another_unit(const Eigen::Matrix4d& body_from_tip,
                                           const std::string& name) {
  constexpr double kLeastMm = 1;
  constexpr double kMostMm = 2000;
  const double mm = body_from_tip.topRightCorner<3, 1>().norm();
  if (mm == 0 || (mm >= kLeastMm && mm <= kMostMm)) return std::nullopt;
  std::ostringstream distance;
  distance << mm << " mm from the body (is it in " << (mm < kLeastMm ? "metres" : "micrometres")
           << "?)";
  return Finding{.subject = "needle",
                 .key = "unit of " + name,
                 .values = {distance.str()},
                 .used = "millimetres"};
}

}  // namespace nav::io
