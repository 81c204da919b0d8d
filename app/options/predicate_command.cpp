// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/predicate_command.hpp"

#include "app/options/option_checks.hpp"
#include "app/predicates/predicate_scribbles.hpp"
#include "sim/predicate_patient.hpp"

namespace nav::app {
namespace {

using Numbers = std::vector<double>;

template <class Value>
Value or_throw(Result<Value> value) {
  if (!value) throw CLI::ValidationError(value.error().message);
  return *std::move(value);
}

void add_volume_options(CLI::App& verb, PredicateOptions& o) {
  verb.add_option("volume", o.volume, "3D ultrasound; absent: a phantom");
  verb.add_option("--phantom", o.phantom,
                  "neck, or a simulated patient: " + sim::simulated_ultrasound_names())
      ->capture_default_str();
  verb.add_option("--phantom-side", o.phantom_side, "voxels")->capture_default_str();
  add_ultrasound_options(verb, o);
}

void add_set_up_options(CLI::App& verb, PredicateOptions& o) {
  verb.add_option("--predicates", o.set_up, "name of a preset, or a file")->capture_default_str();
  verb.add_option("--save", o.save_set_up, "file for the set-up as it was drawn");
  add_set_up_edits(verb, o, "--importance", "--colour");
}

void add_scribble_options(CLI::App& verb, PredicateOptions& o) {
  using render::features::Paint;
  verb.add_option("--scribbles", o.scribbles, "file of strokes painted on slices");
  for (const auto& [name, paint] :
       {std::pair<std::string, Paint>{"--show", Paint::kShow}, {"--hide", Paint::kHide}}) {
    verb.add_option_function<std::vector<std::string>>(
            name,
            [&o, name = name, paint = paint](const std::vector<std::string>& strokes) {
              for (const auto& text : strokes) {
                o.strokes.push_back(or_throw(parse_stroke(name, paint, text)));
              }
            },
            "'x,y,z x,y,z … [radius=MM] [thickness=MM] [normal=x,y,z]', LPS mm: a stroke; several, "
            "in order: the last one that covers a voxel counts")
        ->trigger_on_parse();
  }
  verb.add_option("--scribble-share", o.scribble_share, "of the importance that strokes move")
      ->capture_default_str();
}

void add_view_options(CLI::App& verb, SessionConfig& config) {
  PredicateOptions& o = config.predicates;
  verb.add_option_function<Numbers>(
          "--from", [&o](const Numbers& p) { o.from = Eigen::Vector3d(p[0], p[1], p[2]); },
          "i j k: where the eye is, along the volume's axes from its middle")
      ->expected(3);
  verb.add_option("--distance", config.view.distance_mm, "of the camera, mm; 0: the volume fits")
      ->capture_default_str();
  verb.add_flag("--orthographic", config.view.orthographic,
                "parallel rays: what is farther away is no smaller");
  verb.add_option_function<Numbers>(
          "--target",
          [&o](const Numbers& p) { o.target = Eigen::Vector4d(p[0], p[1], p[2], p[3]); },
          "x y z radius, LPS mm")
      ->expected(4);
  verb.add_option_function<Numbers>(
          "--needle",
          [&o](const Numbers& p) {
            o.needle = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(p.data());
          },
          "tip and hub, LPS mm: 6 numbers")
      ->expected(6);
  auto& out = config.output;
  verb.add_option("--engine", out.engine, "cpu, gl or reference")->capture_default_str();
  verb.add_option("--threads", out.threads, "0: all cores")->capture_default_str();
  verb.add_option("--width", out.width, "of each part of the picture, pixels")
      ->check(in_range(200, 4096, "pixels"))
      ->capture_default_str();
  verb.add_option("--height", out.height, "of each part of the picture, pixels")
      ->check(in_range(200, 4096, "pixels"))
      ->capture_default_str();
  verb.add_option("--step", out.step_voxels, "sampling distance, voxels; not given: 0.5");
}

}  // namespace

void add_ultrasound_options(CLI::App& verb, PredicateOptions& o) {
  // An option replaces what the session says in another way.
  auto* labels = verb.add_option_function<std::vector<std::string>>(
      "--labels",
      [&o](const std::vector<std::string>& files) {
        o.labels.assign(files.begin(), files.end());
        o.layers.clear();
      },
      "label volume of bit masks; several: one bit each, where not 0");
  verb.add_option_function<std::string>(
          "--layers",
          [&o](const std::string& file) {
            o.layers = file;
            o.labels.clear();
          },
          "file of B-spline surfaces between layers, instead")
      ->excludes(labels);
  verb.add_option("--black", o.black, "stored value of black")->capture_default_str();
  verb.add_option("--white", o.white, "stored value of white")->capture_default_str();
  const auto replace_lines = [&o] {
    o.into_ct.reset();
    o.face_ct.reset();
    o.apex_ct.reset();
    o.scan_lines.clear();
  };
  const auto add_lines = [&](const char* option, std::optional<Eigen::Vector3d>& value,
                             const char* description) {
    return verb
        .add_option_function<Numbers>(
            option,
            [replace_lines, &value](const Numbers& p) {
              replace_lines();
              value = Eigen::Vector3d(p[0], p[1], p[2]);
            },
            description)
        ->expected(3);
  };
  auto* into = add_lines("--into", o.into_ct, "x y z, LPS: direction of parallel scan lines");
  verb.add_option_function<Numbers>(
          "--face", [&o](const Numbers& p) { o.face_ct = Eigen::Vector3d(p[0], p[1], p[2]); },
          "x y z, LPS mm: a point of the plane where --into has depth 0; none: the known voxel "
          "nearest to the probe")
      ->expected(3);
  auto* apex = add_lines("--apex", o.apex_ct, "x y z, LPS mm: of a fan of scan lines");
  apex->excludes(into);
  verb.add_option("--face-radius-mm", o.face_radius_mm, "of the fan's probe")
      ->capture_default_str();
  verb.add_option_function<std::string>(
          "--scan-lines",
          [&o, replace_lines](const std::string& file) {
            replace_lines();
            o.scan_lines = file;
          },
          "file of the planes of the sweep that the volume was made from, instead")
      ->excludes(into)
      ->excludes(apex);
  verb.add_option("--unknown", o.unknown, "value of voxels that no picture reached");
  verb.add_option("--cache", o.cache, "folder that keeps derived features for the next time");
}

void add_set_up_edits(CLI::App& verb, PredicateOptions& o, const std::string& importance,
                      const std::string& colour) {
  verb.add_option_function<std::vector<std::string>>(
      importance,
      [&o](const std::vector<std::string>& edits) {
        for (const auto& text : edits) o.histogram.push_back(or_throw(parse_importance(text)));
      },
      "NAME=IMPORTANCE: drags a bar of the histogram; several, in order");
  verb.add_option_function<std::vector<std::string>>(
      colour,
      [&o](const std::vector<std::string>& edits) {
        for (const auto& text : edits) o.histogram.push_back(or_throw(parse_colour(text)));
      },
      "NAME=HUE:SATURATION of a bar, degrees modulo 360 and share; several");
  verb.add_option("--opacity-length-mm", o.opacity_length_mm,
                  "of this much material intensity is the opacity");
  verb.add_option("--smoothing-mm", o.smoothing_mm, "of gradients; none: as the set-up says");
  verb.add_option("--smallest-radius", o.smallest_radius_mm,
                  "of vessels, mm; none: as the set-up says");
  verb.add_option("--largest-radius", o.largest_radius_mm,
                  "of vessels, mm; none: as the set-up says");
  verb.add_flag_function(
      "--bright,!--dark", [&o](std::int64_t count) { o.bright_vessels = count > 0; },
      "vessels are brighter, or darker, than what surrounds them; none: as the set-up says");
  verb.add_option(
      "--hue-mean", o.hue_mean,
      "of predicates that are true together: circular or linear, as the paper prints it; "
      "none: as the set-up says");
}

void add_predicate_options(CLI::App& verb, SessionConfig& config) {
  verb.add_option("--out", config.predicates.picture, "PNG to write");
  add_volume_options(verb, config.predicates);
  add_set_up_options(verb, config.predicates);
  add_scribble_options(verb, config.predicates);
  add_view_options(verb, config);
}

}  // namespace nav::app
