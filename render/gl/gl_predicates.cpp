// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include <vtk_glew.h>
// GLEW comes first, because every other GL header depends on it.
#include <algorithm>
#include <bit>
#include <cmath>
#include <future>

#include "render/cpu/predicate_early_ends.hpp"
#include "render/gl/gl_gradients.hpp"
#include "render/gl/gl_predicates.hpp"
#include "render/gl/gl_uniforms.hpp"
#include "render/gl/gl_upload.hpp"
#include "render/predicates/predicate_sampler.hpp"
#include "render/predicates/shader.hpp"
#include "render/skipping/predicate_brick_cache.hpp"
#include "render/spec/ray_spec.hpp"
#include "render/surfaces.hpp"

namespace nav::render {
namespace {

constexpr std::size_t kMostWeighed = 8;  // Up to this many, single precision holds the weights.
constexpr double kNeverReached = 2;      // An opacity that is never reached.

void bind_texture(int unit, GLenum target, GLuint texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(target, texture);
}

/// Size along an edge for this many bricks, never a power of two: Mesa's software
/// rasteriser compiles a program again if an edge becomes a power of two or stops being one.
int edge_of_bricks(int count) {
  const int least = std::max(count, 3);
  return std::has_single_bit(static_cast<unsigned>(least)) ? least + 1 : least;
}

/// Sends a table that is somewhat larger than needed. Mesa's software rasteriser takes bits 8 to 15
/// of the size in bytes of a buffer texture for the number of the last mipmap level. It compiles a
/// program anew if one size has these bits zero and another has not. Here they are never zero, up
/// to 12 tabulated leaves.
template <class Texel>
void send_roomy_table(GlTable& table, GLenum internal, std::vector<Texel> texels) {
  constexpr std::size_t kLeast = 256;
  constexpr std::size_t kMore = 16;
  static_assert(sizeof(Texel) == 16);
  texels.resize(std::max(texels.size(), kLeast) + kMore);
  gl::send_table(table, internal, texels);
}

bool same_weights(const PredicateSet& a, const PredicateSet& b) {
  return a.hue_mean() == b.hue_mean() &&
         std::equal(a.weights().begin(), a.weights().end(), b.weights().begin(), b.weights().end(),
                    [](const spec::PredicateWeight& x, const spec::PredicateWeight& y) {
                      return x.impact == y.impact && x.hue_deg == y.hue_deg &&
                             x.saturation == y.saturation;
                    });
}

bool same_programs(const PredicateSet& a, const PredicateSet& b) {
  const auto same_token = [](PredicateProgram::Token x, PredicateProgram::Token y) {
    return x.op == y.op && x.index == y.index;
  };
  return std::equal(a.programs().begin(), a.programs().end(), b.programs().begin(),
                    b.programs().end(), [&](const PredicateProgram& x, const PredicateProgram& y) {
                      return x.entry == y.entry &&
                             std::equal(x.tokens.begin(), x.tokens.end(), y.tokens.begin(),
                                        y.tokens.end(), same_token);
                    });
}

}  // namespace

Result<void> GlPredicates::update(const Scene& scene) {
  auto made = PredicateSet::create(*scene.predicates, scene.ct, position_of(scene));
  if (!made) return made.error();
  const gl::PackedRows packed;
  const bool other_appearances = !set_ || !same_weights(*set_, *made) ||
                                 !same_programs(*set_, *made) ||
                                 set_->leaves().size() != made->leaves().size();
  set_ = *std::move(made);
  // Runs while data is sent, because sending to a new texture mostly touches pages of memory one
  // after the other.
  std::future<bool> other_leaves;
  if (!known_.knows(*set_)) {
    other_leaves =
        std::async(std::launch::async, [this, set = *set_] { return known_.update(set, 0); });
  }
  const auto fail = [&](const Error& error) {
    set_.reset();
    return error;
  };
  features_.set_voxel_pairs(voxel_pairs_);
  gl::SendLimit limit;
  if (auto sent = features_.update(*set_, scene.predicates->features, limit); !sent) {
    return fail(sent.error());
  }
  if (set_->labels()) {
    if (auto sent = labels_.update(*set_->labels(), limit); !sent) return fail(sent.error());
  }
  const auto& shading = scene.predicates->shading;
  if (auto sent = send_gradients(shading ? shading->source : nullptr); !sent) {
    return fail(sent.error());
  }
  std::vector<PredicateTexel> texels;
  for (std::size_t c = 1; c < set_->channels().size(); ++c) {
    const auto slot = features_.slot(c);
    texels.push_back({static_cast<int>(slot.texture), slot.component});
  }
  form_ = {.text = predicate_shader(*set_, texels),
           .feature_textures = static_cast<int>(features_.used()),
           .feature_pairs = features_.used() > 0 && features_.has_voxel_pairs(),
           .volume_in_features = features_.has_volume() && !voxel_pairs_,
           .undefined = features_.has_undefined(),
           .labels = set_->labels().has_value(),
           .log_importance = set_->size() > kMostWeighed,
           .appearance_table = classes_of(*set_) != PredicateClasses::kNone,
           .shading = gradients_of_ != nullptr};
  std::vector<std::uint32_t> undefined;
  for (const auto& leaf : set_->leaves()) undefined.push_back(undefined_of(leaf));
  rows_ = predicate_rows(*set_, features_, undefined, labels_.bits());
  const bool leaves_changed = other_leaves.valid() && other_leaves.get();
  unchanged_ = !other_appearances && !leaves_changed;
  if (other_appearances) form_.appearance_table ? send_appearances() : send_weights();
  if (other_appearances || leaves_changed) send_bricks();
  if (opacity_length_mm_ != scene.predicates->opacity_length_mm)
    send_opacity(scene.predicates->opacity_length_mm);
  return {};
}

std::size_t GlPredicates::missing_bytes(const PredicateSet& set, const Features& offered) const {
  const std::size_t volume = set.channels()[0].codes->grid().voxel_count() * sizeof(std::int16_t);
  return features_.missing_bytes(set, offered) +
         (set.labels() ? labels_.missing_bytes(*set.labels()) : 0) +
         known_.missing_channels(set) * volume;
}

Result<void> GlPredicates::send_some(const PredicateSet& set, const Features& offered,
                                     std::size_t bytes) {
  const gl::PackedRows packed;
  gl::SendLimit limit{bytes};
  features_.set_voxel_pairs(voxel_pairs_);
  if (auto sent = features_.update(set, offered, limit); !sent) return sent;
  if (set.labels()) {
    if (auto sent = labels_.update(*set.labels(), limit); !sent) return sent;
  }
  const std::size_t volume = set.channels()[0].codes->grid().voxel_count() * sizeof(std::int16_t);
  while (limit.bytes > 0 && known_.prepare_channel(set, 0)) limit.take(1, volume);
  return {};
}

double GlPredicates::measure(double importance) const {
  return form_.log_importance ? importance : std::exp(importance - set_->greatest_impact());
}

void GlPredicates::send_appearances() {
  const bool by_leaves = classes_of(*set_) == PredicateClasses::kLeaves;
  const std::uint32_t count = 1U << (by_leaves ? set_->leaves().size() : set_->size());
  std::vector<Eigen::Vector4f> appearances;
  appearances.reserve(count);
  for (std::uint32_t bits = 0; bits < count; ++bits) {
    const spec::PredicateClass c = set_->class_of(by_leaves ? set_->mask_of(bits) : bits);
    Eigen::Vector4d appearance = Eigen::Vector4d::Zero();
    if (c.importance > 0) {
      appearance << spec::hsl_tint(c.hue_deg, c.saturation), std::max(measure(c.importance), 1e-37);
    }
    appearances.push_back(appearance.cast<float>());
  }
  send_roomy_table(appearance_table_, GL_RGBA32F, std::move(appearances));
}

void GlPredicates::send_weights() {
  std::vector<Eigen::Vector4f> texels;
  for (const spec::PredicateWeight& w : set_->weights()) {
    const double share = w.impact * w.saturation;
    const double angle = w.hue_deg * M_PI / 180;
    texels.push_back(Eigen::Vector4d(w.impact, share, w.hue_deg, 0).cast<float>());
    texels.push_back(
        Eigen::Vector4d(share * std::cos(angle), share * std::sin(angle), share * w.hue_deg, share)
            .cast<float>());
  }
  send_roomy_table(weight_table_, GL_RGBA32F, std::move(texels));
}

void GlPredicates::send_bricks() {
  const LeafBricks& leaves = known_.leaves();
  const BrickGrid& grid = known_.grid();
  importances_ = brick_importances(*set_, leaves, 0);
  occupied_ = static_cast<std::size_t>(
      std::count_if(importances_.begin(), importances_.end(), [](double i) { return i > 0; }));
  const std::vector<std::uint8_t> distances = visible_distances(grid, importances_);
  const std::vector<KnownAround> around = known_around(grid.count, importances_, leaves);
  constexpr double kRounding = 1 + 1e-5;
  std::vector<std::array<std::uint32_t, 4>> texels(importances_.size());
  for (std::size_t b = 0; b < texels.size(); ++b) {
    const KnownAround& known = around[b];
    const double importance = known.importance > 0 ? measure(known.importance) * kRounding : 0;
    texels[b] = {distances[b], std::bit_cast<std::uint32_t>(static_cast<float>(importance)),
                 known.sure, known.some & ~known.sure};
  }
  glBindTexture(GL_TEXTURE_3D, brick_texture_.id());
  gl::set_sampling(GL_TEXTURE_3D, GL_NEAREST);
  const auto room = grid.count.unaryExpr(&edge_of_bricks).eval();
  glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA32UI, room.x(), room.y(), room.z(), 0, GL_RGBA_INTEGER,
               GL_UNSIGNED_INT, nullptr);
  glTexSubImage3D(GL_TEXTURE_3D, 0, 0, 0, 0, grid.count.x(), grid.count.y(), grid.count.z(),
                  GL_RGBA_INTEGER, GL_UNSIGNED_INT, texels.data());
}

