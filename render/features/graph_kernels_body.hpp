// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The inner loops of the graph solver. kernels_body.hpp includes this file, and its rules apply
// here too.

SONDE_INLINE Doubles widened(const float* from) {
  using Half = float __attribute__((vector_size(16), aligned(4), may_alias));
  return __builtin_convertvector(*reinterpret_cast<const Half*>(from), Doubles);
}

/// Converts weights of packed_weight() to floats.
SONDE_INLINE Floats unpacked(const unsigned short* from) {
#ifdef __AVX2__  // The compiler's code for the conversion below takes five operations.
  const __m128i halves = _mm_loadu_si128(reinterpret_cast<const __m128i_u*>(from));
  return reinterpret_cast<Floats>(_mm256_slli_epi32(_mm256_cvtepu16_epi32(halves), 16));
#else
  using Shorts = unsigned short __attribute__((vector_size(16)));
  using LooseShorts = unsigned short __attribute__((vector_size(16), aligned(2), may_alias));
  using Words = unsigned __attribute__((vector_size(32)));
  const Shorts halves = *reinterpret_cast<const LooseShorts*>(from);
  return reinterpret_cast<Floats>(__builtin_convertvector(halves, Words) << 16);
#endif
}

/// Uses differences: for nearly equal neighbours only their own rounding remains.
static void laplacian_rows(const GraphRow& g, const double* x, double* out, int count) {
  for (int i = 0; i < count; i += 4) {
    const Doubles here = load(x + i);
    Doubles sum = widened(g.leak + i) * here;
    for (int e = 0; e < kGraphEdges; ++e) {
      const long long step = g.offsets[e];
      sum += widened(g.after[e] + i) * (here - load(x + i + step));
      sum += widened(g.before[e] + i) * (here - load(x + i - step));
    }
    store(out + i, sum);
  }
}

/// Eight sums side by side, so that no addition waits for the previous one.
struct DoubleSums {
  Doubles low{}, high{};
};
SONDE_INLINE void add_products(DoubleSums& sums, const float* a, const float* b) {
  sums.low += widened(a) * widened(b);
  sums.high += widened(a + 4) * widened(b + 4);
}
SONDE_INLINE double total(const DoubleSums& sums) {
  const Doubles all = sums.low + sums.high;
  return (all[0] + all[1]) + (all[2] + all[3]);
}

/// A x for the eight nodes from i on.
SONDE_INLINE Floats packed_laplacian_at(const PackedRow& g, const float* x, int i) {
  const Floats here = load(x + i);
  Floats sum = load(g.leak + i) * here;
  for (int e = 0; e < kGraphEdges; ++e) {
    const long long step = g.offsets[e];
    sum += unpacked(g.weights[e] + i) * (here - load(x + i + step));
    sum += unpacked(g.weights[e] + i - step) * (here - load(x + i - step));
  }
  return sum;
}

static Products packed_laplacian_rows(const PackedRow& g, const float* x, float* out, int count) {
  DoubleSums xx, xo;
  for (int i = 0; i < count; i += 8) {
    store(out + i, packed_laplacian_at(g, x, i));
    add_products(xx, x + i, x + i);
    add_products(xo, x + i, out + i);
  }
  return {total(xx), total(xo)};
}

static void packed_residual_rows(const PackedRow& g, const float* b, const float* x, float* out,
                                 int count) {
  for (int i = 0; i < count; i += 8) {
    store(out + i, load(b + i) - packed_laplacian_at(g, x, i));
  }
}

static Products damped_step_rows(const float* x, const float* step, const float* pivot,
                                 const float* b, float damping, float scale, float* out,
                                 int count) {
  DoubleSums oo, ob;
  for (int i = 0; i < count; i += 8) {
    const Floats to = scale * (load(x + i) + damping * load(step + i));
    store(out + i, select(load(pivot + i) > 0.0F, to, all(0.0F)));
    add_products(oo, out + i, out + i);
    add_products(ob, out + i, b + i);
  }
  return {total(oo), total(ob)};
}

static void line_forward_rows(const unsigned short* w, const float* pivot, const float* before,
                              float* v, int count) {
  for (int i = 0; i < count; i += 8) {
    store(v + i, (load(v + i) + unpacked(w + i) * load(before + i)) * load(pivot + i));
  }
}

static void line_backward_rows(const unsigned short* w, const float* pivot, const float* after,
                               float* v, int count) {
  for (int i = 0; i < count; i += 8) {
    store(v + i, load(v + i) + load(pivot + i) * unpacked(w + i) * load(after + i));
  }
}

static double dot_rows(const float* a, const float* b, int count) {
  DoubleSums sums;
  for (int i = 0; i < count; i += 8) add_products(sums, a + i, b + i);
  return total(sums);
}

static double step_rows(float alpha, const float* p, const float* ap, float* e, float* r,
                        int count) {
  DoubleSums sums;
  for (int i = 0; i < count; i += 8) {
    store(e + i, load(e + i) + alpha * load(p + i));
    store(r + i, load(r + i) - alpha * load(ap + i));
    add_products(sums, r + i, r + i);
  }
  return total(sums);
}

static void edge_penalty_rows(const float* const here[3], const float* const there[3],
                              const float edge[3], float scale, float* out, int count) {
  for (int i = 0; i < count; i += 8) {
    const Floats x = load(here[0] + i) + load(there[0] + i);
    const Floats y = load(here[1] + i) + load(there[1] + i);
    const Floats z = load(here[2] + i) + load(there[2] + i);
    const Floats aside_x = edge[1] * z - edge[2] * y;
    const Floats aside_y = edge[2] * x - edge[0] * z;
    const Floats aside_z = edge[0] * y - edge[1] * x;
    const Floats aside = aside_x * aside_x + aside_y * aside_y + aside_z * aside_z;
    const Floats length = x * x + y * y + z * z;
    const Ints opposite = length <= 0.0F;
    const Floats share = scale * sqrt_of(aside / select(opposite, all(1.0F), length));
    store(out + i, select(opposite, all(0.0F), share));
  }
}

static void edge_weight_rows(const float* here, const float* there, const float* penalty,
                             const EdgeConstants& k, float* out, int count) {
  for (int i = 0; i < count; i += 8) {
    const Floats a = load(here + i);
    const Floats b = load(there + i);
    const Ints known = (a == a) & (b == b);
    const Floats apart = select(known, abs_of(a - b), all(0.0F));
    const Floats weight = exp_minus(k.beta * (apart + load(penalty + i))) + k.floor;
    store(out + i, select(known, weight, all(0.0F)));
  }
}
