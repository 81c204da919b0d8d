// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "nav/transform.hpp"

#include <Eigen/LU>
#include <sstream>

#include "nav/matrices.hpp"

namespace nav::detail {
namespace {

Error reject(const std::string& name, const std::string& defect) {
  return Error{ErrorCode::kMalformedData,
               name + ": expected a rigid 4 x 4 matrix, found " + defect};
}

}  // namespace

Result<Eigen::Quaterniond> rotation_from_matrix(const Eigen::Matrix4d& m, const std::string& name,
                                                const RigidTolerance& tolerance) {
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      if (!std::isfinite(m(row, column))) {
        std::ostringstream text;
        text << m(row, column) << " at row " << row + 1 << ", column " << column + 1;
        return reject(name, text.str());
      }
    }
  }
  const Eigen::RowVector4d last_row_error = m.row(3) - Eigen::RowVector4d(0, 0, 0, 1);
  if (last_row_error.cwiseAbs().maxCoeff() > tolerance.last_row) {
    std::ostringstream text;
    text << "last row " << m.row(3) << " instead of 0 0 0 1";
    return reject(name, text.str());
  }
  const Eigen::Matrix3d r = m.topLeftCorner<3, 3>();
  const double defect = (r.transpose() * r - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (!(defect <= tolerance.orthonormality)) {
    std::ostringstream text;
    text << "a scaled or sheared one (column lengths " << r.colwise().norm()
         << ", orthonormality defect " << defect << ")";
    return reject(name, text.str());
  }
  if (r.determinant() < 0) return reject(name, "a reflection (determinant -1)");
  return Eigen::Quaterniond(nearest_orthogonal(r)).normalized();
}

}  // namespace nav::detail
