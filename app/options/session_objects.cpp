// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_objects.hpp"

namespace nav::app {
namespace {

using Type = CutawayObject::Type;

toml::array array_of(const Eigen::Vector3d& v) { return toml::array{v.x(), v.y(), v.z()}; }

void read_box(Section& one, CutawayObject& box) {
  // Missing values are NaN, which validate() rejects together with impossible values.
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> centre(3, kNone);
  std::vector<double> edges(9, kNone);
  one.numbers("centre_mm", 3, centre);
  one.numbers("half_edges_mm", 9, edges);
  box.centre_ct = Eigen::Map<const Eigen::Vector3d>(centre.data());
  box.half_edges_ct = Eigen::Map<const Eigen::Matrix3d>(edges.data());
}

}  // namespace

void read_cutaway_list(Section& root, const char* key, Settings& settings) {
  const toml::array* list = root.tables(key);
  if (list == nullptr) return;
  auto& objects = settings.config.cutaway_objects;
  for (const toml::node& element : *list) {
    const std::string name = "cutaway_objects[" + std::to_string(objects.size()) + "]";
    Section one = root.inside(name, element.as_table());
    CutawayObject object;
    std::string type = "none";
    one.text("type", type);
    if (type == "box") {
      read_box(one, object);
    } else if (type == "polygon") {
      object.type = Type::kPolygon;
      one.points("vertices_mm", object.vertices_ct);
    } else if (type == "mesh") {
      object.type = Type::kMesh;
      one.path("file", object.file);
    } else {
      root.stop_at(element, name + ".type: expected box, polygon or mesh, found " + type);
    }
    one.finish();
    objects.push_back(std::move(object));
  }
}

void write_cutaway_list(KeyWriter& writer, const char* key, const Settings& settings) {
  toml::array list;
  for (const CutawayObject& object : settings.config.cutaway_objects) {
    toml::table table;
    if (object.type == Type::kBox) {
      toml::array edges;
      for (const double x : object.half_edges_ct.reshaped()) edges.push_back(x);
      table.insert("type", "box");
      table.insert("centre_mm", array_of(object.centre_ct));
      table.insert("half_edges_mm", std::move(edges));
    } else if (object.type == Type::kPolygon) {
      toml::array vertices;
      for (const auto& v : object.vertices_ct) vertices.push_back(array_of(v));
      table.insert("type", "polygon");
      table.insert("vertices_mm", std::move(vertices));
    } else {
      table.insert("type", "mesh");
      table.insert("file", writer.path(object.file));
    }
    list.push_back(std::move(table));
  }
  if (!list.empty()) writer.table.insert(key, std::move(list));
}

}  // namespace nav::app
