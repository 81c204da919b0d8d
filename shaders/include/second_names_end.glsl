// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// The end of second_names.glsl.

#undef between
#undef brick_count
#undef brick_margin
#undef brick_of
#undef bricks
#undef bricks_a_voxel
#undef bricks_per_voxel
#undef cell_mm
#undef cells_a_voxel
#undef cells_of
#undef clip_to_box
#undef cost
#undef ct
#undef ct_hu
#undef ct_size
#undef index_at
#undef index_from_local
#undef jitter_of
#undef kHuPerTexel
#undef kPlace
#undef last_brick
#undef lattice_origin
#undef lattice_phase
#undef lattice_shift
#undef lattice_step
#undef last_voxel
#undef leaves_box
#undef leaves_cube
#undef march
#undef march_cut
#undef clear_to
#undef move_lattice
#undef per_voxel
#undef picture_height
#undef ray_direction
#undef rounding
#undef set_lattice
#undef step_mm
#undef take_over_bricks
#undef take_over_volume
#undef t_of
#undef trilinear
#undef value_at
#undef voxels_a_brick
