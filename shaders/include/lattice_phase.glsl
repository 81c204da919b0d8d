// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Moves a lattice whose cells do not begin at the position from which t is counted.

uniform float lattice_phase;  // The part of a cell in front of t = 0, [0, 1].

void move_lattice() {
  lattice_shift -= lattice_phase;
  lattice_origin -= lattice_phase * lattice_step;
}
