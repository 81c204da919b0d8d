// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <cstdint>
#include <string_view>
#include <vtkCellArray.h>
#include <vtkExecutive.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkSTLReader.h>

#include "io/detail/surface_cursor.hpp"
#include "io/detail/text.hpp"
#include "io/detail/vtk_errors.hpp"

namespace nav::io::detail {
namespace {

/// True if the beginning of the file is text by the rule of the library, which reads every other
/// file as binary, whatever its first word: less than a twentieth of 256 bytes are no ASCII.
bool begins_as_text(std::string_view content) {
  constexpr std::size_t kBeginning = 256;
  constexpr std::size_t kMostOthers = 20;
  const std::string_view head = content.substr(0, kBeginning);
  std::size_t others = 0;
  for (const char c : head) {
    const auto byte = static_cast<unsigned char>(c);
    const bool text = (byte >= 0x20 && byte <= 0x7f) || c == '\n' || c == '\r' || c == '\t';
    if (!text) ++others;
  }
  return others * kMostOthers < head.size();
}

/// Rejects a truncated STL file, which VTK reads as a smaller surface.
Result<void> check_whole_stl(const std::filesystem::path& path, std::string_view text) {
  constexpr std::size_t kHead = 512;
  const auto head_has = [&](std::string_view word) {
    return text.substr(0, kHead).find(word) != std::string_view::npos;
  };
  const auto no_facets = [&] { return malformed_surface(path, "facets", "none"); };
  const bool solid = text.starts_with("solid");
  const bool facets_follow = head_has("FACET") || head_has("facet normal");
  if (!solid && equals_ignoring_case(text.substr(0, 5), "solid") && facets_follow) {
    return malformed_surface(path, "ASCII STL in small letters (solid, facet, vertex)",
                             std::string(text.substr(0, 5)));
  }
  if (solid && !head_has("facet") && head_has("endsolid")) return no_facets();
  if (solid && head_has("facet")) {
    if (!begins_as_text(text))
      return malformed_surface(path, "ASCII STL", "bytes that are no text");
    if (text.rfind("endsolid") != std::string_view::npos) return {};
    return malformed_surface(path, "endsolid", "the end of the file before it");
  }
  if (!solid && head_has("facet normal") && begins_as_text(text)) {
    return malformed_surface(path, "solid at the beginning of an ASCII STL",
                             excerpt(text.substr(0, text.find('\n'))));
  }
  constexpr std::size_t kHeader = 84;
  constexpr std::size_t kFacet = 50;
  if (text.size() < kHeader) {
    return malformed_surface(path, "STL, a header of 84 bytes", std::to_string(text.size()));
  }
  std::uint32_t facets = 0;  // Little-endian.
  for (std::size_t i = 4; i > 0; --i) {
    facets = facets << 8U | static_cast<unsigned char>(text[kHeader - 5 + i]);
  }
  if (facets == 0) return no_facets();
  if (text.size() - kHeader == kFacet * facets) return {};
  if (text.size() - kHeader > kFacet * facets) {
    return malformed_surface(path,
                             std::to_string(kHeader + kFacet * facets) + " bytes for its " +
                                 std::to_string(facets) + " facets",
                             std::to_string(text.size()));
  }
  return malformed_surface(path, std::to_string(facets) + " facets",
                           std::to_string((text.size() - kHeader) / kFacet));
}

}  // namespace

Result<TriangleMesh> read_stl(const std::filesystem::path& path, std::string_view content) {
  if (const auto ok = check_whole_stl(path, content); !ok) return ok.error();
  VtkErrors errors;
  vtkNew<vtkSTLReader> reader;
  errors.watch(reader);
  errors.watch(reader->GetExecutive());  // Reports the reader's failure again.
  reader->SetFileName(path.c_str());
  errors.run([&] { reader->Update(); });
  if (!errors.first().empty()) {
    constexpr std::string_view kWhere = " at line ";
    const std::string& said = errors.first();  // Names its own parts, and may have several lines.
    const auto at = said.find(kWhere);
    std::string line;
    for (std::size_t i = at + kWhere.size(); at != said.npos && i < said.size(); ++i) {
      if (said[i] < '0' || said[i] > '9') break;
      line += said[i];
    }
    return malformed_surface(path, "solid, facets and vertices of three numbers",
                             "other text" + (line.empty() ? "" : " at line " + line));
  }
  vtkPolyData& poly = *reader->GetOutput();
  MeshBuilder mesh(path);
  for (vtkIdType i = 0; i < poly.GetNumberOfPoints(); ++i) {
    mesh.add_point(Eigen::Map<const Eigen::Vector3d>(poly.GetPoint(i)));
  }
  vtkIdType count = 0;
  const vtkIdType* ids = nullptr;
  for (poly.GetPolys()->InitTraversal(); poly.GetPolys()->GetNextCell(count, ids) != 0;) {
    mesh.add_polygon(std::vector<std::int64_t>(ids, ids + count));
  }
  return std::move(mesh).take();
}

}  // namespace nav::io::detail
