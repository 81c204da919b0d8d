#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""The layer check finds what it is there to find."""
import pathlib
import tempfile
import unittest

import check_layers


class CheckLayersTest(unittest.TestCase):
    def problems(self, name: str, text: str) -> list[str]:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, name)
            path.parent.mkdir(parents=True)
            path.write_text(text)
            return check_layers.problems_in(pathlib.Path(folder))

    def test_a_sibling_is_refused(self):
        self.assertEqual(len(self.problems("tracking/a.cpp", '#include "io/ct.hpp"\n')), 1)

    def test_an_upward_include_is_refused(self):
        self.assertEqual(len(self.problems("nav/a.hpp", '#include "tracking/a.hpp"\n')), 1)

    def test_sim_may_see_io(self):
        self.assertEqual(self.problems("sim/a.cpp", '#include "io/sequence.hpp"\n'), [])

    def test_a_trade_type_in_a_public_header_is_refused(self):
        self.assertEqual(len(self.problems("io/ct.hpp", "#include <vtkImageData.h>\n")), 1)
        self.assertEqual(self.problems("io/ct.cpp", "#include <vtkImageData.h>\n"), [])

    def test_a_trade_outside_its_folder_is_refused(self):
        self.assertEqual(len(self.problems("nav/a.cpp", "#include <ceres/ceres.h>\n")), 1)

    def test_a_relative_include_is_refused(self):
        self.assertEqual(len(self.problems("nav/a.cpp", '#include "transform.hpp"\n')), 1)

    def test_a_constant_that_a_header_declares_is_refused_in_a_file(self):
        for where, count in (("nav/volume.hpp", 1), ("render/other.hpp", 0)):
            with self.subTest(where), tempfile.TemporaryDirectory() as folder:
                root = pathlib.Path(folder)
                for name, text in ((where, "inline constexpr std::int16_t kAirHu = -1024;\n"),
                                   ("io/a.cpp", "constexpr double kAirHu = -500;\n"
                                                "  constexpr double kAirHu = -500;\n")):
                    (root / name).parent.mkdir(parents=True, exist_ok=True)
                    (root / name).write_text(text)
                self.assertEqual(len(check_layers.shadowed_in(root)), count)

    def test_output_at_the_top_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name in ("README.md", "report.html"):
                (root / name).touch()
            self.assertEqual(len(check_layers.strays_in(root)), 1)


if __name__ == "__main__":
    unittest.main()
