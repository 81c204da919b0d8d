#version 410 core
// SPDX-FileCopyrightText: 2026 The Sonde authors
// SPDX-License-Identifier: Apache-2.0
// Puts the finished picture over what VTK has drawn. Premultiplied colour in [0, 1], blended with
// (one, one minus source alpha). viewport_origin: pixels of the target.

uniform sampler2D picture;
uniform ivec2 viewport_origin;
layout(location = 0) out vec4 colour;

void main() { colour = texelFetch(picture, ivec2(gl_FragCoord.xy) - viewport_origin, 0); }
