// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/verbs/bench_command_line.hpp"

int main(int argc, char** argv) { return nav::bench::run_command_line(argc, argv); }
