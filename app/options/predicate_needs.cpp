// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/predicate_needs.hpp"

#include <set>

#include "app/options/option_parser.hpp"
#include "app/predicates/predicate_volume.hpp"
#include "render/features/derived_features.hpp"
#include "render/predicates/registry.hpp"

namespace nav::app {
namespace {

/// Properties that the predicates of a set have.
Result<std::set<SetProperty>> properties_of(const render::PredicateModel& model) {
  std::set<SetProperty> found;
  const auto add = [&](bool there, SetProperty property) {
    if (there) found.insert(property);
  };
  for (const std::string& name : render::kinds_of(model)) {
    const auto kind = render::find_predicate_kind(name);
    if (!kind) return kind.error();
    const render::PredicateNeeds needs = (*kind)->needs({});
    add(render::reads_scan_lines(needs), SetProperty::kScanLines);
    add(needs.labels, SetProperty::kLabels);
    for (const std::string& channel : needs.channels) {
      const render::ChannelSource source = render::source_of_channel(channel);
      add(channel == render::feature::kVesselness, SetProperty::kVesselness);
      add(source.gradient, SetProperty::kGradients);
      add(source.derived, SetProperty::kDerived);
    }
  }
  return found;
}

const char* text_of(SetProperty property) {
  switch (property) {
    case SetProperty::kNone:
      break;
    case SetProperty::kScanLines:
      return "a predicate depth, gradient_angle or confidence";
    case SetProperty::kLabels:
      return "a predicate label";
    case SetProperty::kVesselness:
      return "a predicate vesselness";
    case SetProperty::kGradients:
      return "a predicate gradient_magnitude or gradient_angle";
    case SetProperty::kDerived:
      return "a predicate of a derived feature";
  }
  return "";
}

}  // namespace

Result<void> reject_idle_of_set(const CLI::App& parser, const PredicateOptions& options) {
  std::vector<const Option*> given;
  for (const Option* option : options_of(parser.get_name())) {
    const bool acts = option->acts_on != SetProperty::kNone;
    if (acts && is_given(parser, option->name.c_str())) given.push_back(option);
  }
  if (given.empty()) return {};
  const auto file = set_up_of(options);
  if (!file) return file.error();
  const auto properties = properties_of(file->model);
  if (!properties) return properties.error();
  for (const Option* option : given) {
    if (properties->contains(option->acts_on)) continue;
    return Error{ErrorCode::kUsage, option->name + " requires " + text_of(option->acts_on) + " (" +
                                        file->name + " has none)"};
  }
  return {};
}

}  // namespace nav::app
