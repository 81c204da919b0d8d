// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
#include "app/options/command_line.hpp"

int main(int argc, char** argv) { return nav::app::run_command_line(argc, argv); }
