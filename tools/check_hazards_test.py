#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""The check of hazards finds missing rows and tests, and only those."""
import pathlib
import tempfile
import unittest

import check_hazards


class CheckHazardsTest(unittest.TestCase):
    def problems(self, rows: list[str]) -> list[str]:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "docs").mkdir()
            (root / "tests").mkdir()
            (root / "tests/a_test.cpp").write_text("TEST_F(ATest, Holds) {}\n")
            (root / "docs/hazards.md").write_text("\n".join(rows))
            return check_hazards.problems_in(root)

    @staticmethod
    def row(hazard: str, tests: str = "`ATest.Holds`") -> str:
        return f"| {hazard} | it breaks | it is watched | {tests} |"

    def test_a_complete_table_passes(self):
        self.assertEqual(self.problems([self.row(h) for h in check_hazards.HAZARDS]), [])

    def test_a_missing_row_is_found(self):
        rows = [self.row(h) for h in check_hazards.HAZARDS if h != "H7"]
        self.assertEqual(self.problems(rows), ["docs/hazards.md: H7: expected a row, found none"])

    def test_a_test_that_does_not_exist_is_found(self):
        rows = [self.row(h) for h in check_hazards.HAZARDS if h != "H7"]
        self.assertEqual(self.problems(rows + [self.row("H7", "`ATest.Fails`")]),
                         ["docs/hazards.md: H7: no test ATest.Fails"])
        self.assertEqual(self.problems(rows + [self.row("H7", "none")]),
                         ["docs/hazards.md: H7: expected a test, found none"])


if __name__ == "__main__":
    unittest.main()
