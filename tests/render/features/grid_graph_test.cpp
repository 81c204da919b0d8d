// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "render/features/grid_graph.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "render/features/packed_graph.hpp"

namespace nav::render::features {
namespace {

constexpr std::array<int, 3> kSize{13, 6, 5};

/// Visits (i, j, k) of a grid.
template <class Visit>
void for_each_node(const std::array<int, 3>& size, const Visit& visit) {
  for (int k = 0; k < size[2]; ++k) {
    for (int j = 0; j < size[1]; ++j) {
      for (int i = 0; i < size[0]; ++i) visit(i, j, k);
    }
  }
}

/// Values with holes, and a separate penalty for every direction.
EdgeRule random_rule(unsigned seed) {
  const GraphLayout layout(kSize);
  EdgeRule rule{ZeroedArray<float>(layout.cells()), {}, {3.0F, 1e-5F}};
  std::fill(rule.values.begin(), rule.values.end(), NAN);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> value(0, 1);
  for_each_node(kSize, [&](int i, int j, int k) {
    if (value(random) > 0.1F) rule.values[layout.at(i, j, k)] = value(random);
  });
  for (float& p : rule.penalties) p = value(random);
  return rule;
}

GridGraph kept_as(const GridGraph& graph) {
  GridGraph kept(graph.size());
  for_each_node(graph.size(), [&](int i, int j, int k) {
    if (i != 0) return;
    for (int e = 0; e < kGraphEdges; ++e) graph.edges(e, j, k, &kept.kept(e)[graph.at(0, j, k)]);
  });
  return kept;
}

void expect_same_rows(const GridGraph& a, const GridGraph& b) {
  GridGraph::Scratch of_a, of_b;
  for_each_node(a.size(), [&](int i, int j, int k) {
    const GraphRow left = a.row(j, k, of_a);
    const GraphRow right = b.row(j, k, of_b);
    for (int e = 0; e < kGraphEdges; ++e) {
      EXPECT_EQ(left.after[e][i], right.after[e][i]) << e << " at " << i << " " << j << " " << k;
      EXPECT_EQ(left.before[e][i], right.before[e][i]) << e << " at " << i << " " << j << " " << k;
      EXPECT_EQ(left.offsets[e], right.offsets[e]);
      EXPECT_EQ(a.weight(e, a.at(i, j, k)), b.weight(e, b.at(i, j, k)));
    }
  });
}

TEST(GridGraphTest, HasTheEdgesOfItsRule) {
  const EdgeRule rule = random_rule(1);
  const GridGraph graph(kSize, rule);
  int edges = 0;
  for_each_node(kSize, [&](int i, int j, int k) {
    for (int e = 0; e < kGraphEdges; ++e) {
      const auto& s = kEdgeSteps[static_cast<std::size_t>(e)];
      const int x = i + s[0], y = j + s[1], z = k + s[2];
      const bool inside = x < kSize[0] && y >= 0 && y < kSize[1] && z >= 0 && z < kSize[2];
      const double a = static_cast<double>(rule.values[graph.at(i, j, k)]);
      const double b = inside ? static_cast<double>(rule.values[graph.at(x, y, z)]) : NAN;
      const double penalty = static_cast<double>(rule.penalties[static_cast<std::size_t>(e)]);
      const double weight = std::exp(-3 * (std::abs(a - b) + penalty)) + 1e-5;
      const double found = static_cast<double>(graph.weight(e, graph.at(i, j, k)));
      EXPECT_NEAR(found, std::isnan(weight) ? 0 : weight, 1e-6);
      edges += found > 0 ? 1 : 0;
    }
  });
  EXPECT_GT(edges, 1000);
}

TEST(GridGraphTest, ARuleEqualsStoredEdges) {
  GridGraph graph(kSize, random_rule(2));
  GridGraph kept = kept_as(graph);
  expect_same_rows(graph, kept);
  for (const auto& [i, j, k] : {std::array{0, 0, 0}, {12, 5, 4}, {6, 3, 2}, {7, 3, 2}}) {
    graph.isolate(graph.at(i, j, k));
    kept.isolate(kept.at(i, j, k));
    for (int e = 0; e < kGraphEdges; ++e) EXPECT_EQ(kept.weight(e, kept.at(i, j, k)), 0);
  }
  expect_same_rows(graph, kept);
}

// The quadratic form x · A x of values that are constant in each box equals that of the boxes.
TEST(PackedGraphTest, BoxesHaveTheQuadraticFormOfTheirNodes) {
  GridGraph exact(kSize, random_rule(3));
  exact.leak.writable(2, 3)[4] = 0.7F;
  exact.leak.writable(5, 4)[12] = 0.2F;
  const PackedGraph fine(exact, {});
  const auto form = [](const PackedGraph& graph, const auto& value) {
    std::vector<float> x(graph.cells());
    for_each_node(graph.size(),
                  [&](int i, int j, int k) { x[graph.at(i, j, k)] = value(i, j, k); });
    std::vector<float> ax(static_cast<std::size_t>(graph.row_length()));
    double sum = 0;
    for_each_node(graph.size(), [&](int i, int j, int k) {
      if (i != 0) return;
      sum += kernels()
                 .packed_laplacian(graph.row(j, k), &x[graph.at(0, j, k)], ax.data(),
                                   graph.row_length())
                 .rz;
    });
    return sum;
  };
  for (const std::array<int, 3> factor : {std::array{1, 2, 2}, {2, 1, 2}, {2, 2, 1}, {2, 1, 1}}) {
    const PackedGraph coarse = fine.coarse(factor, {});
    const auto of_box = [](int i, int j, int k) {
      return std::sin(1.7F * static_cast<float>(i) + 2.9F * static_cast<float>(j * j) +
                      0.6F * static_cast<float>(k));
    };
    const double boxes = form(coarse, of_box);
    const double nodes = form(fine, [&](int i, int j, int k) {
      return of_box(i / factor[0], j / factor[1], k / factor[2]);
    });
    EXPECT_NEAR(boxes, nodes, nodes / 256);
    EXPECT_GT(nodes, 1);
    double leaks = 0;
    for_each_node(coarse.size(), [&](int i, int j, int k) {
      leaks += static_cast<double>(coarse.leak().row(j, k)[i]);
    });
    EXPECT_NEAR(leaks, 0.9, 1e-6);
  }
}

TEST(FewRowsTest, AreZeroExceptWhereTheyWereWritten) {
  FewRows rows(GraphLayout({5, 4, 3}));
  EXPECT_EQ(rows.norm(), 0);
  rows.writable(3, 2)[4] = 3;
  rows.writable(0, 1)[0] = 4;
  rows.writable(3, 2)[4] += 0;
  EXPECT_EQ(rows.norm(), 5);
  for_each_node({5, 4, 3}, [&](int i, int j, int k) {
    const bool written = (j == 3 && k == 2) || (j == 0 && k == 1);
    EXPECT_EQ(rows.has(j, k), written);
    const float value = i == 4 && j == 3 && k == 2   ? 3.0F
                        : i == 0 && j == 0 && k == 1 ? 4.0F
                                                     : 0.0F;
    EXPECT_EQ(rows.row(j, k)[i], value);
  });
}

TEST(GraphKernelsTest, PenaltiesMeasureHowFarEdgesDeviateFromTheLine) {
  constexpr int kCount = 24;
  std::array<std::array<float, kCount>, 3> here{}, there{};
  std::mt19937 random(4);
  std::normal_distribution<double> component;
  for (std::size_t i = 0; i < kCount; ++i) {
    Eigen::Vector3d a(component(random), component(random), component(random));
    Eigen::Vector3d b = i % 2 == 0 ? a : a + Eigen::Vector3d(component(random), 0, 0);
    a.normalize();
    b.normalize();
    if (i == 5) b = -a;
    for (std::size_t c = 0; c < 3; ++c) {
      here[c][i] = static_cast<float>(a[static_cast<Eigen::Index>(c)]);
      there[c][i] = static_cast<float>(b[static_cast<Eigen::Index>(c)]);
    }
  }
  const float* from[3] = {here[0].data(), here[1].data(), here[2].data()};
  const float* to[3] = {there[0].data(), there[1].data(), there[2].data()};
  const Eigen::Vector3f edge(1, -2, 0);
  for (const Kernels* set : {&portable_kernels(), &kernels()}) {
    std::array<float, kCount> found{};
    set->edge_penalties(from, to, edge.data(), 0.3F, found.data(), kCount);
    for (std::size_t i = 0; i < kCount; ++i) {
      const Eigen::Vector3d both =
          Eigen::Vector3f(here[0][i] + there[0][i], here[1][i] + there[1][i],
                          here[2][i] + there[2][i])
              .cast<double>();
      const double aside = i == 5 ? 0 : 0.3 * edge.cast<double>().cross(both.normalized()).norm();
      EXPECT_NEAR(static_cast<double>(found[i]), aside, 1e-5) << set->name << " " << i;
    }
  }
}

TEST(GraphKernelsTest, AStepIsDampedScaledAndLimitedToFreeNodes) {
  constexpr int kCount = 16;
  std::array<float, kCount> x{}, step{}, pivot{}, b{};
  for (std::size_t i = 0; i < kCount; ++i) {
    x[i] = static_cast<float>(i);
    step[i] = 10;
    pivot[i] = i % 3 == 0 ? 0.0F : 0.5F;
    b[i] = i % 2 == 0 ? 1.0F : -2.0F;
  }
  for (const Kernels* set : {&portable_kernels(), &kernels()}) {
    std::array<float, kCount> out{};
    const Products sums = set->damped_step(x.data(), step.data(), pivot.data(), b.data(), 0.5F, 2,
                                           out.data(), kCount);
    double squares = 0, product = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
      const float truth = i % 3 == 0 ? 0.0F : 2 * (static_cast<float>(i) + 5);
      EXPECT_EQ(out[i], truth) << set->name;
      squares += static_cast<double>(truth * truth);
      product += static_cast<double>(truth * b[i]);
    }
    EXPECT_EQ(sums.zz, squares) << set->name;
    EXPECT_EQ(sums.rz, product) << set->name;
  }
}

}  // namespace
}  // namespace nav::render::features
