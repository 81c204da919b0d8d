// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Names of what a second volume has of its own, so that the blocks of one volume serve both. Until
// second_names_end.glsl.

#define between second_between
#define brick_count second_brick_count
#define brick_margin second_brick_margin
#define brick_of second_brick_of
#define bricks second_bricks
#define bricks_a_voxel second_bricks_a_voxel
#define bricks_per_voxel second_bricks_per_voxel
#define cell_mm second_cell_mm
#define cells_a_voxel second_cells_a_voxel
#define cells_of second_cells_of
#define clip_to_box second_clip_to_box
#define cost second_cost
#define ct second_ct
#define ct_hu second_ct_hu
#define ct_size second_ct_size
#define index_at second_index_at
#define index_from_local second_index_from_local
#define jitter_of second_jitter_of
#define kHuPerTexel kSecondHuPerTexel
#define kPlace kSecondPlace
#define last_brick second_last_brick
#define lattice_origin second_lattice_origin
#define lattice_phase second_lattice_phase
#define lattice_shift second_lattice_shift
#define lattice_step second_lattice_step
#define last_voxel second_last_voxel
#define leaves_box second_leaves_box
#define leaves_cube second_leaves_cube
#define march second_march
#define clear_to second_clear_to
#define move_lattice second_move_lattice
#define per_voxel second_per_voxel
#define picture_height second_picture_height
#define ray_direction second_ray_direction
#define rounding second_rounding
#define set_lattice second_set_lattice
#define step_mm second_step_mm
#define take_over_bricks second_take_over_bricks
#define take_over_volume second_take_over_volume
#define t_of second_t_of
#define trilinear second_trilinear
#define value_at second_value_at
#define voxels_a_brick second_voxels_a_brick
