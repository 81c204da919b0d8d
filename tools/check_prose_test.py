#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 The Sonde authors
# SPDX-License-Identifier: Apache-2.0
"""The prose check finds what it is there to find, and leaves identifiers and good texts alone."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

import check_prose


class CheckProseTest(unittest.TestCase):
    def problems(self, text: str, name: str = "nav/a.hpp") -> list[check_prose.Problem]:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder, name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
            return check_prose.problems_in(pathlib.Path(folder))

    def found(self, text: str, name: str = "nav/a.hpp") -> list[tuple[int, str]]:
        return [(p.line, p.kind) for p in self.problems(text, name)]

    def test_each_dangling_beginning_is_found(self):
        for word in ("Of", "What", "Whether", "Where", "As", "By", "The same"):
            with self.subTest(word):
                self.assertEqual(self.found(f"/// {word} a sweep.\nint a;\n"), [(1, "fragment")])
                self.assertEqual(self.found(f"int a;  ///< {word} a sweep.\n"), [(1, "fragment")])
                self.assertEqual(self.found(f"f();  // {word} a sweep.\n"), [(1, "fragment")])
                self.assertEqual(self.found(f"# {word} a sweep.\nset(A 1)\n", "CMakeLists.txt"),
                                 [(1, "fragment")])

    def test_only_the_first_line_of_a_block_is_a_beginning(self):
        self.assertEqual(self.found("// The centre of the sector,\n// As seen by the probe.\n"), [])
        self.assertEqual(self.found("int a;  ///< The centre\n        ///< Of the sector.\n"), [])
        self.assertEqual(self.found("int a;  ///< A centre.\nint b;  ///< Of a sector.\n"),
                         [(2, "fragment")])
        self.assertEqual(self.found("// A centre.\nf();\n// Of a sector.\n"), [(3, "fragment")])
        self.assertEqual(self.found("/* Of a\n * sector. */\n"), [(1, "fragment")])
        self.assertEqual(self.found("# SPDX-License-Identifier: A\n# Of a sector.\n", "a.sh"),
                         [(2, "fragment")])

    def test_a_whole_word_with_its_case_is_a_beginning(self):
        self.assertEqual(self.found("// Often cheaper.\n"), [])
        self.assertEqual(self.found("// of the sector\n"), [])
        self.assertEqual(self.found("// The sameness of two scenes.\n"), [])

    def test_each_retired_word_is_found(self):
        for text in ("a picture", "two Pictures", "for want of a pose", "looks at bricks",
                     "a look into the brick", "pixels without a ray", "a set-up",
                     "refuses the file", "refused it", "a refusal", "an ultrasound frame",
                     "in a look", "the look of bone",
                     "the looks of two scenes", "a look file", "the room", "rooms of a folder",
                     "a line of words", "the words below the view", "a place in the CT",
                     "the depth stretch", "a stretch above 1 %", "as the options say"):
            with self.subTest(text):
                self.assertEqual(self.found(f"// It has {text}.\n"), [(1, "word")])

    def test_legitimate_uses_are_left_alone(self):
        for text in ("a look at bone", "looks at the target", "a look-up", "in place of a file",
                     "takes the place of the pose", "the one place where files are listed",
                     "the same place where it was", "room for 16 bricks", "the operating room",
                     "in other words", "a stretch of the ray", "set up fairly",
                     "the pose frame", "tracker frames", "as the paper says"):
            with self.subTest(text):
                self.assertEqual(self.found(f"// It has {text}.\n"), [])

    def test_identifiers_are_left_alone(self):
        for text in ("picture = 1", "whole_picture", "kRefused", "`picture`", "picture()",
                     "refused({})", "--whole-image", "io/image_output.hpp", "picture.cpp",
                     "\\p picture", "picture::Kind"):
            with self.subTest(text):
                self.assertEqual(self.found(f"// It has {text}\n"), [])
        self.assertEqual(self.found("Picture picture = refuse(pictures);\n"), [])

    def test_the_verdict_about_a_registration_is_left_alone(self):
        text = "// A refused pose is not drawn.\n"
        self.assertEqual(self.found(text, "registration/a.hpp"), [])
        self.assertEqual(self.found(text, "tests/app/a.cpp"), [])
        self.assertEqual(self.found("The limits refuse a refused pose.\n", "docs/a.md"), [])
        self.assertEqual(self.found(text, "io/a.hpp"), [(1, "word")])
        self.assertEqual(self.found("// Refuses NaN.\n", "registration/a.hpp"), [(1, "word")])

    def test_names_of_types_tests_and_files_are_checked(self):
        for text in ("struct PictureTimes {\n", "class PictureSource final {\n",
                     "TEST(FileTest, RefusesDamage) {\n", "TEST_F(PictureTest, Works) {\n",
                     "struct TrackedFrame {\n"):
            with self.subTest(text):
                self.assertEqual(self.found(text), [(1, "name")])
        self.assertEqual(self.found("int a;\n", "io/picture_watch.cpp"), [(1, "name")])
        self.assertEqual(self.found("TEST(FileTest, ARefusedRegistrationIsNeverTaken) {\n"), [])
        self.assertEqual(self.found("struct CanFrame {\n"), [])

    def test_a_phrase_may_cross_lines(self):
        self.assertEqual(self.found("// Identity for want\n// of a pose.\n"), [(1, "word")])
        self.assertEqual(self.found('f("identity for "\n  "want of a pose");\n'), [(1, "word")])
        self.assertEqual(self.found('f("a "\n  "new picture");\n'), [(2, "word")])

    def test_strings_for_people_are_checked(self):
        self.assertEqual(self.found('f("expected a picture");\n'), [(1, "word")])
        self.assertEqual(self.found('f(" pictures");\n'), [(1, "word")])
        self.assertEqual(self.found('f(R"(expected a picture)");\n'), [(1, "word")])
        self.assertEqual(self.found('print("expected a picture")\n', "tools/a.py"), [(1, "word")])
        self.assertEqual(self.found('echo "expected a picture"\n', "tools/a.sh"), [(1, "word")])
        self.assertEqual(self.found("f\"{a['picture']} of b\"\n", "tools/a.py"), [])

    def test_strings_for_programs_are_not_checked(self):
        for text in ('f("picture");\n', 'f("io/image_output.hpp");\n', 'f("a_picture");\n',
                     'f("vec4 picture = front;\\n");\n', 'f(R"(\nvec4 picture;\n)");\n'):
            with self.subTest(text):
                self.assertEqual(self.found(text), [])

    def test_a_mark_of_a_comment_in_a_string_begins_none(self):
        self.assertEqual(self.found('f("http://Of.example/# Of");\nint a = 1\'000\'000;\n'), [])
        self.assertEqual(self.found('echo "a # Of b" ${a#Of} # Of it\n', "a.sh"), [(1, "fragment")])

    def test_python_docstrings_are_comments(self):
        self.assertEqual(self.found('"""Of a page.\n\nA picture."""\n', "tools/a.py"),
                         [(1, "fragment"), (3, "word")])

    def test_pages_are_checked_apart_from_code_and_links(self):
        self.assertEqual(self.found("# A page\n\nA picture.\n", "docs/a.md"), [(3, "word")])
        self.assertEqual(self.found("A picture.\n", "README.md"), [(1, "word")])
        self.assertEqual(self.found("`picture` ``a picture`` [a](picture.png)\n", "docs/a.md"), [])
        self.assertEqual(self.found("Of pages.\n", "docs/a.md"), [])

    def test_excluded_files_are_not_checked(self):
        for name in ("CHANGELOG.md", "docs/STYLE.md", "build/a.md", ".git/a.md",
                     "nav/a.txt"):
            with self.subTest(name):
                self.assertEqual(self.found("A picture.\n", name), [])

    def helps(self, text: str) -> list[str]:
        return [str(p) for p in self.problems("void f() {\n" + text + "\n}\n", "app/a.cpp")
                if p.kind == "help"]

    def test_help_texts_begin_with_a_noun_or_a_verb(self):
        for word in ("how", "what", "whether", "where", "of", "as", "By", "that", "which",
                     "the same"):
            with self.subTest(word):
                found = self.helps(f'verb.add_option("--a", a,\n  "{word} it is drawn");')
                self.assertEqual(len(found), 1)
                self.assertTrue(found[0].startswith("app/a.cpp:3: "), found)
        self.assertEqual(self.helps('verb.add_option("--a", a, "offset of the image, mm");'), [])

    def test_help_texts_need_no_other_sentence(self):
        for text in ("write it here too", "landmarks alone; none: all", "several, or so.",
                     "radius; none: as drawn"):
            with self.subTest(text):
                self.assertEqual(len(self.helps(f'verb->add_flag("--a", a, "{text}");')), 1)
        self.assertEqual(self.helps('verb.add_flag("--a", "too many voxels also count");'), [])

    def test_help_texts_are_found_in_every_kind_of_call(self):
        for call in ('verb.add_option_function<int>("--a", [&] { f("x", {1, 2}); }, "of it")',
                     'verb.add_flag_callback("--a", [&] { a = 1; }, "of it")',
                     'add_choice(verb, "--a", a, {{"b", B::kB}}, "of it")',
                     'add("--a", a, "of it")', 'app.add_subcommand("a", "of it")',
                     'verb.add_option("--a", a, "of " + it)',
                     'verb.add_option("a", a, "of "\n"it")'):
            with self.subTest(call):
                self.assertEqual(len(self.helps(call + "->required();")), 1)
        self.assertEqual(self.helps('add("a", "of it");'), [])

    def test_texts_of_option_rows_begin_with_a_noun_or_a_verb(self):
        row = '{.name = "--a",\n .type = "MM",\n .text =\n "%s",\n .group = g},'
        for text in ("how well the points were " "touched", "how uneven the pace is",
                     "what is drawn", "of the images", "draw the table, too"):
            with self.subTest(text):
                found = self.problems(row % text)
                self.assertEqual([(p.line, p.kind) for p in found], [(4, "help")])
                self.assertIn("--a", found[0].text)
        for text in ("standard deviation along each axis", "draw how the needle bends"):
            self.assertEqual(self.found(row % text), [])
        self.assertEqual(len(self.problems('{.text = "how well it "\n "is known"}')), 1)
        self.assertEqual(self.found("row.text = text;\n"), [])

    def test_a_missing_help_text_is_found(self):
        self.assertEqual(len(self.helps('verb.add_option("--a", a)->required();')), 1)
        self.assertEqual(self.helps('verb.add_option("--a", a)->description(text);'), [])
        self.assertEqual(self.helps('verb.add_option("--a", a, text);'), [])

    def test_the_count_is_by_folder_and_kind(self):
        found = self.problems("// Of a picture.\n")
        self.assertEqual([line.split() for line in check_prose.count_table(found).split("\n")],
                         [["folder", "fragment", "word", "help", "name", "all"],
                          ["nav", "1", "1", "0", "0", "2"], ["total", "1", "1", "0", "0", "2"]])

    def test_the_exit_status_says_whether_something_was_found(self):
        tool = check_prose.__file__
        with tempfile.TemporaryDirectory() as folder:
            run = lambda *more: subprocess.run([sys.executable, tool, folder, *more],
                                               capture_output=True, text=True, check=False)
            self.assertEqual(run().returncode, 0)
            pathlib.Path(folder, "README.md").write_text("A picture.\n")
            self.assertEqual(run().returncode, 1)
            self.assertEqual(run().stdout.split("\n")[0],
                             'README.md:1: found "picture"; write image')
            self.assertEqual(run("--count").returncode, 0)


if __name__ == "__main__":
    unittest.main()
