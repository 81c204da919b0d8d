#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""The link check finds links that lead nowhere, and only those."""
import pathlib
import tempfile
import unittest

import check_links


class CheckLinksTest(unittest.TestCase):
    def problems(self, page: str, code: str = "") -> list[str]:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            (root / "docs").mkdir()
            (root / "docs/other.md").write_text("# One page\n\n## How fast, in `ms`\n")
            (root / "docs/page.md").write_text(page)
            (root / "a.hpp").write_text(code)
            return check_links.problems_in(root, code=True)

    def test_links_that_lead_somewhere_pass(self):
        self.assertEqual(self.problems("# A\n[a](other.md) [b](other.md#how-fast-in-ms) [c](#a) "
                                       "[d](https://example.org/x)\n"), [])

    def test_a_missing_file_is_found(self):
        self.assertEqual(self.problems("[a](gone.md)"), ["docs/page.md: no file gone.md"])
        self.assertEqual(len(self.problems("![image](images/gone.png)")), 1)

    def test_a_missing_heading_is_found(self):
        self.assertEqual(self.problems("[a](other.md#gone)"),
                         ["docs/page.md: no heading other.md#gone"])

    def test_a_link_in_code_is_text(self):
        self.assertEqual(self.problems("`[a](gone.md)`\n\n```\n[a](gone.md)\n```\n"), [])

    def test_a_page_that_code_names_must_exist(self):
        self.assertEqual(self.problems("", "// docs/other.md\n"), [])
        self.assertEqual(self.problems("", "// docs/gone.md\n"), ["a.hpp: no page docs/gone.md"])


if __name__ == "__main__":
    unittest.main()
