// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/surface_file.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPLYReader.h>
#include <vtkPolyData.h>
#include <vtkPolyDataReader.h>
#include <vtkSTLReader.h>
#include <vtkSmartPointer.h>

#include "io/atomic_file.hpp"
#include "io/detail/text.hpp"
#include "io/detail/vtk_errors.hpp"

namespace nav::io {
namespace {

constexpr std::uint64_t kMaxTextBytes = 256 << 20;

Error malformed(const std::filesystem::path& path, const std::string& expected,
                const std::string& found) {
  return {ErrorCode::kMalformedData, path.string() + ": expected " + expected + ", found " + found};
}

template <class Reader>
Result<vtkSmartPointer<vtkPolyData>> run(const std::filesystem::path& path) {
  detail::VtkErrors errors;
  vtkNew<Reader> reader;
  errors.watch(reader);
  reader->SetFileName(path.c_str());
  errors.run([&] { reader->Update(); });
  if (!errors.first().empty()) return malformed(path, "a surface", errors.first());
  return vtkSmartPointer<vtkPolyData>(reader->GetOutput());
}

Result<vtkSmartPointer<vtkPolyData>> poly_data(const std::filesystem::path& path) {
  const std::string ending = path.extension().string();
  if (detail::equals_ignoring_case(ending, ".vtk")) return run<vtkPolyDataReader>(path);
  if (detail::equals_ignoring_case(ending, ".stl")) return run<vtkSTLReader>(path);
  if (detail::equals_ignoring_case(ending, ".ply")) return run<vtkPLYReader>(path);
  return Error{
      ErrorCode::kUnsupportedData,
      path.string() + ": expected a surface as .vtk, .stl or .ply, found '" + ending + "'"};
}

}  // namespace

Result<TriangleMesh> read_surface(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    return Error{ErrorCode::kNotFound, path.string() + ": expected a surface, found no file"};
  }
  const auto data = poly_data(path);
  if (!data) return data.error();
  vtkPolyData& poly = **data;
  TriangleMesh mesh{{}, {}, path.string()};
  for (vtkIdType i = 0; i < poly.GetNumberOfPoints(); ++i) {
    mesh.points_mm.emplace_back(Eigen::Map<const Eigen::Vector3d>(poly.GetPoint(i)));
  }
  vtkIdType count = 0;
  const vtkIdType* ids = nullptr;
  for (poly.GetPolys()->InitTraversal(); poly.GetPolys()->GetNextCell(count, ids) != 0;) {
    if (count > 0 && std::any_of(ids, ids + count, [&](vtkIdType id) {
          return id < 0 || id >= poly.GetNumberOfPoints();
        })) {
      return malformed(path,
                       "polygons of its " + std::to_string(poly.GetNumberOfPoints()) + " points",
                       "other points");
    }
    for (vtkIdType i = 2; i < count; ++i) {
      mesh.triangles.push_back(
          {static_cast<int>(ids[0]), static_cast<int>(ids[i - 1]), static_cast<int>(ids[i])});
    }
  }
  if (mesh.triangles.empty()) return malformed(path, "polygons", "none");
  return mesh;
}

Result<std::vector<std::vector<Eigen::Vector3d>>> read_point_groups(
    const std::filesystem::path& path) {
  const auto text = read_file(path, kMaxTextBytes);
  if (!text) return text.error();
  std::vector<std::vector<Eigen::Vector3d>> groups;
  bool within = false;
  int number = 0;
  std::istringstream stream(*text);
  for (std::string line; std::getline(stream, line);) {
    ++number;
    std::replace(line.begin(), line.end(), ',', ' ');
    const auto trimmed = detail::trim(line);
    if (!trimmed.empty() && trimmed.front() == '#') continue;
    if (trimmed.empty()) {
      within = false;
      continue;
    }
    const auto numbers = detail::parse_doubles(trimmed);
    const bool finite = numbers && std::all_of(numbers->begin(), numbers->end(),
                                               [](double x) { return std::isfinite(x); });
    if (!finite || numbers->size() != 3) {
      return Error{ErrorCode::kMalformedData, path.string() + ":" + std::to_string(number) +
                                                  ": expected three finite numbers, found '" +
                                                  detail::excerpt(trimmed) + "'"};
    }
    if (!within) groups.emplace_back();
    within = true;
    groups.back().emplace_back((*numbers)[0], (*numbers)[1], (*numbers)[2]);
  }
  if (groups.empty()) return malformed(path, "points", "none");
  return groups;
}

}  // namespace nav::io
