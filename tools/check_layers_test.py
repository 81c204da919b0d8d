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

    def test_the_product_may_not_see_bench(self):
        for folder, count in (("app", 1), ("session", 1), ("bench", 0)):
            with self.subTest(folder):
                name = f"{folder}/a.cpp"
                self.assertEqual(len(self.problems(name, '#include "bench/a.hpp"\n')), count)

    def test_bench_may_see_app_but_its_window(self):
        self.assertEqual(self.problems("bench/a.cpp", '#include "app/report.hpp"\n'), [])
        self.assertEqual(len(self.problems("bench/a.cpp", '#include "app/window/w.hpp"\n')), 1)

    def test_nothing_but_the_window_may_see_its_toolkit(self):
        for name, count in (("app/verbs/a.cpp", 1), ("render/a.cpp", 1), ("app/window/a.cpp", 0),
                            ("tests/window/a.cpp", 0)):
            with self.subTest(name):
                self.assertEqual(len(self.problems(name, "#include <QWidget>\n")), count)
        self.assertEqual(len(self.problems("app/verbs/a.cpp", '#include "app/window/w.hpp"\n')), 1)

    def test_the_overview_counts_includes_and_lines_of_code(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name, text in (("sim/a.cpp", '#include "nav/b.hpp"\n#include "nav/c.hpp"\n'
                                             '#include "sim/a.hpp"\n#include "io/ct.hpp"\n'
                                             '#include <vector>\n'),
                               ("nav/b.hpp", "// A comment.\n\nint b;  // Another.\n"),
                               ("shaders/a.frag", "void main() {\n}\n"),
                               ("nav/CMakeLists.txt", "project(a)\n")):
                (root / name).parent.mkdir(parents=True, exist_ok=True)
                (root / name).write_text(text)
            overview = [line.split() for line in check_layers.overview_of(root)]
        self.assertIn(["sim", "->", "io", "(1),", "nav", "(2)"], overview)
        self.assertIn(["nav", "->", "nothing"], overview)
        self.assertIn(["sim", "1", "5"], overview)
        self.assertIn(["nav", "1", "1"], overview)
        self.assertIn(["shaders", "1", "2"], overview)
        self.assertIn(["all", "3", "8"], overview)

    def test_output_at_the_top_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            for name in ("README.md", "report.html"):
                (root / name).touch()
            self.assertEqual(len(check_layers.strays_in(root)), 1)


if __name__ == "__main__":
    unittest.main()
