// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <vector>

#include "render/gl/gl_feature_textures.hpp"
#include "render/gl/gl_label_texture.hpp"
#include "render/gl/gl_predicate_rows.hpp"
#include "render/gl/gl_program.hpp"
#include "render/gl/gl_stand_ins.hpp"
#include "render/gl/gl_textures.hpp"
#include "render/predicates/set.hpp"
#include "render/scene.hpp"
#include "render/skipping/predicate_brick_cache.hpp"

namespace nav::render {

/// The data on the device for images by predicates: features, labels, bricks and tables. Each
/// parameter, importance and hue is a table or a uniform. Internal to render/; needs the context
/// current.
class GlPredicates {
 public:
  /// Prepares for a validated scene with predicates whose volume is on the device as a whole, and
  /// sends what has changed. Returns kUnsupportedData if the device's memory is too small.
  Result<void> update(const Scene& scene);
  /// Approximate number of bytes that update() would have to send or to scan for a scene with this
  /// predicate set. offered: the scene's features.
  [[nodiscard]] std::size_t missing_bytes(const PredicateSet& set, const Features& offered) const;
  /// Sends about this many of those bytes, > 0. An image still needs update().
  Result<void> send_some(const PredicateSet& set, const Features& offered, std::size_t bytes);
  /// The form that must be compiled for the last scene.
  [[nodiscard]] const GlPredicateForm& form() const { return form_; }
  /// The form of a program that draws any set of the same kinds of importances and tables. Absent
  /// if the expressions of the last scene are nested too deeply.
  [[nodiscard]] std::optional<GlPredicateForm> generic_form() const;
  /// The CT in which the volume lies.
  struct Beside {
    double importance;   ///< Importance of the CT, as an impact.
    double farthest_mm;  ///< See set_brick_walk().
  };
  /// Sets the uniforms of the program in use, which is that of form() or of generic_form(), and
  /// binds the textures that it reads. beside: for two_volumes.frag.
  void bind(GlProgram& program, bool generic, const Scene& scene,
            const std::optional<Beside>& beside = {});
  void release();
  /// True if the last update() changed nothing that a sample could show.
  [[nodiscard]] bool unchanged() const { return unchanged_; }

  /// Reads the volume as pairs of voxels, which is cheaper than reading it with the features.
  void set_voxel_pairs(bool wanted) { voxel_pairs_ = wanted; }

  [[nodiscard]] std::size_t bricks() const { return importances_.size(); }
  [[nodiscard]] std::size_t bricks_occupied() const { return occupied_; }
  /// Internal format of the label texture; 0: none was sent yet. For tests.
  [[nodiscard]] int label_format() const { return labels_.format(); }
  [[nodiscard]] const GlFeatureTextures& features() const { return features_; }

 private:
  void send_appearances();
  void send_weights();
  void send_bricks();
  void send_opacity(double opacity_length_mm);
  Result<void> send_gradients(const std::shared_ptr<const StoredVolume>& source);
  void set_shading(GlProgram& program, const Scene& scene);
  [[nodiscard]] double measure(double importance) const;
  void set_march(GlProgram& program, const Scene& scene, const std::optional<Beside>& beside) const;
  void set_ends(GlProgram& program, const Scene& scene) const;
  void set_beside(GlProgram& program, const Scene& scene, const Beside& beside) const;
  void set_leaves(GlProgram& program) const;
  void set_rows(GlProgram& program);
  void set_readers(GlProgram& program) const;
  void bind_features(GlProgram& program, bool generic);
  /// Bits of the features that must be defined for a leaf.
  [[nodiscard]] std::uint32_t undefined_of(const PredicateSet::Leaf& leaf) const;

  std::optional<PredicateSet> set_;
  GlPredicateForm form_;
  bool unchanged_ = false;
  bool voxel_pairs_ = false;
  PredicateBrickCache known_;
  GlFeatureTextures features_;
  GlLabelTexture labels_;
  std::vector<double> importances_;  ///< One for each brick.
  std::size_t occupied_ = 0;
  double opacity_length_mm_ = 0;
  GlTexture brick_texture_, gradient_texture_;
  std::shared_ptr<const StoredVolume> gradients_of_;  ///< PredicateShading::source; null: none.
  GlStandIns stand_ins_;
  GlTable appearance_table_, weight_table_, opacity_table_, leaf_table_;
  std::optional<GlPredicateRows> rows_;
};

}  // namespace nav::render
