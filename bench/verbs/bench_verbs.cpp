// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The verbs that measure.
#include "app/options/idle_options.hpp"
#include "app/options/option_checks.hpp"
#include "app/options/overwriting.hpp"
#include "app/options/verbs.hpp"

namespace nav::bench {

void CommandLine::add_bench() {
  CLI::App* bench = app_.add_subcommand("bench", "Measure run time against error");
  bench->require_subcommand(1);
  CLI::App* render = bench->add_subcommand(
      "render", "Sonde's engines beside VTK's volume mappers, and their agreement");
  render->add_option("--ct", bench_.ct, "CT to draw instead of the scene set");
  render->add_option("--scene", bench_.scene, "only scenes whose name contains this");
  render
      ->add_option("--part", bench_.parts, "compare, live, skipping, costs; default the first two")
      ->check(among({"compare", "live", "skipping", "costs"}))
      ->delimiter(',');
  render->add_flag("--quick", bench_.quick, "few scenes, small pictures: about two minutes");
  render->add_flag("--costs", bench_.costs,
                   "also the cost of every element of the live session's picture");
  render->add_option("--width", bench_.width, "of the timed pictures, pixels")
      ->check(in_range(16, 8192, "pixels"))
      ->capture_default_str();
  render->add_option("--height", bench_.height, "of the timed pictures, pixels")
      ->check(in_range(16, 8192, "pixels"))
      ->capture_default_str();
  add_json(*render);
  render->callback([this, render] {
    verb_ = [this, render](app::Console& console) -> Result<void> {
      bench_.json = json();
      if (auto ok = refuse_idle_of_bench(*render, bench_); !ok) return ok;
      if (auto ok = refuse_overwriting({{"--json", json_}}, {{"--ct", bench_.ct}}); !ok) return ok;
      return run_bench_render(bench_, console);
    };
  });
  add_bench_predicates(*bench);
  CLI::App* scaling = bench->add_subcommand(
      "scaling", "Time and memory of the CPU engine against size, pixels, threads, occupancy");
  scaling->add_option("--largest", scaling_.largest, "side of the largest volume, voxels")
      ->check(in_range(64, 768, "voxels"))
      ->capture_default_str();
  add_json(*scaling);
  scaling->callback([this] {
    verb_ = [this](app::Console& console) {
      scaling_.json = json();
      return run_bench_scaling(scaling_, console);
    };
  });
  add_bench_registration(*bench);
  add_bench_derived(*bench);
}

void CommandLine::add_bench_registration(CLI::App& bench) {
  CLI::App* verb = bench.add_subcommand(
      "registration", "Registration on simulated patients: error, success, refusals, time");
  verb->add_flag("--quick", bench_registration_.quick, "part of the cohort: about two minutes");
  verb->add_flag("!--no-evaluation", bench_registration_.evaluate,
                 "leave the evaluation seeds alone: for tuning");
  add_choice<sim::AcousticModel>(
      *verb, "--model", bench_registration_.model,
      {{"rays", sim::AcousticModel::kRays}, {"scatterers", sim::AcousticModel::kScatterers}},
      "how echoes are computed: rays, scatterers");
  add_choice<registration::Effort>(
      *verb, "--effort", bench_registration_.effort,
      {{"quick", registration::Effort::kQuick}, {"usual", registration::Effort::kUsual}},
      "of cohort, faults and starts: quick or usual");
  verb->add_option("--patients", bench_registration_.patients, "of each cohort")
      ->check(in_range(1, 100, "patients"));
  verb->add_option(
          "--part", bench_registration_.parts,
          "cohort, faults, starts, curve, bootstrap, skin, motion, live, peer; default all")
      ->check(among(
          {"cohort", "faults", "starts", "curve", "bootstrap", "skin", "motion", "live", "peer"}))
      ->delimiter(',');
  verb->add_option("--trials", bench_registration_.trials, "CSV with a line per registration");
  add_json(*verb);
  verb->callback([this, verb] {
    verb_ = [this, verb](app::Console& console) -> Result<void> {
      bench_registration_.json = json();
      if (auto ok = refuse_idle_of_bench(*verb, bench_registration_); !ok) return ok;
      const std::vector<NamedFile> outputs{{"--json", json_},
                                           {"--trials", bench_registration_.trials.value_or("")}};
      if (auto ok = refuse_overwriting(outputs, {}); !ok) return ok;
      return run_bench_registration(bench_registration_, console);
    };
  });
}

void CommandLine::add_bench_predicates(CLI::App& bench) {
  CLI::App* verb = bench.add_subcommand(
      "predicates", "Ultrasound by predicates beside a standard transfer function");
  verb->add_flag("--quick", predicates_.quick, "a small phantom, small pictures: some seconds");
  verb->add_option("--side", predicates_.side, "of the phantom, voxels")
      ->check(in_range(32, 768, "voxels"))
      ->capture_default_str();
  verb->add_option("--width", predicates_.width, "pixels; half of it where OpenGL is software")
      ->check(in_range(32, 4096, "pixels"))
      ->capture_default_str();
  verb->add_option("--height", predicates_.height, "as --width")
      ->check(in_range(32, 4096, "pixels"))
      ->capture_default_str();
  verb->add_option("--volume", predicates_.volume,
                   "only volumes whose name begins so: neck, …, two-volumes, features");
  verb->add_option("--look", predicates_.look,
                   "only set-ups whose name begins so, of a --volume that has some");
  verb->add_option("--engine", predicates_.engine, "cpu, gl or both")
      ->check(among({"cpu", "gl", "both"}))
      ->capture_default_str();
  verb->add_option("--threads", predicates_.threads, "0: all cores")
      ->check(in_range(0, 1024, "threads"))
      ->capture_default_str();
  add_json(*verb);
  verb->callback([this, verb] {
    verb_ = [this, verb](app::Console& console) {
      predicates_.json = json();
      const auto ok = refuse_idle_of_bench(*verb, predicates_);
      return ok ? run_bench_predicates(predicates_, console) : ok;
    };
  });
}

void CommandLine::add_bench_derived(CLI::App& bench) {
  CLI::App* derived = bench.add_subcommand(
      "derived", "Time, memory and error of the features that predicates read, beside ITK's");
  derived->add_option("--side", derived_.side, "of the timed volume, voxels")
      ->check(in_range(32, 512, "voxels"))
      ->capture_default_str();
  derived->add_option("--threads", derived_.threads, "0: all cores")
      ->check(in_range(0, 1024, "threads"))
      ->capture_default_str();
  derived->add_flag("--quick", derived_.quick, "96 voxels a side, once each: seconds");
  add_json(*derived);
  derived->callback([this, derived] {
    verb_ = [this, derived](app::Console& console) {
      derived_.json = json();
      const auto ok = refuse_idle_of_bench(*derived, derived_);
      return ok ? run_bench_derived(derived_, console) : ok;
    };
  });
}

}  // namespace nav::bench
