// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/window/predicate_desk.hpp"

#include <utility>

#include "app/window/theme.hpp"

namespace nav::app {

PredicateDesk::PredicateDesk(const PerView<FlatWidget*>& flat, int threads, Hears hears,
                             QWidget* parent)
    : flat_(flat),
      hears_(std::move(hears)),
      page_(new PredicatePage(editor_, parent)),
      thread_(threads, [this](PredicateThread::Done done) {
        if (box_.put(std::move(done))) hears_.wake();
      }) {
  page_->edited = [this] { order(); };
  page_->brush_changed = [this] { use_brush(); };
  page_->preset_chosen = [this](const QString& name) { use_preset(name); };
  for (const ViewId id : kFlatViews) {
    if (!is_orthogonal(id)) continue;
    flat_[id]->stroked = [this](render::features::Stroke stroke) {
      editor_.add_stroke(std::move(stroke));
      page_->refresh();
      order();
    };
  }
}

void PredicateDesk::follow(const std::shared_ptr<const PredicateSource>& source) {
  if (source == source_) return;
  source_ = source;
  editor_ = render::PredicateEditor(source_ ? source_->file.model : render::PredicateModel{});
  failed_ = false;
  ordered_ = answered_ = 0;
  page_->set_volume(source_ != nullptr);
  show_strokes();
  hears_.ready(nullptr);
}

void PredicateDesk::restore(render::PredicateModel before_strokes,
                            const std::vector<render::features::Stroke>& strokes) {
  editor_.replace(std::move(before_strokes));
  for (const auto& stroke : strokes) editor_.add_stroke(stroke);
  page_->refresh();
  order();
}

void PredicateDesk::choose(std::size_t bar) {
  if (bar >= editor_.model().entries.size()) return;
  editor_.select(bar);
  page_->refresh();
}

void PredicateDesk::order() {
  if (!source_) return;
  show_strokes();
  revision_ = editor_.revision();
  ++ordered_;
  thread_.prepare({.source = source_,
                   .model = editor_.before_strokes(),
                   .strokes = editor_.strokes(),
                   .share = source_->options.scribble_share,
                   .revision = revision_});
}

void PredicateDesk::take() {
  auto done = box_.take();
  if (!done || !source_) return;
  if (done->revision == revision_) answered_ = ordered_;
  failed_ = !done->failure.empty();
  if (failed_) {
    page_->say(QStringLiteral("The 3D view shows the set before: ") + theme::plain(done->failure));
  } else if (!done->words.empty()) {
    page_->say(theme::plain(done->words));
  }
  if (done->scribbled && editor_.finish_scribble(done->revision, *std::move(done->scribbled))) {
    page_->refresh();
  }
  if (done->volume) hears_.ready(std::move(done->volume));
}

QString PredicateDesk::state() const {
  if (!source_) return QStringLiteral("none");
  if (ordered_ != answered_) return QStringLiteral("busy");
  return failed_ ? QStringLiteral("failed") : QStringLiteral("ready");
}

void PredicateDesk::show_strokes() {
  for (const ViewId id : kFlatViews) {
    if (is_orthogonal(id)) flat_[id]->set_strokes(editor_.strokes());
  }
}

void PredicateDesk::use_brush() {
  const auto brush = source_ ? page_->brush() : std::nullopt;
  hears_.show_ultrasound(brush.has_value());
  for (const ViewId id : kFlatViews) {
    if (is_orthogonal(id)) flat_[id]->set_brush(brush);
  }
}

void PredicateDesk::use_preset(const QString& name) {
  auto preset = render::preset_predicates(name.toStdString());
  if (!preset) return page_->say(theme::plain(preset.error().message));
  editor_.replace(*std::move(preset));
  page_->say({});
  page_->refresh();
  order();
}

}  // namespace nav::app
