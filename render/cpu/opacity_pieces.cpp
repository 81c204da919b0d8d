// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/cpu/opacity_pieces.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace nav::render {

std::optional<OpacityPieces> opacity_pieces(const IntensityOpacity& extinction, double step_mm) {
  constexpr double kMostError = 1e-3;
  constexpr int kFactors = OpacityPieces::kFactors;
  using Factors = Eigen::Matrix<double, kFactors, 1>;
  const auto powers = [](double t) {
    Factors out = Factors::Ones();
    for (int i = 1; i < kFactors; ++i) out[i] = out[i - 1] * t;
    return out;
  };
  // Radau's points, and the end. Black is exact, and near black the error is a share of the
  // opacity.
  Factors places = Factors::Ones();
  for (int i = 0; i + 1 < kFactors; ++i) {
    places[i] = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * i / (2 * kFactors - 3));
  }
  Eigen::Matrix<double, kFactors, kFactors> powers_there;
  for (int i = 0; i < kFactors; ++i) powers_there.row(i) = powers(places[i]);
  const Eigen::FullPivLU<Eigen::Matrix<double, kFactors, kFactors>> through(powers_there);
  OpacityPieces out{};
  out.white = static_cast<float>(-std::expm1(-extinction.tau(1) * step_mm));
  for (int piece = 0; piece < OpacityPieces::kPieces; ++piece) {
    const double octave = std::ldexp(1.0, piece - OpacityPieces::kPieces);
    const auto opacity = [&](double beyond) {
      return -std::expm1(-extinction.tau(1 - octave * (1 + beyond)) * step_mm);
    };
    const Factors factors = through.solve(places.unaryExpr(opacity).eval());
    for (int i = 0; i < kFactors; ++i) out.of[i][piece] = static_cast<float>(factors[i]);
    for (int i = 0; i + 1 < kFactors; ++i) {
      const double between = (places[i] + places[i + 1]) / 2;
      const double error = factors.dot(powers(between)) - opacity(between);
      if (!(std::abs(error) <= kMostError)) return std::nullopt;
    }
  }
  return out;
}

}  // namespace nav::render
