// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "sim/anatomy/organ_stack.hpp"

#include <algorithm>
#include <numbers>
#include <numeric>

namespace nav::sim {
namespace {

/// Share of a point's neighbourhood that an organ fills, computed from its distance.
template <class S>
S coverage(const S& distance_mm, double blend_mm) {
  return std::clamp(S(0.5 - distance_mm / S(blend_mm)), S(0.0), S(1.0));
}

template <class S>
bool is_none(const S& share) {
  return !(value_of(share) > 0);
}
template <class S>
bool is_whole(const S& share) {
  return value_of(share) >= 1;
}

/// Blends the organ's values over the present ones.
void mix(Acoustics& value, const Acoustics& own, float share) {
  value.impedance_mrayl += share * (own.impedance_mrayl - value.impedance_mrayl);
  value.attenuation_db_per_cm_mhz +=
      share * (own.attenuation_db_per_cm_mhz - value.attenuation_db_per_cm_mhz);
  value.scatter += share * (own.scatter - value.scatter);
  for (std::size_t i = 0; i < 3; ++i) {
    value.fibre[i] += share * (own.fibre[i] - value.fibre[i]);
    value.sheet[i] += share * (own.sheet[i] - value.sheet[i]);
  }
}

std::array<float, 3> float_array(const Vec3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

/// Three sets of septa, 60 degrees apart, which divide the muscle into bundles.
std::vector<Septa> septa_of(const Grain& grain, std::uint64_t seed) {
  if (!(grain.septa_mm > 0)) return {};
  constexpr int kSets = 3;
  constexpr double kEcho = 4.5;
  Random random(seed, 0x7365707461);
  const double angle = random.uniform(0, std::numbers::pi);
  const double spacing_mm = grain.septa_mm * random.uniform(0.7, 1.4);
  std::vector<Septa> sets;
  for (int i = 0; i < kSets; ++i) {
    const Eigen::AngleAxisd turn(angle + i * std::numbers::pi / kSets, grain.along);
    sets.emplace_back(grain.along, turn * grain.along.unitOrthogonal(), spacing_mm, kEcho,
                      hash_bits(seed, 0x736574, static_cast<std::uint64_t>(i)));
  }
  return sets;
}

}  // namespace

OrganStack::OrganStack(std::vector<Organ> organs, const Eigen::AlignedBox3d& box, double cell_mm,
                       Blend blend, Contrast contrast, std::uint64_t seed)
    : organs_(std::move(organs)),
      grid_(organs_, box, cell_mm),
      blend_(blend),
      strands_(hash_bits(seed, 0x737472616e6473, 0), 1.0) {
  for (std::size_t t = 0; t < hu_.size(); ++t) {
    hu_[t] = tissue_hu(static_cast<Tissue>(t), contrast);
  }
  for (const Organ& organ : organs_) {
    Acoustics alone = tissue_acoustics(Tissue::kAir);
    mix(alone, tissue_acoustics(organ.tissue), 1);
    alone_.push_back(alone);
    const Vec3d a = organ.grain.along.unitOrthogonal();
    beside_.push_back({a, organ.grain.along.cross(a)});
  }
  septa_.reserve(organs_.size());
  for (const Organ& organ : organs_) {
    septa_.push_back(septa_of(organ.grain, hash_bits(seed, 0x7365707461, septa_.size())));
  }
}

Tissue OrganStack::topmost(const OrgansNear& near, const Vec3d& p) const {
  for (std::size_t i = near.indices.size(); i-- > 0;) {
    const Organ& organ = organs_[near.indices[i]];
    if ((i == 0 && near.first_fills) || organ.distance_mm(p) < 0) return organ.tissue;
  }
  return Tissue::kAir;
}

Tissue OrganStack::tissue(const Vec3d& p) const { return topmost(grid_.organs_at(p), p); }

Tissue OrganStack::tissue_exhaustive(const Vec3d& p) const {
  std::vector<std::uint16_t> all(organs_.size());
  std::iota(all.begin(), all.end(), std::uint16_t{0});
  return topmost({all, false}, p);
}

/// Calls mix(organ, share) from the lowest organ up; each covers the ones below by its share.
/// Organs that are fully covered are not evaluated. \p q: p, as double or Dual.
template <class S, class Mix>
void OrganStack::cover(const Vec3d& p, const Vec3<S>& q, double blend_mm, const Mix& mix) const {
  const OrgansNear near = grid_.organs_at(p);
  // Number of stored shares; organs further down are evaluated again on the way up.
  constexpr std::size_t kMost = 32;
  std::array<S, kMost> shares;
  const std::size_t count = near.indices.size();
  const std::size_t kept = count - std::min(count, kMost);
  const auto share_of = [&](std::size_t i) {
    return i == 0 && near.first_fills
               ? S(1.0)
               : coverage<S>(organs_[near.indices[i]].distance_mm(q), blend_mm);
  };
  std::size_t lowest = count;
  while (lowest > kept) {
    --lowest;
    shares[lowest - kept] = share_of(lowest);
    if (is_whole(shares[lowest - kept])) break;
  }
  if (lowest == kept && !(lowest < count && is_whole(shares[0]))) lowest = 0;
  for (std::size_t i = lowest; i < count; ++i) {
    const S share = i < kept ? share_of(i) : shares[i - kept];
    if (!is_none(share)) mix(organs_[near.indices[i]], share);
  }
}

template <class S>
S OrganStack::hu_at(const Vec3d& p, const Vec3<S>& q) const {
  S value(hu_[static_cast<std::size_t>(Tissue::kAir)]);
  cover(p, q, blend_.ct_mm, [&](const Organ& organ, const S& share) {
    value += share * (hu_[static_cast<std::size_t>(organ.tissue)] - value);
  });
  return value;
}

double OrganStack::hu(const Vec3d& p) const { return hu_at<double>(p, p); }

ValueAndGradient OrganStack::hu_with_gradient(const Vec3d& p) const {
  const Dual value = hu_at<Dual>(p, seed(p));
  return {value.value, {value.gradient}};
}

Acoustics OrganStack::acoustics(const Vec3d& p) const {
  Acoustics value = tissue_acoustics(Tissue::kAir);
  cover(p, p, blend_.acoustic_mm, [&](const Organ& organ, double part) {
    const auto share = static_cast<float>(part);
    if (organ.grain.strength <= 0 && organ.layers.empty()) {
      // An organ that fills the point comes first: those below it are not evaluated.
      if (share >= 1) {
        value = alone_[index_of(organ)];
      } else {
        mix(value, tissue_acoustics(organ.tissue), share);
      }
      return;
    }
    Acoustics own = tissue_acoustics(organ.tissue);
    if (organ.grain.strength > 0) {
      own.scatter *= static_cast<float>(organ.grain.between) * strands(organ, p);
      own.fibre = float_array(organ.grain.strength * organ.grain.along);
    }
    own.sheet = float_array(sheet(organ, p));
    mix(value, own, share);
  });
  return value;
}

/// Echo along the unit normal of the strongest among an organ's layers and septa.
Vec3d OrganStack::sheet(const Organ& organ, const Vec3d& p) const {
  double echo = 0;
  for (const WallLayer& layer : organ.layers) {
    echo = std::max(echo, layer.echo_at(organ.distance_mm(p)));
  }
  if (echo > 0) return echo * organ.distance_mm(seed(p)).gradient.normalized();
  const Septa* best = nullptr;
  for (const Septa& septa : septa_[index_of(organ)]) {
    const double own = septa.echo(p);
    if (!(own > echo)) continue;
    echo = own;
    best = &septa;
  }
  if (best == nullptr) return Vec3d::Zero();
  return echo * best->offset_mm(seed(p)).gradient.normalized();
}

/// Brightness of the strand at a point, about 1 on average: noise that is stretched along the
/// fibres.
float OrganStack::strands(const Organ& organ, const Vec3d& p) const {
  const Grain& grain = organ.grain;
  const auto& [a, b] = beside_[index_of(organ)];
  const Vec3d cells(p.dot(grain.along) / grain.length_mm, p.dot(a) / grain.spacing_mm,
                    p.dot(b) / grain.spacing_mm);
  constexpr float kContrast = 2.2F;  // Trilinear noise rarely reaches its limits.
  const auto strength = static_cast<float>(grain.strength);
  return std::max(0.1F, 1 + kContrast * strength * strands_.at(cells));
}

}  // namespace nav::sim
