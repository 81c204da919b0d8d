// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Compositing by importance, front to back: render/spec/predicate_spec.hpp. With LOG_IMPORTANCE
// importances are used as they are. Otherwise they are weights exp(I - greatest), which need
// neither exp nor log. If all importances are equal, both forms begin at the greatest one, which
// gives plain over.

uniform float first_importance;
uniform float leave_out_for;  // spec::EarlyEnds
uniform float surface_importance;  // Importance of surfaces: the greatest.

struct Light {
  vec3 rgb;  // Not premultiplied; without the ultrasound image.
  float alpha;
  float importance;
  float image;  // Share of the ultrasound image in the colour.
};

Light light;
bool left_out;  // spec::LeftOut
float paid;
float spent_importance;

void begin_light() {
  left_out = false;
  paid = 0.0;
  spent_importance = 0.0;
  light = Light(vec3(0.0), 0.0, first_importance, 0.0);
}

// The share of the present colour that surely stays visible when material of an importance follows;
// to be multiplied by alpha.
float kept_before(float importance) {
#ifdef LOG_IMPORTANCE
  return exp(-max(importance - light.importance, 0.0));
#else
  return min(light.importance / max(importance, 1.0e-37), 1.0);
#endif
}

// spec::composite_log() or composite_weight(). An opacity of 0 changes nothing.
void blend(vec3 rgb, float opacity, float importance, float image) {
  precise float a = min(light.alpha, kept_before(importance));
  precise float over = (1.0 - a) * opacity;
  precise float beta = opacity > 0.0 ? over / max(a + over, 1.0e-37) : 0.0;
  light.rgb = fma(vec3(beta), rgb - light.rgb, light.rgb);
  light.image = fma(beta, image - light.image, light.image);
  light.alpha = fma(1.0 - light.alpha, opacity, light.alpha);
  float before = light.importance;
#ifdef LOG_IMPORTANCE
  float kept = kept_before(importance);
  float gained = importance + log(max(opacity + (1.0 - opacity) * kept, 1.0e-37));
  if (opacity > 0.0) light.importance = max(light.importance, gained);
#else
  light.importance = max(light.importance, fma(opacity, importance - light.importance, light.importance));
#endif
  if (light.importance > before) paid = 0.0;
}

// spec::LeftOut::pay() for material of at most this importance.
bool can_leave_out(float importance) {
  if (!(importance > 0.0)) return true;
  float from = max(paid, light.importance);
  float rise = max(importance - from, 0.0);
#ifdef LOG_IMPORTANCE
  // An upper bound of the formula, whose exponents are at most ln(1 + leave_out_for).
  float cost = rise * (1.0 + leave_out_for) * (1.0 + 0.5 * leave_out_for);
#else
  float cost = rise / max(light.importance, 1.0e-37);
#endif
  float after = (left_out ? spent_importance : 2.0 * (1.0 - light.alpha)) + cost;
  if (!(after <= leave_out_for)) return false;
  left_out = true;
  spent_importance = after;
  paid = max(paid, importance);
  return true;
}
