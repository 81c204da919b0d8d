// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkGenericCell.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStaticCellLocator.h>

#include "io/surface_file.hpp"
#include "registration/landmarks/landmarks.hpp"
#include "registration/shape/shape_registration.hpp"
#include "tests/registration/synthetic.hpp"
#include "tests/support/matchers.hpp"
#include "tests/support/test_data.hpp"

/// Tests with the pelvis phantom of the UCL course MPHY0026 (CC BY): real optical tracking and a
/// real CT.
namespace nav::registration {
namespace {

using Pose = Transform<frames::Ct, frames::Reference>;

// The published residual, rounded up.
constexpr double kPublishedFreMm = 0.435;

std::vector<Point<frames::Reference>> points_of(const std::filesystem::path& path) {
  std::vector<Point<frames::Reference>> out;
  const auto groups = io::read_point_groups(path);
  EXPECT_TRUE(test::has_value(groups));
  if (!groups) return out;
  for (const auto& group : *groups) {
    for (const auto& p : group) out.push_back({p});
  }
  return out;
}

/// Exact distances to the triangles, computed by VTK and independent of the registration.
class ExactSurface {
 public:
  explicit ExactSurface(const TriangleMesh& mesh) {
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    for (const auto& p : mesh.points_mm) points->InsertNextPoint(p.data());
    vtkNew<vtkCellArray> cells;
    for (const auto& t : mesh.triangles) {
      const std::array<vtkIdType, 3> ids{t[0], t[1], t[2]};
      cells->InsertNextCell(3, ids.data());
    }
    poly_->SetPoints(points);
    poly_->SetPolys(cells);
    locator_->SetDataSet(poly_);
    locator_->BuildLocator();
  }
  double mean_mm(const std::vector<Point<frames::Reference>>& points, const Pose& pose) {
    double sum = 0;
    vtkNew<vtkGenericCell> cell;
    for (const auto& p : points) {
      Eigen::Vector3d closest;
      vtkIdType id = 0;
      int part = 0;
      double d2 = 0;
      locator_->FindClosestPoint((pose * p).mm.data(), closest.data(), cell, id, part, d2);
      sum += std::sqrt(d2) / static_cast<double>(points.size());
    }
    return sum;
  }

 private:
  vtkNew<vtkPolyData> poly_;
  vtkNew<vtkStaticCellLocator> locator_;
};

double mean_to_corners_mm(const TriangleMesh& mesh,
                          const std::vector<Point<frames::Reference>>& points, const Pose& pose) {
  double sum = 0;
  for (const auto& p : points) {
    const Eigen::Vector3d q = (pose * p).mm;
    double least = 1e300;
    for (const auto& corner : mesh.points_mm) least = std::min(least, (corner - q).squaredNorm());
    sum += std::sqrt(least) / static_cast<double>(points.size());
  }
  return sum;
}

struct Pelvis {
  std::vector<Point<frames::Reference>> touched;
  std::vector<LandmarkPair> landmarks;
  TriangleMesh mesh;
  Pose authors;

  static Result<Pelvis> read(const std::filesystem::path& folder) {
    auto mesh = io::read_surface(folder / "pelvis_cropped_decimated.vtk");
    if (!mesh) return mesh.error();
    // The lists of the fiducials in the two frames have different orders.
    const auto tracked = points_of(folder / "Tracker_Fiducial_Markers.txt");
    const auto marked = points_of(folder / "pelvis_cropped_ct_fiducial_markers.txt");
    if (tracked.size() != 4 || marked.size() != 4) {
      return Error{ErrorCode::kMalformedData, "fiducials: expected 4"};
    }
    std::vector<LandmarkPair> pairs;
    for (std::size_t i = 0; i < 4; ++i) {
      pairs.push_back({std::to_string(i), tracked[i], {marked[i].mm}, 0.5});
    }
    Eigen::Matrix4d matrix;
    std::ifstream file(folder / "Tracker_to_pelvis_cropped_with_icp.txt");
    for (Eigen::Index i = 0; i < 16; ++i) file >> matrix(i / 4, i % 4);
    const auto authors = rigid_from_matrix<frames::Ct, frames::Reference>(matrix);
    if (!authors) return authors.error();
    return Pelvis{points_of(folder / "Tracker_Surface_Scan.txt"), pairs, std::move(*mesh),
                  *authors};
  }
};

TEST(PelvisTest, LandmarksReachThePublishedResidual) {
  SONDE_REQUIRE_DATA(folder, "ucl-pelvis");
  const auto pelvis = Pelvis::read(folder);
  ASSERT_TRUE(test::has_value(pelvis));
  const auto fit = register_landmarks(pelvis->landmarks);
  ASSERT_TRUE(test::has_value(fit));
  EXPECT_LT(fit->fre_rms_mm, kPublishedFreMm);
}

TEST(PelvisTest, TheSurfaceRefinesFrom30MillimetresAnd20Degrees) {
  SONDE_REQUIRE_DATA(folder, "ucl-pelvis");
  const auto pelvis = Pelvis::read(folder);
  ASSERT_TRUE(test::has_value(pelvis));
  const auto fit = register_landmarks(pelvis->landmarks);
  ASSERT_TRUE(test::has_value(fit));
  ExactSurface exact(pelvis->mesh);
  const double by_landmarks = exact.mean_mm(pelvis->touched, fit->ct_from_reference);
  const double by_authors = exact.mean_mm(pelvis->touched, pelvis->authors);
  std::cout << "mean distance: landmarks " << by_landmarks << " mm, authors' ICP " << by_authors
            << " mm\n";
  // The published 2.6 mm are distances to the vertices of the mesh. The published matrix must give
  // them.
  const double published = mean_to_corners_mm(pelvis->mesh, pelvis->touched, pelvis->authors);
  EXPECT_NEAR(published, 2.6, 0.1);
  const auto field = ShapeField::create(*surface_shape(pelvis->mesh, 3));
  ASSERT_TRUE(test::has_value(field));
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  for (const auto& p : pelvis->touched) {
    centre += (fit->ct_from_reference * p).mm / static_cast<double>(pelvis->touched.size());
  }
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const Pose start = test::off_by(fit->ct_from_reference, 30, 20 * M_PI / 180, seed, centre);
    const auto result = register_points(pelvis->touched, *field, start);
    ASSERT_TRUE(test::has_value(result));
    const double mean = exact.mean_mm(pelvis->touched, result->ct_from_reference);
    std::cout << "start " << seed << ": mean " << mean << " mm (own " << result->after.mean_mm
              << "), median " << result->after.median_mm << ", margin "
              << result->margin.value_or(-1) << ", sliding " << result->sliding.size() << '\n';
    EXPECT_LT(mean, by_authors) << seed;
    if (seed == 1) {
      EXPECT_LT(mean_to_corners_mm(pelvis->mesh, pelvis->touched, result->ct_from_reference),
                published);
    }
    EXPECT_TRUE(result->sliding.empty());
  }
}

}  // namespace
}  // namespace nav::registration