void GlPredicates::send_opacity(double opacity_length_mm) {
  const IntensityOpacity opacity(opacity_length_mm);
  const std::vector<float>& entries = opacity.entries();
  std::vector<Eigen::Vector2f> texels;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const float next = entries[std::min(i + 1, entries.size() - 1)];
    texels.emplace_back(entries[i], next - entries[i]);
  }
  gl::send_table(opacity_table_, GL_RG32F, texels);
  opacity_length_mm_ = opacity_length_mm;
}

Result<void> GlPredicates::send_gradients(const std::shared_ptr<const StoredVolume>& source) {
  if (source == gradients_of_) return {};
  gradients_of_ = nullptr;
  if (!source) {
    gradient_texture_.release();
    return {};
  }
  const std::vector<std::int16_t> differences = neighbour_differences(*source);
  if (differences.empty()) {
    return Error{ErrorCode::kUnsupportedData,
                 source->name() +
                     ": shading by predicates: expected neighbours that differ by at most 32767, "
                     "found more"};
  }
  const auto& size = source->grid().size;
  glBindTexture(GL_TEXTURE_3D, gradient_texture_.id());
  gl::set_sampling(GL_TEXTURE_3D, GL_LINEAR);
  glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA16_SNORM, size[0], size[1], size[2], 0, GL_RGBA, GL_SHORT,
               differences.data());
  if (glGetError() != GL_NO_ERROR) {
    return Error{ErrorCode::kUnsupportedData,
                 source->name() +
                     ": expected the gradients of shading within the memory of this OpenGL device, "
                     "found more; the CPU engine draws it"};
  }
  gradients_of_ = source;
  return {};
}

