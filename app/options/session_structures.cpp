// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_structures.hpp"

namespace nav::app {

using session::CriticalStructure;

void read_structures(Section& root, const char* key, Settings& settings) {
  const toml::array* list = root.tables(key);
  if (list == nullptr) return;
  auto& structures = settings.config.critical_structures;
  for (const toml::node& element : *list) {
    const std::string name = "critical_structures[" + std::to_string(structures.size()) + "]";
    const toml::table& table = *element.as_table();
    Section one = root.inside(name, &table);
    CriticalStructure structure;
    one.required_text("name", structure.name);
    one.number("clearance_mm", structure.clearance_mm);
    // validate() rejects both kinds in one table, and neither.
    if (table.contains("centre_mm") || table.contains("radius_mm")) {
      std::vector<double> centre(3);
      CriticalStructure::Sphere sphere{.centre_ct = {{0, 0, 0}}};
      one.required_numbers("centre_mm", 3, centre);
      one.required_number("radius_mm", sphere.radius_mm);
      sphere.centre_ct.mm = Eigen::Map<const Eigen::Vector3d>(centre.data());
      structure.sphere = sphere;
    }
    if (table.contains("low_hu") || table.contains("high_hu")) {
      CriticalStructure::Values values;
      one.required_number("low_hu", values.low_hu);
      one.required_number("high_hu", values.high_hu);
      structure.values = values;
    }
    one.finish();
    structures.push_back(std::move(structure));
  }
}

void write_structures(KeyWriter& writer, const char* key, const Settings& settings) {
  toml::array list;
  for (const CriticalStructure& one : settings.config.critical_structures) {
    toml::table table{{"name", one.name}, {"clearance_mm", one.clearance_mm}};
    if (one.sphere) {
      const Eigen::Vector3d& centre = one.sphere->centre_ct.mm;
      table.insert("centre_mm", toml::array{centre.x(), centre.y(), centre.z()});
      table.insert("radius_mm", one.sphere->radius_mm);
    }
    if (one.values) {
      table.insert("low_hu", one.values->low_hu);
      table.insert("high_hu", one.values->high_hu);
    }
    list.push_back(std::move(table));
  }
  if (!list.empty()) writer.table.insert(key, std::move(list));
}

}  // namespace nav::app
