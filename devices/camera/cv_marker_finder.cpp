// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <opencv2/aruco.hpp>
#include <utility>

#include "devices/camera/cv_camera_model.hpp"
#include "devices/camera/cv_marker_corners.hpp"
#include "devices/camera/cv_planar_pose.hpp"
#include "devices/camera/marker_finder.hpp"

namespace nav::devices {
namespace {

using CvCorners = std::array<cv::Point2d, 4>;

constexpr double kLeastCellPx = 2.5;  ///< Border of a marker: narrower ones have no clear edges.

/// A tool with what does not change from image to image.
struct CvTool {
  std::vector<PlacedMarker> markers;
  std::vector<Eigen::Vector2d> corners;  ///< Corners of a chessboard.
  /// Distance from a corner of the chessboard to the next other edge, mm.
  double free_mm = 0;
};

class CvMarkerFinder final : public MarkerFinder {
 public:
  CvMarkerFinder(const MarkerFinderOptions& options, int dictionary, CvCameraModel camera)
      : camera_(std::move(camera)),
        dictionary_(cv::aruco::getPredefinedDictionary(dictionary)),
        parameters_(cv::aruco::DetectorParameters::create()) {
    parameters_->cornerRefinementMethod = cv::aruco::CORNER_REFINE_NONE;
    for (const MarkerTool& tool : options.tools) {
      tools_.push_back(
          {markers_of(tool), chessboard_corners_of(tool), 0.5 * (tool.square_mm - tool.marker_mm)});
    }
  }

  Result<std::vector<MarkerReading>> find(const Image2d<std::uint8_t>& image) override {
    if (image.width() != camera_.size.width || image.height() != camera_.size.height) {
      const auto text = [](int width, int height) {
        return std::to_string(width) + " x " + std::to_string(height) + " pixels";
      };
      return Error{ErrorCode::kUsage, camera_.file + ": expected images of " +
                                          text(camera_.size.width, camera_.size.height) +
                                          ", for which the camera was calibrated, found " +
                                          text(image.width(), image.height())};
    }
    // The matrix is only read.
    const cv::Mat pixels(image.height(), image.width(), CV_8U,
                         const_cast<std::uint8_t*>(image.pixels().data()));
    try {
      const auto seen = detect(pixels);
      std::vector<MarkerReading> readings;
      for (const CvTool& tool : tools_) readings.push_back(read(pixels, tool, seen));
      return readings;
    } catch (const cv::Exception& error) {
      return Error{ErrorCode::kUnavailable, "markers: the detector failed: " + error.err};
    }
  }

 private:
  /// Markers in an image, by number. One that is there twice, as in a mirror, is left out.
  std::map<int, CvCorners> detect(const cv::Mat& pixels) {
    std::vector<std::vector<cv::Point2f>> corners;
    std::vector<int> ids;
    cv::aruco::detectMarkers(pixels, dictionary_, corners, ids, parameters_);
    std::map<int, CvCorners> seen;
    std::vector<int> twice;
    for (std::size_t i = 0; i < ids.size(); ++i) {
      CvCorners four;
      std::ranges::copy(corners[i], four.begin());
      if (!seen.emplace(ids[i], four).second) twice.push_back(ids[i]);
    }
    for (const int id : twice) seen.erase(id);
    return seen;
  }