void GlPredicates::set_shading(GlProgram& program, const Scene& scene) {
  if (!form_.shading) return;
  const PredicateShading& shading = *scene.predicates->shading;
  const VoxelGrid& grid = scene.ct->grid();
  const Eigen::Matrix3d axes_from_local = grid.directions.transpose();
  program.set("predicate_axes_from_local", axes_from_local);
  program.set("predicate_half_per_spacing", Eigen::Vector3d(0.5 * grid.spacing_mm.cwiseInverse()));
  program.set("predicate_full_gradient", shading.full_gradient_per_mm);
  program.set("predicate_light", Eigen::Vector4d(shading.ambient, shading.diffuse, shading.specular,
                                                 shading.shininess));
  program.set("predicate_gradients", kPredicateGradients);
  bind_texture(kPredicateGradients, GL_TEXTURE_3D, gradient_texture_.id());
}

std::optional<GlPredicateForm> GlPredicates::generic_form() const {
  if (!rows_) return std::nullopt;
  return GlPredicateForm{.text = {},
                         .feature_textures = static_cast<int>(GlFeatureTextures::kMostTextures),
                         .feature_pairs = features_.has_voxel_pairs(),
                         .undefined = true,
                         .labels = true,
                         .log_importance = form_.log_importance,
                         .appearance_table = form_.appearance_table,
                         .shading = form_.shading,
                         .generic = true};
}

