// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/predicate_needs.hpp"

#include <algorithm>
#include <set>

#include "app/options/option_parser.hpp"
#include "app/predicates/predicate_volume.hpp"
#include "render/features/derived_features.hpp"
#include "render/predicates/registry.hpp"

namespace nav::app {
namespace {

/// Properties of predicates that options act on.
struct SetReads {
  bool scan_lines = false;
  bool labels = false;
  bool vesselness = false;
  bool gradients = false;
  bool derived = false;
};

Result<SetReads> reads_of(const render::PredicateModel& model) {
  SetReads reads;
  for (const std::string& name : render::kinds_of(model)) {
    const auto kind = render::find_predicate_kind(name);
    if (!kind) return kind.error();
    const render::PredicateNeeds needs = (*kind)->needs({});
    reads.scan_lines = reads.scan_lines || render::reads_scan_lines(needs);
    reads.labels = reads.labels || needs.labels;
    for (const std::string& channel : needs.channels) {
      const render::ChannelSource source = render::source_of_channel(channel);
      reads.vesselness = reads.vesselness || channel == render::feature::kVesselness;
      reads.gradients = reads.gradients || source.gradient;
      reads.derived = reads.derived || source.derived;
    }
  }
  return reads;
}

struct SetNeed {
  std::vector<const char*> options;
  bool SetReads::*met;
  const char* text;
};

}  // namespace

Result<void> reject_idle_of_set(const CLI::App& parser, const PredicateOptions& options) {
  const std::vector<SetNeed> needs{
      {{"--into", "--face", "--apex", "--face-radius-mm", "--scan-lines"},
       &SetReads::scan_lines,
       "a predicate depth, gradient_angle or confidence"},
      {{"--labels", "--layers"}, &SetReads::labels, "a predicate label"},
      {{"--smallest-radius", "--largest-radius", "--bright", "--dark"},
       &SetReads::vesselness,
       "a predicate vesselness"},
      {{"--smoothing-mm"},
       &SetReads::gradients,
       "a predicate gradient_magnitude or gradient_angle"},
      {{"--cache"}, &SetReads::derived, "a predicate of a derived feature"}};
  const auto given = [&](const char* option) { return is_given(parser, option); };
  const bool asks = std::ranges::any_of(
      needs, [&](const SetNeed& need) { return std::ranges::any_of(need.options, given); });
  if (!asks) return {};
  const auto file = set_up_of(options);
  if (!file) return file.error();
  const auto reads = reads_of(file->model);
  if (!reads) return reads.error();
  for (const SetNeed& need : needs) {
    if ((*reads).*need.met) continue;
    for (const char* option : need.options) {
      if (!given(option)) continue;
      return Error{ErrorCode::kUsage, std::string(option) + " requires " + need.text + " (" +
                                          file->name + " has none)"};
    }
  }
  return {};
}

}  // namespace nav::app
