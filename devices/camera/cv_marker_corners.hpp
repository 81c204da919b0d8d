// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "devices/camera/cv_camera_model.hpp"

namespace nav::devices {

/// Directions of the four corners of a black square on a white ground, without distortion: lines
/// are fitted to the edges, which are found where the brightness has changed by half of its change
/// across them (by its area, so that blur moves no edge), and cut. \p corners: about where they
/// are, pixels. \p cell_px: width of the black border. Absent: an edge is hidden or has no
/// contrast.
std::optional<std::array<cv::Point2d, 4>> refine_square(const cv::Mat& image,
                                                        const CvCameraModel& camera,
                                                        std::array<cv::Point2d, 4> corners,
                                                        double cell_px);

/// Position of a corner of a chessboard, pixels: the saddle of the brightness around it. A board is
/// its own mirror image about such a corner, so that blur does not move it. \p corner: about where
/// it is. \p radius_px: of the neighbourhood that has no other edges, >= 2. Absent: there is no
/// saddle within \p radius_px.
std::optional<cv::Point2d> refine_saddle(const cv::Mat& image, cv::Point2d corner,
                                         double radius_px);

}  // namespace nav::devices