void GlPredicates::bind_features(GlProgram& program, bool generic) {
  Eigen::Vector3i counts = Eigen::Vector3i::Zero();
  for (std::size_t i = 0; i < features_.used(); ++i) {
    counts[static_cast<Eigen::Index>(i)] = features_.members(i);
  }
  program.set("feature_counts", counts);
  const std::size_t slots = generic ? GlFeatureTextures::kMostTextures : features_.used();
  for (std::size_t i = 0; i < slots; ++i) {
    program.set("features" + std::to_string(i), kFeatures + static_cast<int>(i));
    const bool pairs = features_.has_voxel_pairs();
    const unsigned stand_in = pairs ? stand_ins_.pairs() : stand_ins_.feature();
    bind_texture(kFeatures + static_cast<int>(i), pairs ? GL_TEXTURE_BUFFER : GL_TEXTURE_3D,
                 i < features_.used() ? features_.texture(i) : stand_in);
  }
}

void GlPredicates::bind(GlProgram& program, bool generic, const Scene& scene,
                        const std::optional<Beside>& beside) {
  if (generic) stand_ins_.update(scene.ct->grid().size);
  set_march(program, scene, beside);
  beside ? set_beside(program, scene, *beside) : set_ends(program, scene);
  generic ? set_rows(program) : set_leaves(program);
  set_readers(program);
  set_shading(program, scene);
  bind_features(program, generic);
  if (generic || form_.undefined) {
    bind_texture(kUndefined, GL_TEXTURE_3D,
                 form_.undefined ? features_.undefined_cells() : stand_ins_.undefined());
  }
  if (generic || form_.labels) {
    bind_texture(kLabels, GL_TEXTURE_3D, form_.labels ? labels_.id() : stand_ins_.labels());
  }
  bind_texture(kPredicateBricks, GL_TEXTURE_3D, brick_texture_.id());
  bind_texture(kOpacity, GL_TEXTURE_BUFFER, opacity_table_.texture.id());
  gl::bind_storage(gl::kOpacityStorage, opacity_table_.buffer_id());
  gl::bind_storage(gl::kAppearancesStorage, appearance_table_.buffer_id());
  bind_texture(
      kAppearances, GL_TEXTURE_BUFFER,
      form_.appearance_table ? appearance_table_.texture.id() : weight_table_.texture.id());
}

void GlPredicates::set_ends(GlProgram& program, const Scene& scene) const {
  const double error = scene.predicates->termination_error;
  const bool ends = error > 0;
  const auto budget = spec::early_ends<double>(error, !Surfaces(scene).empty());
  // Plain over never makes hidden material visible again.
  const bool over = set_->uniform();
  program.set("tests_bricks", static_cast<int>(scene.quality.skip_empty_bricks || ends));
  program.set("leave_out_from", ends && !over ? budget.leave_out_from : kNeverReached);
  program.set("leave_out_for", budget.leave_out_for);
  program.set("end_at", !ends ? kNeverReached : over ? 1 - error : budget.end_at);
  program.set("first_importance", measure(over ? set_->greatest_impact() : 0));
}

// Bricks do not know how much of the CT is still to come, so rays end by the greatest importance of
// all.
void GlPredicates::set_beside(GlProgram& program, const Scene& scene, const Beside& beside) const {
  const double greatest = set_->greatest_impact();
  const bool over = set_->uniform() && beside.importance >= greatest;
  const double error = scene.predicates->termination_error;
  program.set("tests_bricks", static_cast<int>(scene.quality.skip_empty_bricks));
  program.set("leave_out_from", kNeverReached);
  program.set("leave_out_for", 0.0);
  program.set("end_at", kNeverReached);
  program.set("first_importance", measure(over ? greatest : 0));
  program.set("ct_importance", measure(std::min(beside.importance, greatest)));
  program.set("ray_ends_at", error > 0 ? 1 - error : kNeverReached);
}

