// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/predicates/predicates.hpp"

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <sstream>
#include <tuple>

#include "app/engines.hpp"
#include "app/options/overwriting.hpp"
#include "app/predicates/predicate_image.hpp"
#include "app/predicates/predicate_scribbles.hpp"
#include "app/predicates/predicate_volume.hpp"
#include "app/views/orthographic.hpp"
#include "app/views/panels.hpp"
#include "io/image_output.hpp"
#include "render/canvas.hpp"
#include "render/engine.hpp"

namespace nav::app {
namespace {

using render::features::Stroke;

render::Scene scene_of(const SessionConfig& config, const render::PredicateVolume& volume) {
  const PredicateOptions& options = config.predicates;
  render::Scene scene = render::predicate_scene(volume, volume.predicates.model,
                                                config.output.width, config.output.height);
  const Eigen::Vector3d look_at = scene.camera.look_at_ct.mm;
  const double fitting = (scene.camera.eye_ct.mm - look_at).norm();
  const double distance = config.view.distance_mm > 0 ? config.view.distance_mm : fitting;
  const Eigen::Matrix3d& axes = volume.ultrasound->grid().directions;
  const double largest = options.from.cwiseAbs().maxCoeff();
  const Eigen::Vector3d from = (axes * (options.from / largest)).normalized();
  scene.camera.eye_ct = {look_at + distance * from};
  constexpr double kNearlyAlong = 0.95;
  if (std::abs(scene.camera.up_ct.v.normalized().dot(from)) > kNearlyAlong) {
    scene.camera.up_ct = {axes.col(2)};
  }
  if (config.view.orthographic) {
    scene.camera = orthographic_of(scene.camera, volume.ultrasound->grid());
  }
  scene.quality.step_voxels = config.output.step_voxels.value_or(scene.quality.step_voxels);
  if (options.target) scene.spheres = {target_sphere(*options.target)};
  if (options.needle) {
    render::NeedleShape needle{};
    needle.tip_ct = {options.needle->head<3>()};
    needle.hub_ct = {options.needle->tail<3>()};
    needle.safety = {SafetyState::kValid, ""};
    scene.needle = needle;
  }
  return scene;
}

Result<Image2d<Rgba8>> draw(render::Engine& engine, const render::Scene& scene, Console& console) {
  const auto image = engine.render(scene);
  if (!image) return image.error();
  const std::string& note = image->statistics.note;
  if (!note.empty()) console.report(Severity::kWarning, "image", note);
  return render::to_8bit(image->pixels);
}

/// Warns when an image by predicates is empty.
void warn_if_empty(const Image2d<Rgba8>& image, const render::Scene& scene, Console& console) {
  const auto pixels = image.pixels();
  const auto differs = [&](const Rgba8& p) {
    return std::tie(p.r, p.g, p.b) != std::tie(pixels[0].r, pixels[0].g, pixels[0].b);
  };
  if (std::ranges::any_of(pixels, differs) || !scene.spheres.empty() || scene.needle) return;
  console.report(Severity::kWarning, "image",
                 "expected samples that satisfy a predicate of importance above 0, found none: "
                 "the image by predicates is empty (units of the library: docs/predicates.md)");
}

/// Warns when the most important predicate of an image can hardly be seen: alone, without the
/// others in front of it, its light is below 1 % of a white image and nowhere reaches a quarter of
/// white.
Result<void> warn_if_unseen(render::Engine& engine, render::Scene scene, Console& console) {
  constexpr double kLeastLight = 0.01;
  constexpr int kDim = 64;
  constexpr int kWidth = 320;
  render::PredicateModel& model = scene.predicates->model;
  auto bars = model.histogram.bars();
  const auto most =
      std::ranges::max_element(bars, {}, &render::PredicateHistogram::Bar::importance);
  const std::string name = model.entries[static_cast<std::size_t>(most - bars.begin())].name;
  const double importance = most->importance;
  if (!(importance > 0)) return {};
  for (auto& bar : bars) bar.importance = &bar == &*most ? 1 : 0;
  auto alone = render::PredicateHistogram::create(std::move(bars));
  if (!alone) return alone.error();
  model.histogram = *std::move(alone);
  scene.spheres.clear();
  if (scene.width > kWidth) {
    scene.height = std::max(16, scene.height * kWidth / scene.width);
    scene.width = kWidth;
  }
  const auto drawn = engine.render(scene);
  if (!drawn) return drawn.error();
  const auto image = render::to_8bit(drawn->pixels);
  double sum = 0;
  int brightest = 0;
  const Rgba8 background = image.at(0, 0);
  for (const Rgba8& p : image.pixels()) {
    if (std::tie(p.r, p.g, p.b) == std::tie(background.r, background.g, background.b)) continue;
    const int light = std::max({p.r, p.g, p.b});
    sum += light;
    brightest = std::max(brightest, light);
  }
  const double share = sum / (255.0 * static_cast<double>(image.pixels().size()));
  if (share >= kLeastLight || brightest >= kDim) return {};
  std::ostringstream text;
  text.precision(2);
  text << "'" << name << "', the most important predicate (" << importance
       << "), can hardly be seen: expected at least 1 % of the light of a white image, found "
       << 100 * share << " %, nowhere brighter than " << brightest
       << " of 255. A larger range of the predicate, a least brightness (--floor '" << name
       << "=0.4'), a shorter --opacity-length-mm, a lower --white or a nearer view (--distance) "
          "shows more";
  console.report(Severity::kWarning, "image", text.str());
  return {};
}

/// Letters at the edges of a view of a scene.
render::SliceLabels letters_of_view(const render::Scene& scene) {
  const ViewLetters of = view_letters(scene.camera);
  return {of.left, of.right, of.up, of.down};
}

Result<void> check_files(const SessionConfig& config) {
  const PredicateOptions& options = config.predicates;
  if (options.image.empty()) {
    return Error{ErrorCode::kUsage, "--out: expected a PNG to write, found none"};
  }
  std::string ending = options.image.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  std::error_code failed;
  if (ending != ".png" &&
      !std::filesystem::is_other(std::filesystem::status(options.image, failed))) {
    return Error{ErrorCode::kUsage,
                 "--out: expected a name that ends in .png, found " + options.image.string()};
  }
  std::vector<NamedFile> inputs{{"volume", options.volume},
                                {"--layers", options.layers},
                                {"--scan-lines", options.scan_lines},
                                {"--scribbles", options.scribbles},
                                {"--session", config.file}};
  for (const auto& labels : options.labels) inputs.push_back({"--labels", labels});
  const auto ok =
      reject_overwriting({{"--out", options.image}, {"--save", options.save_set_up}}, inputs);
  if (!ok) return ok;
  // A predicate set may overwrite the file that it came from.
  if (const auto own =
          reject_overwriting({{"--out", options.image}}, {{"--predicates", options.set_up}});
      !own) {
    return own;
  }
  return reject_unwritable({{"--out", options.image}, {"--save", options.save_set_up}});
}

/// Warns of letters in names that the legend's font does not have.
void warn_of_letters(const render::PredicateModel& model, Console& console) {
  constexpr std::size_t kMostNamed = 10;
  std::string names;
  for (const auto& entry : model.entries) names += entry.name;
  const auto missing = render::letters_not_drawn(names);
  if (missing.empty()) return;
  std::string text;
  for (std::size_t n = 0; n < std::min(missing.size(), kMostNamed); ++n) {
    char code[16];
    std::snprintf(code, sizeof code, " (U+%04X)",
                  static_cast<unsigned>(missing[n].code.value_or(0)));
    text += (n == 0 ? "" : ", ") + missing[n].bytes + code;
  }
  if (missing.size() > kMostNamed) {
    text += " and " + std::to_string(missing.size() - kMostNamed) + " more";
  }
  console.report(Severity::kWarning, "legend",
                 "expected names in Latin letters, found " + text + ": drawn as '?'");
}

/// Panels with the standard rendering and the rendering by predicates.
Result<std::vector<PredicatePanel>> compare(render::Engine& engine, const render::Scene& scene,
                                            std::shared_ptr<const StoredVolume> as_recorded,
                                            Console& console) {
  auto right =
      draw(engine, scene, console);  // Drawn first, because it reports errors in the options.
  if (!right) return right.error();
  warn_if_empty(*right, scene, console);
  render::Scene standard = render::standard_scene(scene);
  standard.ct = std::move(as_recorded);
  auto left = draw(engine, standard, console);
  if (!left) return left.error();
  if (const auto ok = warn_if_unseen(engine, scene, console); !ok) return ok.error();
  const auto letters = letters_of_view(scene);
  return std::vector<PredicatePanel>{
      {"standard transfer function", *std::move(left), {}, letters},
      {"predicates", *std::move(right), scene.predicates->model, letters}};
}

void say_outcome(const ScribbleOutcome& outcome, const render::PredicateModel& model,
                 Console& console) {
  std::string text = std::to_string(outcome.shown) + " voxels to show, " +
                     std::to_string(outcome.hidden) + " to hide";
  if (!outcome.decisive) {
    console.report(Severity::kWarning, "scribbles",
                   text + ": they do not distinguish the predicates, so no importance changes");
    return;
  }
  for (std::size_t j = 0; j < model.entries.size(); ++j) {
    char importance[32];
    std::snprintf(importance, sizeof importance, " %.3f -> %.3f",
                  model.histogram.bars()[j].importance, outcome.histogram.bars()[j].importance);
    text += (j == 0 ? "; " : ", ") + model.entries[j].name + importance;
  }
  console.say(text);
}

/// Panels before and after the strokes; leaves the changed histogram in the scene.
Result<std::vector<PredicatePanel>> compare_scribbles(render::Engine& engine,
                                                      const std::vector<Stroke>& strokes,
                                                      double share, render::Scene& scene,
                                                      Console& console) {
  const auto outcome = scribble(scene, strokes, share);
  if (!outcome) return outcome.error();
  auto before = draw(engine, scene, console);
  if (!before) return before.error();
  const render::PredicateModel model = scene.predicates->model;
  say_outcome(*outcome, model, console);
  scene.predicates->model.histogram = outcome->histogram;
  auto after = draw(engine, scene, console);
  if (!after) return after.error();
  if (const auto ok = warn_if_unseen(engine, scene, console); !ok) return ok.error();
  return std::vector<PredicatePanel>{
      {"strokes: show green, hide red",
       stroke_image(*scene.ct, scene.predicates->intensity, strokes, scene.width, scene.height)},
      {"before", *std::move(before), model, letters_of_view(scene)},
      {"after", *std::move(after), scene.predicates->model, letters_of_view(scene)}};
}

Result<std::vector<Stroke>> strokes_of(const PredicateOptions& options) {
  std::vector<Stroke> strokes;
  if (!options.scribbles.empty()) {
    auto read = read_scribble_file(options.scribbles);
    if (!read) return read.error();
    strokes = *std::move(read);
  }
  strokes.insert(strokes.end(), options.strokes.begin(), options.strokes.end());
  return strokes;
}

/// Names the file of an error about a stroke, if all strokes are from one.
Error with_file(const PredicateOptions& options, const Error& error) {
  const bool of_file =
      !options.scribbles.empty() && options.strokes.empty() && error.message.starts_with("stroke ");
  if (!of_file) return error;
  return {ErrorCode::kMalformedData, options.scribbles.string() + ": " + error.message};
}

}  // namespace

Result<void> run_predicates(const SessionConfig& config, Console& console) {
  const PredicateOptions& options = config.predicates;
  if (const auto ok = check_files(config); !ok) return ok;
  const auto strokes = strokes_of(options);
  if (!strokes) return strokes.error();
  auto engine = make_engine(config.output.engine, config.output.threads, console);
  if (!engine) return engine.error();
  auto made = prepare_predicates(options, config.output.threads, console, DistancesFrom::kOptions,
                                 *strokes);
  if (!made) return with_file(options, made.error());
  PredicateFile& file = made->file;
  const render::PredicateVolume& volume = made->volume;
  const auto& as_recorded = made->as_recorded;
  render::Scene scene = scene_of(config, volume);
  const auto panels = strokes->empty() ? compare(**engine, scene, as_recorded, console)
                                       : compare_scribbles(**engine, *strokes,
                                                           options.scribble_share, scene, console);
  if (!panels) return with_file(options, panels.error());
  warn_of_letters(scene.predicates->model, console);
  if (const auto ok = io::write_png(predicate_image(*panels), options.image); !ok) return ok;
  console.say("wrote " + options.image.string() + ": " + volume.name + " by predicate set " +
              file.name);
  if (options.save_set_up.empty()) return {};
  // The scene has the expressions that were resolved for this volume.
  file.model.histogram = scene.predicates->model.histogram;
  file.opacity_length_mm = scene.predicates->opacity_length_mm;
  return write_predicate_file(options.save_set_up, file);
}

}  // namespace nav::app
