// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/transfer/transfer_function.hpp"

namespace nav::render {

/// A transfer function at every whole HU from its first node to its last, within the range of
/// int16. Every engine classifies with this table, so it is the definition. Colour and extinction
/// are linear between entries and constant outside. Importance is that of the nearest entry,
/// because it may jump, and a fade in between would be invented. With gradient windows there is a
/// row of entries for each of kGradientRows equidistant gradient magnitudes, linear between rows
/// and constant beyond the last. Immutable.
class TransferTable {
 public:
  static constexpr int kGradientRows = 64;

  explicit TransferTable(const TransferFunction& transfer);

  /// Number of entries of a row.
  [[nodiscard]] int size() const { return size_; }
  [[nodiscard]] double first_hu() const { return first_hu_; }
  [[nodiscard]] double last_hu() const { return first_hu_ + size_ - 1; }
  /// 1 without gradient windows, else kGradientRows.
  [[nodiscard]] int rows() const { return rows_; }
  /// Gradient step from one row to the next, HU/mm.
  [[nodiscard]] double gradient_per_row() const { return gradient_per_row_; }
  /// Four values per entry, row after row: rgb, not premultiplied, and extinction per mm.
  [[nodiscard]] const std::vector<float>& rgbat() const { return rgbat_; }
  /// One value per entry, row after row. An invisible entry has the importance of the nearest
  /// visible entry of its row (the lower one of two; 0 if there is none). So a cell that reaches
  /// beyond the visible values fades like its visible part.
  [[nodiscard]] const std::vector<float>& importance() const { return importance_; }
  /// True if some visible entry has an importance < 1, so that a cutaway can change something.
  [[nodiscard]] bool importance_matters() const { return importance_matters_; }

  /// The appearance of a value (post-classification). Its importance is that of the nearest entry
  /// in the nearest row.
  [[nodiscard]] TransferSample at(double hu, double gradient_hu_per_mm = 0) const;
  /// The mean over all values between a and b, which lie on a straight line along a stretch of ray.
  /// It averages extinction, and colour weighted by extinction (pre-integrated classification:
  /// Engel et al. 2001, with integrals of one variable; second order in the length of the stretch).
  /// Colour times extinction is linear between entries here. The importance is 0. Precondition:
  /// rows() == 1.
  ///
  /// bow_hu: by how much the mean of the values lies above the mean of the line, (a + b) / 2. To
  /// first order the mean of f changes by the bow times the mean slope of f,
  /// (f(b) - f(a)) / (b - a). So a curved course costs no extra look-up, and it stays invisible if
  /// both ends are invisible. The change is limited to spec::kMaxBowShare of f(b) - f(a), because f
  /// may bend more than the values do.
  [[nodiscard]] TransferSample mean(double a_hu, double b_hu, double bow_hu = 0) const;

  /// The integrals of mean() at the entries, as whole numbers of quantum(), four per entry: colour
  /// times extinction, and extinction. Their differences are exact; differences of floats would
  /// cancel.
  [[nodiscard]] const std::vector<std::int32_t>& integrals() const { return integrals_; }
  /// The unit of integrals(), HU/mm.
  [[nodiscard]] double quantum() const { return quantum_; }

  /// Number of entries among the first i that are visible at some gradient: size() + 1 numbers.
  [[nodiscard]] const std::vector<int>& visible_before() const { return visible_before_; }
  /// True if some value in [low, high] HU may have an extinction > 0 at some gradient. The range is
  /// widened by one entry on either side against the rounding of interpolation.
  [[nodiscard]] bool visible(double low_hu, double high_hu) const;
  /// The greatest importance of the entries in a range, widened as for visible().
  [[nodiscard]] double max_importance(double low_hu, double high_hu) const;
  /// The greatest importance of all entries.
  [[nodiscard]] double max_importance() const {
    // The last level has at most two windows, which overlap.
    return std::max(importance_levels_.back().front(), importance_levels_.back().back());
  }
  /// True if some weight of a shading of this emphasis may exceed 0.
  [[nodiscard]] bool shades(double emphasis) const { return emphasis < 1 || max_importance() > 0; }
  /// The value up to which nothing is visible, HU: -infinity if the first entry is visible,
  /// infinity if none is.
  [[nodiscard]] double invisible_up_to_hu() const;

 private:
  struct Entries {
    std::size_t first;
    std::size_t last;
  };
  [[nodiscard]] Entries entries_in(double low_hu, double high_hu) const;
  [[nodiscard]] Eigen::Vector4d entry(std::size_t i) const;
  [[nodiscard]] Eigen::Vector4d premultiplied(std::size_t i) const;
  /// Like premultiplied(), linear between entries and constant outside.
  [[nodiscard]] Eigen::Vector4d premultiplied_at(double hu) const;
  [[nodiscard]] Eigen::Vector4d integral_to(double hu) const;
  void add_row(const TransferFunction& transfer, double gradient_hu_per_mm);
  void extend_importance();
  void integrate();
  void index_visible();

  double first_hu_;
  int size_;
  int rows_ = 1;
  double gradient_per_row_ = 0;
  std::vector<float> rgbat_;
  std::vector<float> importance_;
  bool importance_matters_ = false;
  std::vector<Eigen::Vector4d> cumulative_;  ///< Integral of premultiplied() from the first entry,
                                             ///< HU/mm.
  std::vector<std::int32_t> integrals_;
  double quantum_ = 1;
  std::vector<int> visible_before_;
  /// Greatest importance of 2^level entries from i on, level by level.
  std::vector<std::vector<float>> importance_levels_;
};

}  // namespace nav::render
