// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>

#include "app/window/flat_widget.hpp"
#include "app/window/predicate_page.hpp"
#include "app/window/predicate_thread.hpp"

namespace nav::app {

/// Keeps the predicate set that the user edits: has it prepared on a thread of its own, hands it to
/// the 3D view, and shows the scribbles on the slices. Window's thread.
class PredicateDesk {
 public:
  struct Hears {
    /// A set is ready to be drawn.
    std::function<void(std::shared_ptr<const render::PredicateVolume>)> ready;
    /// Slices show the 3D ultrasound (a brush is in use), or what they showed before.
    std::function<void(bool)> show_ultrasound;
    /// Wakes the window's thread, from any thread.
    std::function<void()> wake;
  };
  /// The widgets live as long as \p parent. threads: of the features, 0 for all cores.
  PredicateDesk(const PerView<FlatWidget*>& flat, int threads, Hears hears, QWidget* parent);
  ~PredicateDesk() { thread_.stop(); }

  void start() { thread_.start(); }
  void stop() { thread_.stop(); }
  /// Follows the volume of the session: another one begins with its own set.
  void follow(const std::shared_ptr<const PredicateSource>& source);
  /// Takes over a set and strokes that were saved, as edits. Precondition: has_volume().
  void restore(render::PredicateModel before_strokes,
               const std::vector<render::features::Stroke>& strokes);
  /// Chooses a bar, if the set has so many.
  void choose(std::size_t bar);
  /// Takes over what the thread has prepared.
  void take();

  [[nodiscard]] PredicatePage& page() const { return *page_; }
  [[nodiscard]] const render::PredicateEditor& editor() const { return editor_; }
  [[nodiscard]] bool has_volume() const { return source_ != nullptr; }
  /// State in one word: "none", "ready", "busy" or "failed".
  [[nodiscard]] QString state() const;

 private:
  void order();
  void show_strokes();
  void use_brush();
  void use_preset(const QString& name);

  PerView<FlatWidget*> flat_;
  Hears hears_;
  std::shared_ptr<const PredicateSource> source_;
  render::PredicateEditor editor_;
  PredicatePage* page_;
  Mailbox<PredicateThread::Done> box_;
  PredicateThread thread_;
  bool failed_ = false;
  std::uint64_t ordered_ = 0;  ///< Counts orders, so that answers tell which one they are of.
  std::uint64_t answered_ = 0;
  std::uint64_t revision_ = 0;  ///< Revision of the newest order.
};

}  // namespace nav::app