void GlPredicates::set_march(GlProgram& program, const Scene& scene,
                             const std::optional<Beside>& beside) const {
  const PredicateScene& predicates = *scene.predicates;
  const double greatest = set_->greatest_impact();
  program.set("leaps", static_cast<int>(scene.quality.skip_empty_bricks));
  program.set("surface_importance", measure(greatest));
  const PredicateSet::Channel& volume = set_->channels()[0];
  constexpr double kLast = PredicateScene::kTauEntries - 1;
  program.set("entry_of_volume", Eigen::Vector2d(volume.scale * kLast, volume.offset * kLast));
  program.set("last_entry", kLast);
  program.set("spacing_mm", scene.ct->grid().spacing_mm);
  program.set("feature_words", static_cast<int>(gl::words_of_pairs(scene.ct->grid().size)));
  program.set("cutaway_scale", predicates.cutaway_importance / std::max(greatest, 1e-30));
  program.set("cutaway_greatest", greatest);
  program.set("greatest_impact", greatest);
  program.set("entry_count", static_cast<int>(set_->size()));
  program.set("linear_hue", static_cast<int>(set_->hue_mean() == spec::HueMean::kLinear));
  for (const auto& [name, unit] : {std::pair{"appearances", kAppearances},
                                   {"weights", kAppearances},
                                   {"opacity", kOpacity},
                                   {"labels", kLabels},
                                   {"undefined_cells", kUndefined}}) {
    program.set(name, unit);
  }
  program.set("run_cells", std::max(1.0, std::floor(kBrickVoxels / scene.quality.step_voxels)));
  set_brick_walk(program, scene.ct->grid(), known_.grid().count, kPredicateBricks,
                 beside ? kSecond : "", beside ? beside->farthest_mm : 0);
}

void GlPredicates::set_leaves(GlProgram& program) const {
  const PredicateUniforms uniforms = predicate_uniforms(*set_);
  for (const auto& [name, value] : uniforms.values) program.set(name, value);
  for (const auto& [name, mask] : uniforms.masks)
    program.set_bits(name, packed_bits(mask, labels_.bits()));
  for (std::size_t c = 0; c < set_->channels().size(); ++c) {
    const PredicateSet::Channel& channel = set_->channels()[c];
    const std::string prefix = "channel" + std::to_string(c);
    program.set(prefix + "_scale", Eigen::Vector2d(channel.offset, channel.scale));
  }
  for (std::size_t i = 0; i < set_->leaves().size(); ++i) {
    program.set_bits("leaf" + std::to_string(i) + "_undefined", undefined_of(set_->leaves()[i]));
  }
}

std::uint32_t GlPredicates::undefined_of(const PredicateSet::Leaf& leaf) const {
  std::uint32_t undefined = 0;
  for (const int c : leaf.channels) {
    if (c > 0) undefined |= features_.slot(static_cast<std::size_t>(c)).undefined_bit;
  }
  return undefined;
}

void GlPredicates::set_rows(GlProgram& program) {
  send_roomy_table(leaf_table_, GL_RGBA32UI, rows_->texels);
  bind_texture(kLeaves, GL_TEXTURE_BUFFER, leaf_table_.texture.id());
  program.set("leaf_table", kLeaves);
  program.set("leaf_count", rows_->leaves);
  program.set("token_count", rows_->tokens);
  program.set("has_undefined", static_cast<int>(form_.undefined));
}

/// Sets which leaves read which texture.
void GlPredicates::set_readers(GlProgram& program) const {
  Eigen::Vector4i readers = Eigen::Vector4i::Zero();
  std::uint32_t label_leaves = 0;
  for (std::size_t i = 0; i < set_->leaves().size(); ++i) {
    const PredicateSet::Leaf& leaf = set_->leaves()[i];
    for (const int c : leaf.channels) {
      if (c == 0) continue;
      const auto slot = features_.slot(static_cast<std::size_t>(c));
      int& bits = readers[static_cast<Eigen::Index>(slot.texture)];
      bits = std::bit_cast<int>(std::bit_cast<std::uint32_t>(bits) | (1U << i));
    }
    if (leaf.labels) label_leaves |= 1U << i;
  }
  program.set("feature_leaves", readers);
  program.set("label_leaves", std::bit_cast<int>(label_leaves));
}

void GlPredicates::release() {
  features_.release();
  stand_ins_.release();
  labels_.release();
  brick_texture_.release();
  gradient_texture_.release();
  gradients_of_ = nullptr;
  for (GlTable* table : {&appearance_table_, &weight_table_, &opacity_table_, &leaf_table_}) {
    table->release();
  }
  set_.reset();
  opacity_length_mm_ = 0;
}

}  // namespace nav::render