  MarkerReading read(const cv::Mat& pixels, const CvTool& tool,
                     const std::map<int, CvCorners>& seen) const {
    MarkerReading reading;
    std::vector<cv::Point3d> points;
    std::vector<cv::Point2d> directions;
    for (const PlacedMarker& marker : tool.markers) {
      const auto found = seen.find(marker.id);
      if (found == seen.end()) continue;
      ++reading.markers;
      const double cell = cell_px(found->second);
      if (cell < kLeastCellPx) continue;
      const auto corners = refine_square(pixels, camera_, found->second, cell);
      if (!corners) continue;
      for (std::size_t i = 0; i < 4; ++i) {
        points.emplace_back(marker.corners_mm[i].x(), marker.corners_mm[i].y(), 0);
        directions.push_back((*corners)[i]);
      }
    }
    auto pose = planar_pose(points, directions, camera_.focal_px());
    if (pose && !tool.corners.empty()) {
      add_chessboard(pixels, tool, *pose, points, directions);
      pose = planar_pose(points, directions, camera_.focal_px());
    }
    if (!pose) return reading;
    reading.points = static_cast<int>(points.size());
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        reading.camera_from_tool(row, column) = pose->rotation(row, column);
      }
      reading.camera_from_tool(row, 3) = pose->translation_mm[row];
    }
    reading.camera_from_tool.row(3) << 0, 0, 0, 1;
    reading.residual_px = pose->residual_px;
    reading.error_mm = pose->error_mm;
    reading.ambiguous = pose->ambiguous;
    reading.other_residual_px = pose->other_residual_px;
    return reading;
  }

  /// Adds the corners of a chessboard that are seen where a pose of its markers predicts them.
  void add_chessboard(const cv::Mat& pixels, const CvTool& tool, const CvPlanarPose& pose,
                      std::vector<cv::Point3d>& points,
                      std::vector<cv::Point2d>& directions) const {
    std::vector<cv::Point3d> corners;
    std::vector<cv::Point2d> predicted;
    std::vector<double> free_px;
    for (const Eigen::Vector2d& corner : tool.corners) {
      const cv::Vec3d at =
          pose.rotation * cv::Vec3d(corner.x(), corner.y(), 0) + pose.translation_mm;
      if (!(at[2] > 0)) continue;
      // A board is seen at a slant: across, its squares are smaller.
      const double slant = std::abs(pose.rotation.col(2).dot(at)) / cv::norm(at);
      corners.emplace_back(corner.x(), corner.y(), 0);
      predicted.emplace_back(at[0] / at[2], at[1] / at[2]);
      free_px.push_back(tool.free_mm * slant * camera_.focal_px() / at[2]);
    }
    const auto at_px = camera_.pixels(predicted);
    std::vector<cv::Point2d> found;
    std::vector<cv::Point3d> of;
    for (std::size_t i = 0; i < at_px.size(); ++i) {
      constexpr double kLeastRadiusPx = 2, kMostRadiusPx = 5;
      if (free_px[i] < kLeastRadiusPx) continue;
      const auto corner = refine_saddle(pixels, at_px[i], std::min(free_px[i], kMostRadiusPx));
      if (!corner) continue;
      found.push_back(*corner);
      of.push_back(corners[i]);
    }
    const auto seen = camera_.directions(found);
    points.insert(points.end(), of.begin(), of.end());
    directions.insert(directions.end(), seen.begin(), seen.end());
  }

  /// Width of the border of a marker along its shortest side.
  [[nodiscard]] double cell_px(const CvCorners& corners) const {
    double shortest = cv::norm(corners[3] - corners[0]);
    for (std::size_t i = 0; i < 3; ++i) {
      shortest = std::min(shortest, cv::norm(corners[i + 1] - corners[i]));
    }
    return shortest / (dictionary_->markerSize + 2);
  }

  CvCameraModel camera_;
  cv::Ptr<cv::aruco::Dictionary> dictionary_;
  cv::Ptr<cv::aruco::DetectorParameters> parameters_;
  std::vector<CvTool> tools_;
};

/// Errors come back as results: the library prints nothing.
int print_nothing(int, const char*, const char*, const char*, int, void*) { return 0; }

}  // namespace

Result<std::unique_ptr<MarkerFinder>> make_marker_finder(const MarkerFinderOptions& options) {
  if (auto ok = validate(options.tools, options.dictionary); !ok) return ok.error();
  cv::redirectError(print_nothing);
  auto camera = read_camera_model(options.camera);
  if (!camera) return camera.error();
  return std::unique_ptr<MarkerFinder>(std::make_unique<CvMarkerFinder>(
      options, marker_dictionary(options.dictionary)->number, *std::move(camera)));
}

}  // namespace nav::devices
