// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

namespace nav::devices {

/// Pose of a flat pattern by its corners.
struct CvPlanarPose {
  cv::Matx33d rotation;
  cv::Vec3d translation_mm;
  double residual_px = 0;        ///< Root mean square distance of the corners.
  double error_mm = 0;           ///< Standard deviation of the origin.
  bool ambiguous = false;        ///< The other solution cannot be ruled out.
  double other_residual_px = 0;  ///< Residual of the other solution; 0: none.
};

/// Fits a pose to corners of a plane, by both solutions of IPPE (Collins and Bartoli 2014), each
/// refined by Levenberg and Marquardt. The other solution is ruled out when its squared residuals
/// exceed those of the better one by 16 times their variance (four standard deviations). The
/// variance is that of the better residuals, and at least that of 0.1 px. \p points: z = 0, mm.
/// \p directions: of the corners, without distortion. \p focal_px: from directions to pixels.
/// Absent: less than four corners, all on a line, or behind the camera.
std::optional<CvPlanarPose> planar_pose(const std::vector<cv::Point3d>& points,
                                        const std::vector<cv::Point2d>& directions,
                                        double focal_px);

}  // namespace nav::devices
