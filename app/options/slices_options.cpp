// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/slices_options.hpp"

#include "app/options/look_options.hpp"
#include "app/options/option_checks.hpp"

namespace nav::app {
namespace {

using Numbers = std::vector<double>;

CLI::Option* add_vector(CLI::App& verb, const std::string& option,
                        std::optional<Eigen::Vector3d>& value, const std::string& description) {
  return verb
      .add_option_function<Numbers>(
          option, [&value](const Numbers& p) { value = Eigen::Vector3d(p[0], p[1], p[2]); },
          description)
      ->expected(3);
}

void add_planes(CLI::App& verb, SlicesOptions& o) {
  add_vector(verb, "--at", o.at_ct,
             "x y z, LPS mm: the point of the slices; none: the middle of the ultrasound picture, "
             "the needle's tip, the plan's target, or the middle of the CT");
  CLI::Option* normal = add_vector(verb, "--normal", o.normal_ct,
                                   "x y z, LPS: also an oblique slice at right angles to it");
  CLI::Option* right = add_vector(verb, "--right", o.right_ct,
                                  "x y z, LPS: also an oblique slice, its direction to the right");
  CLI::Option* down = add_vector(verb, "--down", o.down_ct,
                                 "x y z, LPS: and one down, made square to --right in the plane");
  right->excludes(normal);
  down->excludes(normal);
  verb.add_option_function<Numbers>(
          "--needle",
          [&o](const Numbers& p) {
            o.needle_ct = Eigen::Map<const Eigen::Matrix<double, 6, 1>>(p.data());
          },
          "tip and hub, LPS mm: 6 numbers; also two slices along the needle")
      ->expected(6)
      ->excludes(verb.get_option("--needle-frame"));
}

void add_fusion(CLI::App& verb, SlicesOptions& o) {
  verb.add_option("--second", o.second, "volume in the CT's frame, laid over it")
      ->excludes(verb.get_option("--recording"));
  verb.add_option("--second-level", o.second_level, "of its values; none: of all of them")
      ->check(in_range(-1e6, 1e6));
  verb.add_option("--second-width", o.second_width, "of its values; none: of all of them")
      ->check(in_range(1e-3, 1e6));
  verb.add_option("--fusion", o.fusion, "of the picture or second volume with the CT")
      ->check(among({"blend", "checkerboard", "wipe"}))
      ->capture_default_str();
  verb.add_option("--share", o.share, "of it in a blend; 0: the CT alone")
      ->check(in_range(0, 1))
      ->capture_default_str();
  verb.add_option("--square-mm", o.square_mm, "of the checkerboard")
      ->check(in_range(0.1, 1000, "mm"))
      ->capture_default_str();
  verb.add_option("--wipe", o.wipe, "share of the picture's width at whose left it is")
      ->check(in_range(0, 1))
      ->capture_default_str();
}

}  // namespace

void add_slices_options(CLI::App& verb, SessionConfig& config, SlicesOptions& o) {
  verb.add_option("--frame", o.frame, "picture of --recording, from 0; none: the middle one");
  verb.add_flag("--whole-picture", config.source.whole_picture,
                "also what lies around the sector that the pictures show");
  add_planes(verb, o);
  add_fusion(verb, o);
  verb.add_option("--slab", o.slab_mm, "thickness, mm; 0: thin")
      ->check(in_range(0, 1000, "mm"))
      ->capture_default_str();
  verb.add_option("--mode", o.slab, "of a slab: maximum, minimum or mean")
      ->check(among({"maximum", "minimum", "mean"}))
      ->capture_default_str();
  add_window_options(verb, config.view);
  verb.add_option("--size", o.size_px, "of each picture, pixels")->capture_default_str();
  verb.add_option("--mm-per-pixel", o.mm_per_pixel,
                  "0: the CT fits, along the ultrasound the picture")
      ->check(in_range(0, 100, "mm"))
      ->capture_default_str();
}

}  // namespace nav::app
