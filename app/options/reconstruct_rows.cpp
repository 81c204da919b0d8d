// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Options of reconstruct.
#include "app/options/option_rows.hpp"

namespace nav::app {

void add_reconstruct_rows(std::vector<Option>& rows) {
  const std::vector<std::string_view> here{"reconstruct"};
  const std::vector<Option> options{
      {.name = "--method",
       .type = "NAME",
       .text = "way from pixels to voxels",
       .group = group::kGroupReconstruction,
       .verbs = here,
       .slot = NAV_SLOT(reconstruct.method),
       .choices = {"nearest", "trilinear", "gaussian", "backward"},
       .usual = true},
      {.name = "--compound",
       .type = "NAME",
       .text = "value of a voxel that several pixels or images reach",
       .group = group::kGroupReconstruction,
       .verbs = here,
       .slot = NAV_SLOT(reconstruct.compound),
       .choices = {"mean", "median", "max", "latest"},
       .usual = true},
      {.name = "--weights",
       .type = "NAME",
       .text = "weights of pixels in the mean: confidence lets shadows and the far ends of scan "
               "lines count less",
       .group = group::kGroupReconstruction,
       .verbs = here,
       .slot = NAV_SLOT(reconstruct.weights),
       .choices = {"none", "confidence"}},
      {.name = "--spacing-mm",
       .type = "MM",
       .unit = "mm",
       .text = "side of the voxels",
       .group = group::kGroupReconstruction,
       .verbs = here,
       .slot = NAV_SLOT(reconstruct.spacing_mm),
       .range = within(1e-4, 1000),
       .absent = "that of the configuration, otherwise 0.5",
       .usual = true},
      {.name = "--fill",
       .type = "N",
       .unit = "voxels",
       .text = "fill holes up to this long between seen voxels, and mark them; 0: none",
       .group = group::kGroupReconstruction,
       .verbs = here,
       .slot = NAV_SLOT(reconstruct.fill),
       .range = within(0, 100),
       .usual = true},
      {.name = "--clip",
       .type = "X",
       .unit = "pixels",
       .text = "column, row, width and height of the part of the images that is used, as PLUS's "
               "ClipRectangle",
       .group = group::kGroupReconstruction,
       .verbs = here,
       .slot = NAV_SLOT(reconstruct.clip_px),
       .range = within(0, 1e6),
       .absent = "that of the configuration, otherwise all"},
      {.name = "--fan",
       .type = "X",
       .text =
           "fan that is used: two angles in degrees, column and row of its origin, and two radii "
           "in pixels, as PLUS's Fan",
       .group = group::kGroupReconstruction,
       .verbs = here,
       .slot = NAV_SLOT(reconstruct.fan),
       .unbounded =
           "angles within 90 degrees of straight down, in order; radii of 0 or more, in order",
       .absent = "that of the configuration, otherwise the sector that the images show"},
      {.name = "--gaussian-voxels",
       .type = "X",
       .unit = "voxels",
       .text = "standard deviation of the Gaussian",
       .group = group::kGroupReconstruction,
       .verbs = here,
       .slot = NAV_SLOT(reconstruct.gaussian_voxels),
       .range = within(0.3, 2),
       .needs = {{.any_of = {{"--method", {"gaussian"}}}}}},
      {.name = "--reach-mm",
       .type = "MM",
       .unit = "mm",
       .text = "greatest distance of a voxel from an image that it takes values of",
       .group = group::kGroupReconstruction,
       .verbs = here,
       .slot = NAV_SLOT(reconstruct.reach_mm),
       .range = above(0, 100),
       .absent = "the side of the voxels",
       .needs = {{.any_of = {{"--method", {"backward"}}}}}},
      {.name = "--threads",
       .type = "N",
       .text = "threads of the reconstruction; 0: all cores",
       .group = group::kGroupReconstruction,
       .verbs = here,
       .slot = NAV_SLOT(reconstruct.threads),
       .range = within(0, 1024)}};
  rows.insert(rows.end(), options.begin(), options.end());
}

}  // namespace nav::app
