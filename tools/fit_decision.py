#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""Fits the probability that a registration is off by more than 3 mm to trials of the benchmark.

Usage: tools/fit_decision.py FIT.csv... [--check CHECK.csv...]

FIT and CHECK are files of `sonde bench registration --part levels --trials FILE`. The weights of
registration/error_probability.cpp come from this program; the second set of files, made with other
seeds and another acoustic model, shows whether the probabilities hold there.
"""

import argparse
import csv
import math
import sys

LIMIT_MM = 3.0
NAMES = ["constant", "cost", "margin", "predicted", "odd_even", "halves", "basin", "score"]
PENALTY = 0.02


def clamp(value, low, high):
    return min(max(value, low), high)


def log2_of(text):
    value = float(text)
    return math.log2(clamp(value, 0.05, 16.0)) if math.isfinite(value) else math.log2(16.0)


def features(row):
    """Returns the features of a row, as features_of() in registration/error_probability.cpp does."""
    # Without another minimum a score of 7 stopped the search, or none was asked for.
    margin = 1.0 if float(row["z_score"]) >= 7 else 0.3
    if row["margin"]:
        margin = float(row["margin"])
    return [
        1.0,
        10 * (float(row["cost"]) - 0.3),
        1 - clamp(margin, 0.0, 0.6) / 0.6,
        log2_of(row["predicted_mm"]),
        log2_of(row["split_mm"]),
        log2_of(row["halves_mm"]),
        clamp(float(row["basin_mm"]), 0.0, 4.0),
        1 - clamp(float(row["z_score"]), 0.0, 8.0) / 8,
    ]


def read(paths):
    """Features, whether the result is wrong, and the rows of all results that have a covariance."""
    out = []
    for path in paths:
        with open(path, newline="", encoding="utf-8") as file:
            for row in csv.DictReader(file):
                if row["solved"] != "1" or not math.isfinite(float(row["predicted_mm"])):
                    continue
                right = row["acceptable"] == "1" and float(row["error_mm"]) <= LIMIT_MM
                out.append((features(row), not right, row))
    return out


def solve(matrix, vector):
    """Solves a small linear system by elimination with pivots."""
    n = len(vector)
    a = [row[:] + [vector[i]] for i, row in enumerate(matrix)]
    for i in range(n):
        pivot = max(range(i, n), key=lambda k: abs(a[k][i]))
        a[i], a[pivot] = a[pivot], a[i]
        for k in range(i + 1, n):
            factor = a[k][i] / a[i][i]
            for j in range(i, n + 1):
                a[k][j] -= factor * a[i][j]
    x = [0.0] * n
    for i in reversed(range(n)):
        x[i] = (a[i][n] - sum(a[i][j] * x[j] for j in range(i + 1, n))) / a[i][i]
    return x


def probability(weights, x):
    return 1 / (1 + math.exp(-clamp(sum(w * v for w, v in zip(weights, x)), -30, 30)))


def fit(data):
    """Logistic regression with a ridge, by Newton's method; no weight but the constant is negative.

    More cost, less margin and so on never speak for a result.
    """
    n = len(NAMES)
    used = list(range(n))
    while True:
        weights = [0.0] * n
        for _ in range(60):
            gradient = [0.0] * n
            hessian = [[0.0] * n for _ in range(n)]
            for x, wrong, _row in data:
                p = probability(weights, x)
                for i in used:
                    gradient[i] += (p - wrong) * x[i]
                    for j in used:
                        hessian[i][j] += p * (1 - p) * x[i] * x[j]
            for i in used[1:]:
                gradient[i] += PENALTY * len(data) / 100 * weights[i]
                hessian[i][i] += PENALTY * len(data) / 100
            small = [[hessian[i][j] + (1e-9 if i == j else 0) for j in used] for i in used]
            step = solve(small, [gradient[i] for i in used])
            largest = max(abs(s) for s in step)
            for i, s in zip(used, step):
                weights[i] -= s * min(1.0, 5.0 / largest) if largest > 0 else 0
            if largest < 1e-8:
                break
        negative = [i for i in used[1:] if weights[i] < 0]
        if not negative:
            return weights
        used.remove(min(negative, key=lambda i: weights[i]))


def wilson(k, n):
    if n == 0:
        return (0.0, 1.0)
    z, p = 1.96, k / n
    middle = (p + z * z / (2 * n)) / (1 + z * z / n)
    half = z * math.sqrt(p * (1 - p) / n + z * z / (4 * n * n)) / (1 + z * z / n)
    return (max(middle - half, 0.0), min(middle + half, 1.0))


def show(title, data, weights):
    print(f"{title}: {len(data)} results with a covariance, {sum(w for _, w, _ in data)} of them wrong")
    edges = [0, 0.01, 0.05, 0.2, 0.5, 1.0001]
    for low, high in zip(edges, edges[1:]):
        inside = [w for x, w, _ in data if low <= probability(weights, x) < high]
        if inside:
            k = sum(inside)
            a, b = wilson(k, len(inside))
            print(f"  told {low:.2f} to {min(high, 1):.2f}: {k} of {len(inside)} wrong [{a:.3f}, {b:.3f}]")
    for limit in (0.01, 0.02, 0.05, 0.1, 0.2):
        taken = [w for x, w, _ in data if probability(weights, x) <= limit]
        right = sum(1 for _, w, _ in data if not w)
        print(
            f"  limit {limit:.2f}: {len(taken) - sum(taken)} of {right} right ones, {sum(taken)} wrong ones"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("fit", nargs="+", help="trials to fit")
    parser.add_argument("--check", nargs="*", default=[], help="trials to check")
    options = parser.parse_args()
    data = read(options.fit)
    if not any(w for _, w, _ in data) or all(w for _, w, _ in data):
        sys.exit("expected right and wrong results in the trials to fit, found one kind")
    weights = fit(data)
    for name, weight in zip(NAMES, weights):
        print(f"{name} {weight:.3f}")
    show("fitted", data, weights)
    if options.check:
        show("checked", read(options.check), weights)


if __name__ == "__main__":
    main()
