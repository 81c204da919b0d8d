// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/render_costs.hpp"

#include <cmath>
#include <functional>
#include <iomanip>
#include <optional>
#include <sstream>

#include "bench/moving_camera.hpp"
#include "bench/scene_set.hpp"
#include "render/engine.hpp"

namespace nav::bench {
namespace {

using Change = std::function<void(render::Scene&)>;

/// An element, as changes of the bare scene (CT alone, unshaded).
struct Element {
  std::string name;
  Change without;  ///< Scene that the element is added to.
  Change with;     ///< This scene with the element.
  Change idle;     ///< This scene with the element idle; empty: it cannot be idle.
};

render::TransferFunction clear_everywhere() {
  auto made = render::TransferFunction::create("clear",
                                               {{-1024, {1, 1, 1}, 0, 0}, {3000, {1, 1, 1}, 0, 0}});
  NAV_CHECK(made.has_value());
  return *made;
}

/// The function with one importance at all nodes.
render::TransferFunction of_importance(const render::TransferFunction& transfer,
                                       double importance) {
  std::vector<render::TransferComponent> components = transfer.components();
  for (auto& component : components) {
    for (auto& node : component.nodes) node.importance = importance;
  }
  auto made = render::TransferFunction::blend(transfer.name(), std::move(components));
  NAV_CHECK(made.has_value());
  return *made;
}

const Change kNothing = [](render::Scene&) {};

Change shaded(render::ShadingStyle style, double emphasis) {
  return [=](render::Scene& s) {
    s.shading.enabled = true;
    s.shading.style = style;
    s.shading.emphasis = emphasis;
  };
}

void add_optics(const render::Scene& all, std::vector<Element>& elements) {
  using enum render::ShadingStyle;
  const Change clear = [](render::Scene& s) { s.transfer = clear_everywhere(); };
  elements.push_back({"volume: sampling, pre-integrated classification", clear, kNothing, {}});
  elements.push_back(
      {"  post-classified instead",
       kNothing,
       [](render::Scene& s) { s.quality.classification = render::Classification::kPostClassified; },
       {}});
  elements.push_back({"shading, Phong", kNothing, shaded(kPhong, 0), [&all](render::Scene& s) {
                        s.transfer = of_importance(all.transfer, 0);
                        shaded(kPhong, 1)(s);
                      }});
  elements.push_back(
      {"  importance emphasis, E = 0.5", shaded(kPhong, 0), shaded(kPhong, 0.5), {}});
  elements.push_back({"  Gooch instead of Phong", shaded(kPhong, 0), shaded(kGooch, 0), {}});
  elements.push_back({"jitter", kNothing, [](render::Scene& s) { s.quality.jitter = true; }, {}});
  elements.push_back({"skipping of empty bricks",
                      [](render::Scene& s) { s.quality.skip_empty_bricks = false; },
                      [](render::Scene& s) { s.quality.skip_empty_bricks = true; },
                      {}});
  elements.push_back(
      {"early termination", [](render::Scene& s) { s.quality.opaque_at = 1; }, kNothing, {}});
}

void add_surfaces(const render::Scene& all, std::vector<Element>& elements) {
  const Change plane = [&all](render::Scene& s) { s.plane = all.plane; };
  elements.push_back({"ultrasound plane", kNothing, plane, [&all](render::Scene& s) {
                        s.plane = all.plane;
                        s.plane->safety = {SafetyState::kLost, "measured as lost"};
                      }});
  elements.push_back({"contextual cutaway about the plane", plane,
                      [&all](render::Scene& s) {
                        s.plane = all.plane;
                        s.cutaway = all.cutaway;
                      },
                      [&all](render::Scene& s) {  // The plane stays; the cutaway is about nothing.
                        s.plane = all.plane;
                        s.cutaway = all.cutaway;
                        s.cutaway->around_plane = s.cutaway->around_needle = false;
                        s.cutaway->around_spheres = false;
                      }});
  elements.push_back({"needle", kNothing, [&all](render::Scene& s) { s.needle = all.needle; },
                      [&all](render::Scene& s) {
                        s.needle = all.needle;
                        s.needle->safety = {SafetyState::kLost, "measured as lost"};
                      }});
  elements.push_back({"spheres (" + std::to_string(all.spheres.size()) + ")", kNothing,
                      [&all](render::Scene& s) { s.spheres = all.spheres; }, kNothing});
  elements.push_back({"lines (" + std::to_string(all.lines.size()) + ")", kNothing,
                      [&all](render::Scene& s) { s.lines = all.lines; }, kNothing});
}

std::int64_t less(std::uint64_t a, std::uint64_t b) {
  return static_cast<std::int64_t>(a) - static_cast<std::int64_t>(b);
}

Result<ElementCost> measure(const Element& element, const render::Scene& base,
                            const Repeats& repeats) {
  std::vector<MovingCamera> drawn;
  for (const Change& change : {element.without, element.with, element.idle}) {
    if (!change) continue;
    render::Scene scene = base;
    change(scene);
    drawn.emplace_back(std::move(scene));
  }
  std::vector<Task> tasks;
  for (MovingCamera& one : drawn) {
    if (auto warm = one.draw(0); !warm) return warm.error();
    tasks.push_back([&one] { return one.draw(); });
  }
  const auto taken = time_in_turn(tasks, repeats);
  if (!taken) return taken.error();
  const auto of = [&](std::size_t i) { return drawn[i].statistics(); };
  ElementCost cost{element.name};
  const auto difference_ms = [&](std::size_t i) {
    return 1e3 * ((*taken)[i].cpu_s - (*taken)[0].cpu_s);
  };
  const auto scatter_ms = [&](std::size_t i) {
    return 1e3 * std::hypot((*taken)[i].cpu_scatter_s, (*taken)[0].cpu_scatter_s);
  };
  cost.ms = difference_ms(1);
  cost.scatter_ms = scatter_ms(1);
  // Counts are taken from the same image, because some cameras may have drawn more images.
  for (MovingCamera& one : drawn) {
    if (auto last = one.draw(0); !last) return last.error();
  }
  cost.samples = less(of(1).volume_samples, of(0).volume_samples);
  cost.gradients = less(of(1).gradient_samples, of(0).gradient_samples);
  if (!element.idle) return cost;
  cost.has_idle = true;
  cost.idle_ms = difference_ms(2);
  cost.idle_scatter_ms = scatter_ms(2);
  cost.idle_samples = less(of(2).volume_samples, of(0).volume_samples);
  cost.idle_gradients = less(of(2).gradient_samples, of(0).gradient_samples);
  return cost;
}

/// A change of the whole scene from image to image.
struct SceneChange {
  std::string name;
  std::function<void(render::Scene&, int frame)> apply;
  Change of = kNothing;  ///< Elements of the scene that are drawn, before and after the change.
};

void move_plane(render::Scene& scene, int frame) {
  const auto& pose = scene.plane->ct_from_image;
  const Eigen::Vector3d along = pose.rotation() * Eigen::Vector3d::UnitZ();
  scene.plane->ct_from_image = {pose.rotation(), pose.translation_mm() + frame * along};
}

UltrasoundImage brighter(const UltrasoundImage& frame, int by) {
  std::vector<std::uint8_t> pixels(frame.pixels.pixels().begin(), frame.pixels.pixels().end());
  for (auto& p : pixels) p = static_cast<std::uint8_t>(p + by);
  UltrasoundImage out = frame;
  out.pixels = {frame.pixels.width(), frame.pixels.height(), std::move(pixels)};
  ++out.sequence;
  return out;
}

std::vector<SceneChange> scene_changes() {
  return {{"nothing", [](render::Scene&, int) {}},
          {"new ultrasound image, same pose",
           [](render::Scene& s, int frame) { s.plane->frame = brighter(s.plane->frame, frame); }},
          {"plane moved 1 mm", move_plane},
          {"plane moved 1 mm, no cutaway", move_plane, [](render::Scene& s) { s.cutaway.reset(); }},
          {"needle advanced 1 mm",
           [](render::Scene& s, int frame) {
             const Eigen::Vector3d along = (s.needle->tip_ct.mm - s.needle->hub_ct.mm).normalized();
             s.needle->tip_ct.mm += frame * along;
             s.needle->hub_ct.mm += frame * along;
           }},
          {"camera moved", [](render::Scene& s, int frame) { s = nudged(s, 1000 * frame); }},
          {"transfer function edited",
           [](render::Scene& s, int frame) {
             auto components = s.transfer.components();
             for (auto& node : components.front().nodes) node.opacity *= 1 - 0.001 * frame;
             auto edited = render::TransferFunction::blend(s.transfer.name(), components);
             NAV_CHECK(edited.has_value());
             s.transfer = *edited;
           }},
          {"another CT of the same size", [](render::Scene& s, int) {
             const auto values = s.ct->values();
             auto copy =
                 StoredVolume::create(s.ct->grid(), {values.begin(), values.end()}, s.ct->name());
             NAV_CHECK(copy.has_value());
             s.ct = std::make_shared<const StoredVolume>(*copy);
           }}};
}

Result<ChangeCost> measure(const SceneChange& change, const render::Scene& scene,
                           const Repeats& repeats) {
  ChangeCost cost{change.name};
  std::vector<double> cpu, wall, prepare;
  const auto engine = render::make_cpu_engine();
  for (int frame = 0; frame <= repeats.times; ++frame) {
    render::Scene changed = scene;
    change.of(changed);
    if (frame > 0) change.apply(changed, frame);
    render::RenderStatistics statistics;
    const auto taken = time_in_turn({[&]() -> Result<void> {
                                      auto image = engine->render(changed);
                                      if (!image) return image.error();
                                      statistics = image->statistics;
                                      return {};
                                    }},
                                    {1, 0});
    if (!taken) return taken.error();
    if (frame == 0) continue;  // Fills the caches.
    cpu.push_back(1e3 * taken->front().cpu_s);
    wall.push_back(1e3 * taken->front().wall_s);
    prepare.push_back(1e3 * statistics.prepare_s);
    cost.samples = statistics.volume_samples;
    cost.gradients = statistics.gradient_samples;
  }
  cost.ms = median(cpu);
  cost.wall_ms = median(wall);
  cost.prepare_ms = median(prepare);
  return cost;
}

}  // namespace

Result<CostTable> measure_costs(const render::Scene& scene, const Repeats& repeats) {
  if (!scene.ct || !scene.plane || !scene.needle || scene.spheres.empty() || scene.lines.empty() ||
      !scene.cutaway) {
    return Error{ErrorCode::kUsage,
                 "costs: expected CT, plane, needle, spheres, lines and cutaway in the scene, "
                 "found some of them missing"};
  }
  CostTable table;
  MovingCamera whole(scene);
  if (auto warm = whole.draw(); !warm) return warm.error();
  const auto taken = time_in_turn({[&] { return whole.draw(); }}, repeats);
  if (!taken) return taken.error();
  table.frame_ms = 1e3 * taken->front().cpu_s;
  table.frame_samples = whole.statistics().volume_samples;
  std::vector<Element> elements;
  add_optics(scene, elements);
  add_surfaces(scene, elements);
  for (const Element& element : elements) {
    auto cost = measure(element, bare(scene), repeats);
    if (!cost) return cost.error();
    table.elements.push_back(std::move(*cost));
  }
  for (const SceneChange& change : scene_changes()) {
    auto cost = measure(change, scene, repeats);
    if (!cost) return cost.error();
    table.changes.push_back(std::move(*cost));
  }
  return table;
}

std::string to_text(const CostTable& table) {
  std::ostringstream out;
  out << std::fixed << std::setprecision(2)
      << "Cost of every element, CPU engine, process ms (all threads): the image with it minus the "
         "image\nwithout it, and the scatter of such differences. idle: the element is in the "
         "scene without\neffect. Whole scene: "
      << table.frame_ms << " ms, " << table.frame_samples << " samples.\n\n"
      << std::left << std::setw(50) << "element" << std::right << std::setw(9) << "ms"
      << std::setw(8) << "+-" << std::setw(12) << "samples" << std::setw(12) << "gradients"
      << std::setw(10) << "idle ms" << std::setw(8) << "+-" << std::setw(12) << "samples"
      << std::setw(12) << "gradients" << '\n';
  for (const ElementCost& cost : table.elements) {
    out << std::left << std::setw(50) << cost.element << std::right << std::setw(9) << cost.ms
        << std::setw(8) << cost.scatter_ms << std::setw(12) << cost.samples << std::setw(12)
        << cost.gradients;
    if (cost.has_idle) {
      out << std::setw(10) << cost.idle_ms << std::setw(8) << cost.idle_scatter_ms << std::setw(12)
          << cost.idle_samples << std::setw(12) << cost.idle_gradients;
    }
    out << '\n';
  }
  out << '\n'
      << std::left << std::setw(50) << "from one image to the next" << std::right << std::setw(9)
      << "ms" << std::setw(12) << "wall ms" << std::setw(12) << "prepare" << std::setw(12)
      << "samples" << std::setw(12) << "gradients" << '\n';
  for (const ChangeCost& cost : table.changes) {
    out << std::left << std::setw(50) << cost.change << std::right << std::setw(9) << cost.ms
        << std::setw(12) << cost.wall_ms << std::setw(12) << cost.prepare_ms << std::setw(12)
        << cost.samples << std::setw(12) << cost.gradients << '\n';
  }
  if (table.preparations.empty()) return out.str();
  out << '\n'
      << std::left << std::setw(56) << "prepared once, before an image" << std::right
      << std::setw(9) << "ms" << std::setw(12) << "wall ms" << '\n';
  for (const PreparationCost& cost : table.preparations) {
    out << std::left << std::setw(56) << cost.what << std::right << std::setw(9) << cost.ms
        << std::setw(12) << cost.wall_ms << '\n';
  }
  return out.str();
}

}  // namespace nav::bench
