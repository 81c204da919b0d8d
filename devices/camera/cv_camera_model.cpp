// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "devices/camera/cv_camera_model.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <opencv2/calib3d.hpp>

namespace nav::devices {
namespace {

constexpr std::uintmax_t kMostCameraBytes = 1 << 20;
constexpr int kLargestSide = 16384;

/// Reads the keys of a calibration; the first problem is kept.
class CameraKeys {
 public:
  CameraKeys(const cv::FileStorage& storage, std::string file)
      : storage_(storage), file_(std::move(file)) {}

  void side(const char* key, int& value) {
    const cv::FileNode node = storage_[key];
    if (!node.isInt()) return fail(key, "a whole number of pixels", node);
    value = static_cast<int>(node);
    if (value < 1 || value > kLargestSide) {
      fail(key, "1 to " + std::to_string(kLargestSide) + " pixels", std::to_string(value));
    }
  }
  cv::Mat numbers(const char* key, const std::string& expected) {
    const cv::FileNode node = storage_[key];
    cv::Mat found;
    if (node.isMap()) node >> found;
    if (found.empty() || found.channels() != 1) {
      fail(key, expected, node);
      return {};
    }
    cv::Mat doubles;
    found.convertTo(doubles, CV_64F);
    if (!cv::checkRange(doubles)) {
      fail(key, "finite numbers", "others");
      return {};
    }
    return doubles;
  }
  void fail(const char* key, const std::string& expected, const std::string& found) {
    if (error_) return;
    error_ = Error{ErrorCode::kMalformedData,
                   file_ + ": " + key + ": expected " + expected + ", found " + found};
  }
  void fail(const char* key, const std::string& expected, const cv::FileNode& node) {
    fail(key, expected, node.empty() ? "nothing" : "something else");
  }
  [[nodiscard]] const std::optional<Error>& error() const { return error_; }

 private:
  const cv::FileStorage& storage_;
  std::string file_;
  std::optional<Error> error_;
};

std::string size_of(const cv::Mat& matrix) {
  return std::to_string(matrix.rows) + " x " + std::to_string(matrix.cols) + " numbers";
}

Result<CvCameraModel> model_of(const cv::FileStorage& storage, const std::string& name) {
  CvCameraModel model;
  model.file = name;
  CameraKeys keys(storage, name);
  keys.side("image_width", model.size.width);
  keys.side("image_height", model.size.height);
  const cv::Mat matrix = keys.numbers("camera_matrix", "a matrix of 3 x 3 numbers");
  const cv::Mat distortion =
      keys.numbers("distortion_coefficients", "a matrix of 4, 5, 8, 12 or 14 numbers");
  if (keys.error()) return *keys.error();
  if (matrix.rows != 3 || matrix.cols != 3) {
    keys.fail("camera_matrix", "a matrix of 3 x 3 numbers", size_of(matrix));
    return *keys.error();
  }
  model.matrix = matrix;
  const cv::Matx33d& k = model.matrix;
  const bool focal = k(0, 0) > 0 && k(1, 1) > 0 && k(0, 0) < 1e6 && k(1, 1) < 1e6;
  const bool shape = k(0, 1) == 0 && k(1, 0) == 0 && k(2, 0) == 0 && k(2, 1) == 0 && k(2, 2) == 1;
  if (!focal || !shape) {
    keys.fail("camera_matrix", "[fx 0 cx; 0 fy cy; 0 0 1] with fx and fy above 0", "other numbers");
  }
  constexpr std::array kCounts = {4, 5, 8, 12, 14};
  const int count = distortion.rows * distortion.cols;
  const bool line = distortion.rows == 1 || distortion.cols == 1;
  if (!line || std::ranges::count(kCounts, count) == 0) {
    keys.fail("distortion_coefficients", "a matrix of 4, 5, 8, 12 or 14 numbers",
              size_of(distortion));
  }
  if (keys.error()) return *keys.error();
  model.distortion.assign(distortion.begin<double>(), distortion.end<double>());
  return model;
}

}  // namespace

std::vector<cv::Point2d> CvCameraModel::directions(const std::vector<cv::Point2d>& pixels) const {
  std::vector<cv::Point2d> found;
  if (pixels.empty()) return found;
  cv::undistortPoints(pixels, found, matrix, distortion, cv::noArray(), cv::noArray(),
                      cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 50, 1e-12));
  return found;
}

std::vector<cv::Point2d> CvCameraModel::pixels(const std::vector<cv::Point2d>& directions) const {
  std::vector<cv::Point2d> found;
  if (directions.empty()) return found;
  std::vector<cv::Point3d> points;
  for (const cv::Point2d& one : directions) points.emplace_back(one.x, one.y, 1.0);
  cv::projectPoints(points, cv::Vec3d(0, 0, 0), cv::Vec3d(0, 0, 0), matrix, distortion, found);
  return found;
}

Result<CvCameraModel> read_camera_model(const std::filesystem::path& file) {
  const std::string name = file.string();
  std::error_code status;
  if (!std::filesystem::is_regular_file(file, status)) {
    return Error{ErrorCode::kNotFound,
                 name + ": expected the calibration of the camera, found no such file"};
  }
  const auto bytes = std::filesystem::file_size(file, status);
  if (status || bytes > kMostCameraBytes) {
    return Error{ErrorCode::kMalformedData,
                 name + ": expected a calibration of at most 1 MiB, found another file"};
  }
  std::ifstream stream(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (!stream) return Error{ErrorCode::kIo, name + ": could not be read"};
  try {
    const cv::FileStorage storage(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    if (storage.isOpened()) return model_of(storage, name);
  } catch (const cv::Exception&) {  // Its sentence is about the library.
  }
  return Error{ErrorCode::kMalformedData,
               name +
                   ": expected a YAML, XML or JSON file of OpenCV (%YAML:1.0), found another "
                   "content"};
}

}  // namespace nav::devices
