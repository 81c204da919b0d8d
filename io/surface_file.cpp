// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "io/surface_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string_view>
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
constexpr std::uint64_t kMaxStlBytes = 1 << 30;

Error malformed(const std::filesystem::path& path, const std::string& expected,
                const std::string& found) {
  return {ErrorCode::kMalformedData, path.string() + ": expected " + expected + ", found " + found};
}

/// VTK takes an STL file that is cut short for a smaller surface.
Result<void> check_whole_stl(const std::filesystem::path& path) {
  const auto text = read_file(path, kMaxStlBytes);
  if (!text) return text.error();
  constexpr std::size_t kHead = 512;
  const bool words = text->starts_with("solid") &&
                     std::string_view(*text).substr(0, kHead).find("facet") != std::string::npos;
  if (words) {
    if (text->rfind("endsolid") != std::string::npos) return {};
    return malformed(path, "endsolid", "the end of the file before it");
  }
  constexpr std::size_t kHeader = 84;
  constexpr std::size_t kFacet = 50;
  if (text->size() < kHeader) {
    return malformed(path, "STL, a header of 84 bytes", std::to_string(text->size()));
  }
  std::uint32_t facets = 0;  // Little-endian.
  for (std::size_t i = 4; i > 0; --i) {
    facets = facets << 8U | static_cast<unsigned char>((*text)[kHeader - 5 + i]);
  }
  if (text->size() - kHeader >= kFacet * facets) return {};
  return malformed(path, std::to_string(facets) + " facets",
                   std::to_string((text->size() - kHeader) / kFacet));
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
  if (detail::equals_ignoring_case(ending, ".stl")) {
    if (const auto ok = check_whole_stl(path); !ok) return ok.error();
    return run<vtkSTLReader>(path);
  }
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
