// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Of a lattice whose cells do not begin where t is counted from.

uniform float lattice_phase;  // The part of a cell in front of t = 0, [0, 1].

void move_lattice() {
  lattice_shift -= lattice_phase;
  lattice_origin -= lattice_phase * lattice_step;
}
