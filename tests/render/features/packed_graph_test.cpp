// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/packed_graph.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "render/features/multigrid.hpp"

namespace nav::render::features {
namespace {

/// Weights of 1e-5 to 1 between the nodes of a grid, as in a random walk. Every node has a leak.
GridGraph random_graph(const std::array<int, 3>& size, unsigned seed) {
  GridGraph graph(size);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> exponent(-5, 0);
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) {
        const std::size_t node = graph.at(i, j, k);
        graph.leak.writable(j, k)[i] = std::pow(10.0F, exponent(random));
        for (std::size_t e = 0; e < kEdgeSteps.size(); ++e) {
          const auto& s = kEdgeSteps[e];
          const int x = i + s[0], y = j + s[1], z = k + s[2];
          if (x >= size[0] || y < 0 || y >= size[1] || z < 0 || z >= size[2]) continue;
          graph.kept(static_cast<int>(e))[node] = std::pow(10.0F, exponent(random));
        }
      }
    }
  }
  return graph;
}

TEST(PackedWeightTest, IsTheNearestValueOfSixteenBits) {
  for (const float exact : {0.0F, 1.0F, 0.5F, 1.0F + 1.0F / 128, 18.0F}) {
    EXPECT_EQ(unpacked_weight(packed_weight(exact)), exact);
  }
  EXPECT_EQ(unpacked_weight(packed_weight(1.0F + 1.0F / 256)), 1.0F) << "halves to even";
  EXPECT_EQ(unpacked_weight(packed_weight(1.0F + 3.0F / 256)), 1.0F + 4.0F / 256);
  std::mt19937 random(1);
  std::uniform_real_distribution<float> exponent(-30, 3);
  for (int n = 0; n < 10000; ++n) {
    const float weight = std::pow(10.0F, exponent(random));
    EXPECT_LE(std::abs(unpacked_weight(packed_weight(weight)) - weight), weight / 256) << weight;
  }
}

TEST(PackedGraphTest, BothKernelsApplyTheMatrixOfTheWeights) {
  const std::array<int, 3> size{13, 5, 4};
  const GridGraph graph = random_graph(size, 3);
  GridGraph rounded = graph;
  for (int e = 0; e < kGraphEdges; ++e) {
    for (float& w : rounded.kept(e)) w = unpacked_weight(packed_weight(w));
  }
  const PackedGraph packed(graph, {});
  GridGraph::Scratch scratch;
  std::vector<float> x(graph.cells());
  std::mt19937 random(4);
  std::uniform_real_distribution<float> value(-1, 1);
  for (float& v : x) v = value(random);
  const std::vector<double> x_double(x.begin(), x.end());
  for (const Kernels* set : {&portable_kernels(), &kernels()}) {
    for (int k = 0; k < size[2]; ++k) {
      for (int j = 0; j < size[1]; ++j) {
        std::vector<float> found(static_cast<std::size_t>(graph.row_length()));
        std::vector<double> truth(found.size());
        set->packed_laplacian(packed.row(j, k), &x[packed.at(0, j, k)], found.data(),
                              packed.row_length());
        set->laplacian(rounded.row(j, k, scratch), &x_double[graph.at(0, j, k)], truth.data(),
                       graph.row_length());
        for (std::size_t i = 0; i < 13; ++i) {
          EXPECT_NEAR(static_cast<double>(found[i]), truth[i], 5e-6) << set->name;
        }
      }
    }
  }
}

TEST(MultigridTest, IsSymmetricPositiveAndReportsItsProducts) {
  for (const std::array<int, 3> size :
       {std::array{21, 18, 17}, {40, 9, 20}, {11, 12, 40}, {3, 4, 5}, {40, 40, 30}}) {
    Multigrid multigrid(random_graph(size, 5), {});
    std::mt19937 random(6);
    std::normal_distribution<float> value;
    ZeroedArray<float> r[2], z[2], scratch(multigrid.fine().cells());
    Products products[2];
    for (int n = 0; n < 2; ++n) {
      r[n] = ZeroedArray<float>(multigrid.fine().cells());
      z[n] = ZeroedArray<float>(r[n].size());
      for (int k = 0; k < size[2]; ++k) {
        for (int j = 0; j < size[1]; ++j) {
          for (int i = 0; i < size[0]; ++i) r[n][multigrid.fine().at(i, j, k)] = value(random);
        }
      }
      const ZeroedArray<float> before = r[n];
      products[n] = multigrid.apply(r[n], z[n], scratch);
      EXPECT_TRUE(std::ranges::equal(r[n], before));
    }
    const auto dot = [](const ZeroedArray<float>& a, const ZeroedArray<float>& b) {
      double sum = 0;
      for (std::size_t i = 0; i < a.size(); ++i) {
        sum += static_cast<double>(a[i]) * static_cast<double>(b[i]);
      }
      return sum;
    };
    EXPECT_GT(products[0].rz, 0);
    EXPECT_NEAR(products[0].rz, dot(r[0], z[0]), 1e-9 * products[0].rz);
    EXPECT_NEAR(products[0].zz, dot(z[0], z[0]), 1e-9 * products[0].zz);
    const double size_of_both = std::sqrt(products[0].rz * products[1].rz);
    EXPECT_NEAR(dot(r[0], z[1]), dot(r[1], z[0]), 1e-4 * size_of_both);
  }
}

}  // namespace
}  // namespace nav::render::features
