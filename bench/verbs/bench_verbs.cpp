// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_verbs.hpp"

#include "app/options/option_checks.hpp"
#include "app/options/overwriting.hpp"
#include "bench/verbs/bench_idle_options.hpp"

namespace nav::bench {

void BenchCommandLine::add_render() {
  CLI::App* render = app_.add_subcommand(
      "render", "Sonde's engines beside VTK's volume mappers, and their agreement");
  render->add_option("--ct", render_.ct, "CT to draw instead of the scene set");
  render->add_option("--scene", render_.scene, "only scenes whose name contains this");
  render
      ->add_option("--part", render_.parts, "compare, live, skipping, costs; default the first two")
      ->check(app::among({"compare", "live", "skipping", "costs"}))
      ->delimiter(',');
  render->add_flag("--quick", render_.quick, "few scenes, small images: about two minutes");
  render->add_flag("--costs", render_.costs,
                   "also the cost of every element of the live session's image");
  render->add_option("--width", render_.width, "width of the timed images, pixels")
      ->check(app::in_range(16, 8192, "pixels"))
      ->capture_default_str();
  render->add_option("--height", render_.height, "height of the timed images, pixels")
      ->check(app::in_range(16, 8192, "pixels"))
      ->capture_default_str();
  add_json(*render);
  render->callback([this, render] {
    verb_ = [this, render](app::Console& console) -> Result<void> {
      render_.json = json();
      if (auto ok = reject_idle_of_bench(*render, render_); !ok) return ok;
      if (auto ok = app::reject_overwriting({{"--json", json_}}, {{"--ct", render_.ct}}); !ok)
        return ok;
      return run_bench_render(render_, console);
    };
  });
}

void BenchCommandLine::add_scaling() {
  CLI::App* scaling = app_.add_subcommand(
      "scaling", "Time and memory of the CPU engine against size, pixels, threads, occupancy");
  scaling->add_option("--largest", scaling_.largest, "side of the largest volume, voxels")
      ->check(app::in_range(64, 768, "voxels"))
      ->capture_default_str();
  add_json(*scaling);
  scaling->callback([this] {
    verb_ = [this](app::Console& console) {
      scaling_.json = json();
      return run_bench_scaling(scaling_, console);
    };
  });
}

void BenchCommandLine::add_vessels() {
  CLI::App* verb = app_.add_subcommand(
      "vessels", "Blood that presets show as vessel, and bone that they show as vessel");
  add_json(*verb);
  verb->callback([this] {
    verb_ = [this](app::Console& console) {
      vessels_.json = json();
      return run_bench_vessels(vessels_, console);
    };
  });
}

void BenchCommandLine::add_registration() {
  CLI::App* verb = app_.add_subcommand(
      "registration", "Registration on simulated patients: error, success, refused results, time");
  verb->add_flag("--quick", registration_.quick, "part of the cohort: about two minutes");
  verb->add_flag("!--no-evaluation", registration_.evaluate,
                 "leave the evaluation seeds out: for tuning");
  app::add_choice<sim::AcousticModel>(
      *verb, "--model", registration_.model,
      {{"rays", sim::AcousticModel::kRays}, {"scatterers", sim::AcousticModel::kScatterers}},
      "acoustic model of the echoes: rays, scatterers");
  app::add_choice<registration::Effort>(
      *verb, "--effort", registration_.effort,
      {{"quick", registration::Effort::kQuick}, {"usual", registration::Effort::kUsual}},
      "effort of cohort, faults and starts: quick or usual");
  verb->add_option("--patients", registration_.patients, "number of patients of each cohort")
      ->check(app::in_range(1, 100, "patients"));
  verb->add_option("--part", registration_.parts,
                   "cohort, faults, levels, starts, curve, bootstrap, skin, motion, live, shapes, "
                   "bone, peer; "
                   "default all")
      ->check(app::among({"cohort", "faults", "levels", "starts", "curve", "bootstrap", "skin",
                          "motion", "live", "shapes", "bone", "peer"}))
      ->delimiter(',');
  verb->add_option("--trials", registration_.trials, "CSV with a line per registration");
  add_json(*verb);
  verb->callback([this, verb] {
    verb_ = [this, verb](app::Console& console) -> Result<void> {
      registration_.json = json();
      if (auto ok = reject_idle_of_bench(*verb, registration_); !ok) return ok;
      const std::vector<app::NamedFile> outputs{{"--json", json_},
                                                {"--trials", registration_.trials.value_or("")}};
      if (auto ok = app::reject_overwriting(outputs, {}); !ok) return ok;
      return run_bench_registration(registration_, console);
    };
  });
}

void BenchCommandLine::add_predicates() {
  CLI::App* verb = app_.add_subcommand(
      "predicates", "Ultrasound by predicates beside a standard transfer function");
  verb->add_flag("--quick", predicates_.quick, "a small phantom, small images: some seconds");
  verb->add_option("--side", predicates_.side, "side of the phantom, voxels")
      ->check(app::in_range(32, 768, "voxels"))
      ->capture_default_str();
  verb->add_option("--width", predicates_.width,
                   "width of the images, pixels; halved if OpenGL is software")
      ->check(app::in_range(32, 4096, "pixels"))
      ->capture_default_str();
  verb->add_option("--height", predicates_.height,
                   "height of the images, pixels; halved if OpenGL is software")
      ->check(app::in_range(32, 4096, "pixels"))
      ->capture_default_str();
  verb->add_option("--volume", predicates_.volume,
                   "only volumes whose name begins with this: neck, …, two-volumes, features");
  verb->add_option("--look", predicates_.appearance,
                   "only predicate sets whose name begins with this, of a --volume that has some");
  verb->add_option("--engine", predicates_.engine, "rendering engines")
      ->check(app::among({"cpu", "gl", "both"}))
      ->capture_default_str();
  verb->add_option("--threads", predicates_.threads, "number of threads; 0: all cores")
      ->check(app::in_range(0, 1024, "threads"))
      ->capture_default_str();
  add_json(*verb);
  verb->callback([this, verb] {
    verb_ = [this, verb](app::Console& console) {
      predicates_.json = json();
      const auto ok = reject_idle_of_bench(*verb, predicates_);
      return ok ? run_bench_predicates(predicates_, console) : ok;
    };
  });
}

void BenchCommandLine::add_derived() {
  CLI::App* derived = app_.add_subcommand(
      "derived", "Time, memory and error of the features that predicates read, beside ITK's");
  derived->add_option("--side", derived_.side, "side of the timed volume, voxels")
      ->check(app::in_range(32, 512, "voxels"))
      ->capture_default_str();
  derived->add_option("--threads", derived_.threads, "number of threads; 0: all cores")
      ->check(app::in_range(0, 1024, "threads"))
      ->capture_default_str();
  derived->add_flag("--quick", derived_.quick, "96 voxels a side, once each: seconds");
  add_json(*derived);
  derived->callback([this, derived] {
    verb_ = [this, derived](app::Console& console) {
      derived_.json = json();
      const auto ok = reject_idle_of_bench(*derived, derived_);
      return ok ? run_bench_derived(derived_, console) : ok;
    };
  });
}

void BenchCommandLine::add_reconstruct() {
  CLI::App* verb = app_.add_subcommand(
      "reconstruct",
      "Rates of the methods of reconstruction, and their errors on simulated images");
  verb->add_option("--part", reconstruct_.parts, "rates, backward, errors; default all")
      ->check(app::among({"rates", "backward", "errors"}))
      ->delimiter(',');
  verb->add_option("--threads", reconstruct_.threads, "number of threads; 0: all cores")
      ->check(app::in_range(0, 1024, "threads"))
      ->capture_default_str();
  verb->add_flag("--quick", reconstruct_.quick, "few and small images: seconds");
  add_json(*verb);
  verb->callback([this] {
    verb_ = [this](app::Console& console) {
      reconstruct_.json = json();
      return run_bench_reconstruct(reconstruct_, console);
    };
  });
}

void BenchCommandLine::add_devices() {
  CLI::App* verb = app_.add_subcommand(
      "devices",
      "Images shown wrongly in recordings with faults, errors of the clock model, throughput of "
      "codecs and recorder");
  verb->add_option("--part", devices_.parts, "faults, clock, codecs, recorder; default all")
      ->check(app::among({"faults", "clock", "codecs", "recorder"}))
      ->delimiter(',');
  verb->add_option("--recordings", devices_.recordings, "number of recordings with faults")
      ->check(app::in_range(1, 1000000, "recordings"))
      ->capture_default_str();
  verb->add_flag("--quick", devices_.quick, "few and short recordings: seconds");
  add_json(*verb);
  verb->callback([this] {
    verb_ = [this](app::Console& console) {
      devices_.json = json();
      return run_bench_devices(devices_, console);
    };
  });
}

void BenchCommandLine::add_gallery() {
  CLI::App* gallery = app_.add_subcommand("gallery", "Draw the images of docs/gallery.md");
  gallery->add_option("--out", gallery_.out, "folder to write to")->required();
  gallery->add_option("--engine", gallery_.engine, "rendering engine")
      ->check(app::among({"cpu", "gl", "reference"}))
      ->capture_default_str();
  gallery->add_option("--only", gallery_.only, "only images whose name contains this");
  gallery->add_option("--width", gallery_.width, "width of the images, pixels")
      ->check(app::in_range(16, 4096, "pixels"))
      ->capture_default_str();
  gallery->add_option("--height", gallery_.height, "height of the images, pixels")
      ->check(app::in_range(16, 4096, "pixels"))
      ->capture_default_str();
  gallery->callback(
      [this] { verb_ = [this](app::Console& console) { return run_gallery(gallery_, console); }; });
}

}  // namespace nav::bench
