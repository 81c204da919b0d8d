// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The verbs of ultrasound volumes and of the simulator: predicates, derive, simulate.
#include "app/options/option_parser.hpp"
#include "app/options/overwriting.hpp"
#include "app/options/predicate_needs.hpp"
#include "app/options/verbs.hpp"
#include "app/predicates/predicates.hpp"

namespace nav::app {

void CommandLine::add_predicates() {
  CLI::App& verb = add_verb("predicates", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      const SessionConfig& config = settings_.config;
      if (auto ok = as_given(verb, "predicates", validate(config)); !ok) return ok;
      if (auto ok = reject_idle(verb, "predicates", settings_); !ok) return ok;
      if (auto ok = as_given(verb, "predicates", reject_idle_of_set(verb, config.predicates));
          !ok) {
        return ok;
      }
      if (settings_.print_session) return print_session(config);
      return as_given(verb, "predicates", run_predicates(config, console));
    };
  });
}

void CommandLine::add_derive() {
  CLI::App& verb = add_verb("derive", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      if (auto ok = reject_idle(verb, "derive", settings_); !ok) return ok;
      return run_derive(settings_.derive, console);
    };
  });
}

void CommandLine::add_simulate() {
  CLI::App& verb = add_verb("simulate", settings_);
  verb.callback([this, &verb] {
    verb_ = [this, &verb](Console& console) -> Result<void> {
      const SimulateOptions& o = settings_.simulate;
      if (auto ok = reject_idle(verb, "simulate", settings_); !ok) return ok;
      const std::vector<NamedFile> outputs{{"--out", o.out}, {"--ct", o.ct}, {"--truth", o.truth}};
      if (auto ok = reject_overwriting(outputs, {{"--patient-ct", o.patient_ct}}); !ok) return ok;
      if (auto ok = reject_unwritable(outputs); !ok) return ok;
      return run_simulate(o, console);
    };
  });
}

}  // namespace nav::app
