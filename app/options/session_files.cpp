// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/session_files.hpp"

namespace nav::app {

std::vector<NamedFile> session_inputs(const SessionConfig& config) {
  const PredicateOptions& predicates = config.predicates;
  std::vector<NamedFile> inputs{
      {"sweep", config.source.recording},       {"--ct", config.ct.path},
      {"--config", config.source.plus_config},  {"--registration", config.placement.registration},
      {"--appearance", config.appearance.file}, {"--us-volume", predicates.volume},
      {"--layers", predicates.layers},          {"--scan-lines", predicates.scan_lines},
      {"--scribbles", predicates.scribbles}};
  for (const auto& device : config.source.devices) {
    if (device.kind == "recording") inputs.push_back({"address of " + device.id, device.address});
    inputs.push_back({"arm of " + device.id, device.arm});
    for (const auto& body : device.bodies) {
      if (body.tool.ends_with(".rom")) inputs.push_back({"tool of " + body.name, body.tool});
    }
  }
  for (const auto& labels : predicates.labels) inputs.push_back({"--labels", labels});
  if (!render::preset_predicates(predicates.set_up)) {
    inputs.push_back({"--predicates", predicates.set_up});
  }
  for (const CutawayObject& object : config.cutaway_objects) {
    inputs.push_back({"--cutaway-mesh", object.file});
  }
  return inputs;
}

std::vector<NamedFile> files_in(const std::filesystem::path& folder,
                                const std::vector<std::string>& names) {
  std::vector<NamedFile> files;
  if (folder.empty()) return files;
  for (const std::string& name : names) files.push_back({"--out", folder / name});
  return files;
}

Result<void> reject_report_over(const std::string& json, const std::filesystem::path& folder,
                                const std::vector<NamedFile>& outputs) {
  std::vector<NamedFile> others = outputs;
  // The report may lie there twice: --json says the same.
  std::erase_if(others,
                [](const NamedFile& file) { return file.path.filename() == "report.json"; });
  if (auto ok = reject_overwriting({{"--json", json}}, others); !ok) return ok;
  const std::filesystem::path path(json);
  std::error_code failed;
  const bool inside = !folder.empty() && !json.empty() &&
                      (std::filesystem::equivalent(path.parent_path(), folder, failed) ||
                       path.parent_path().lexically_normal() == folder.lexically_normal());
  if (!inside || (path.extension() != ".png" && path.extension() != ".webp")) return {};
  return Error{ErrorCode::kUsage, "--json: expected a file of its own, found " + json +
                                      ", which has the name of an image in the folder of --out"};
}

Result<void> reject_overwriting_of(const SessionConfig& config, const std::string& json,
                                   const std::vector<std::string>& names) {
  std::vector<NamedFile> inputs = session_inputs(config);
  const std::vector<NamedFile> outputs = files_in(config.output.folder, names);
  // A session writes itself again, so it may lie among what it wrote.
  if (const auto ok = reject_overwriting(outputs, inputs); !ok) return ok;
  inputs.push_back({"--session", config.file});
  const NamedFile appearance{"--save-appearance", config.appearance.save};
  if (const auto ok = reject_overwriting({{"--json", json}, appearance}, inputs); !ok) return ok;
  if (const auto ok = reject_overwriting({appearance}, outputs); !ok) return ok;
  if (const auto ok = reject_report_over(json, config.output.folder, outputs); !ok) return ok;
  if (config.output.record.empty()) return {};
  const NamedFile record{"--record", config.output.record};
  inputs.insert(inputs.end(), outputs.begin(), outputs.end());
  inputs.push_back({"--json", json});
  return reject_overwriting({record}, inputs);
}

}  // namespace nav::app
