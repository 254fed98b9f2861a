"""Each lint finds what was planted for it, and nothing in a clean tree.

    python3 tests/lint/lint_test.py
"""

import json
import pathlib
import shutil
import tempfile
import unittest

import check_catalogue
import check_docs
import check_format
import check_layers
import check_readme
import check_style
import check_techniques

LIBRARY = "penumbra_library({name} SOURCES {source} LINKS {links})\n"
MATH_H = "// A box.\n#pragma once\n\n#include <glm/glm.hpp>\n"
CLEAN = {
    "render/math/CMakeLists.txt": LIBRARY.format(name="penumbra_math", source="box.cc", links=""),
    "render/math/box.h": MATH_H,
    "render/math/box.cc": '#include "render/math/box.h"\n',
    "render/scene/CMakeLists.txt": LIBRARY.format(name="penumbra_scene", source="scene.cc",
                                                  links="penumbra_math"),
    "render/scene/scene.cc": '#include <vector>\n\n#include "render/math/box.h"\n',
}


class TreeTest(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="penumbra-lint-"))
        self.addCleanup(shutil.rmtree, self.root)
        for path, text in CLEAN.items():
            self.write(path, text)

    def write(self, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)

    def add(self, path, text):
        self.write(path, (self.root / path).read_text() + text)

    def assert_finds(self, found, fragment):
        self.assertEqual([v for v in found if fragment in v] and len(found), 1, found)


class LayersTest(TreeTest):
    def found(self):
        return check_layers.check(self.root)

    def test_clean_tree(self):
        self.assertEqual(self.found(), [])

    def test_include_against_the_direction(self):
        self.write("render/scene/scene.h", "// A scene.\n#pragma once\n")
        self.add("render/math/box.h", '#include "render/scene/scene.h"\n')
        self.assertIn("render/math/box.h: render/math must not include render/scene/scene.h",
                      self.found())

    def test_protobuf_in_render(self):
        self.add("render/scene/scene.cc", '#include "penumbra/v1/scene.pb.h"\n')
        self.assert_finds(self.found(), "must not include penumbra/v1/scene.pb.h (protobuf)")

    def test_gl_outside_of_its_room(self):
        self.write("client/display/CMakeLists.txt", "penumbra_library(d SOURCES d.cc)\n")
        self.write("client/display/d.cc", "#include <epoxy/gl.h>\n")
        self.assertIn("client/display/d.cc: epoxy headers are for render/gl/gl.h alone",
                      self.found())

    def test_client_knows_specs_but_no_technique(self):
        self.write("client/cli/CMakeLists.txt", "penumbra_library(c SOURCES c.cc)\n")
        self.write("client/cli/c.cc", '#include "render/technique/artifact_spec.h"\n'
                                      '#include "render/technique/technique.h"\n'
                                      '#include "server/limits.h"\n')
        found = self.found()
        self.assertEqual(len(found), 2, found)
        self.assertIn("client/cli must not include render/technique/technique.h", found[0])
        self.assertIn("client/cli must not include server/limits.h", found[1])

    def test_unknown_dependency(self):
        self.add("render/scene/scene.cc", "#include <boost/any.hpp>\n")
        self.assert_finds(self.found(), "boost/any.hpp is in no group")

    def test_headers_that_must_not_meet(self):
        self.write("client/display/CMakeLists.txt", "penumbra_library(d SOURCES d.cc)\n")
        self.write("client/display/picture.h",
                   "// P.\n#pragma once\n#include <OpenImageIO/imageio.h>\n")
        self.write("client/display/d.cc", '#include "client/display/picture.h"\n'
                                          '#include "penumbra/v1/scene.pb.h"\n')
        self.assertIn("client/display/d.cc: oiio and protobuf headers in one translation unit",
                      self.found())

    def test_impure_render(self):
        for line in ("#include <fstream>\n", 'const char* p = getenv("HOME");\n',
                     "auto t = steady_clock::now();\n"):
            with self.subTest(line):
                self.write("render/scene/scene.cc", CLEAN["render/scene/scene.cc"] + line)
                self.assert_finds(self.found(), "render/ knows no files")

    def test_words_in_comments_do_not_count(self):
        self.add("render/scene/scene.cc", "// Unlike getenv().\n")
        self.assertEqual(self.found(), [])

    def test_source_in_no_target(self):
        self.write("render/math/lost.cc", "")
        self.assert_finds(self.found(), "render/math/lost.cc: in no target's SOURCES")

    def test_link_against_the_direction(self):
        self.write("render/math/CMakeLists.txt",
                   LIBRARY.format(name="penumbra_math", source="box.cc", links="penumbra_scene"))
        self.assert_finds(self.found(), "penumbra_math must not link penumbra_scene")

    def test_include_without_link(self):
        self.write("render/scene/CMakeLists.txt",
                   LIBRARY.format(name="penumbra_scene", source="scene.cc", links=""))
        self.assert_finds(self.found(), "penumbra_scene does not link penumbra_math")


class StyleTest(TreeTest):
    def found(self, long_on_purpose=()):
        return check_style.check(self.root, dict.fromkeys(long_on_purpose, "reason"))

    def test_clean_tree(self):
        self.assertEqual(self.found(), [])

    def test_long_files(self):
        self.add("render/math/box.h", "\n" * 150)
        self.add("render/math/box.cc", "\n" * 300)
        self.assertEqual(self.found(), ["render/math/box.cc: 301 lines, at most 300",
                                        "render/math/box.h: 154 lines, at most 150"])
        self.assertEqual(self.found(["render/math/box.cc", "render/math/box.h"]), [])

    def test_long_function(self):
        body = "  ++n;\n" * 39
        self.add("render/math/box.cc", "int Count(int n) {\n" + body + "}\n")
        self.assert_finds(self.found(), "Count has 41 lines, at most 40")
        self.assertEqual(self.found(["render/math/box.cc:Count"]), [])

    def test_long_line(self):
        self.add("render/math/box.cc", "// " + "é" * 97 + "\n// " + "é" * 98 + "\n")
        self.assert_finds(self.found(), "render/math/box.cc:3: 101 columns, at most 100")

    def test_excuse_that_excuses_nothing(self):
        self.assert_finds(self.found(["render/math/box.cc"]), "is not too long")

    def test_unfinished(self):
        self.add("render/math/box.cc", "// TO" "DO: the rest\n")
        self.assert_finds(self.found(), "render/math/box.cc:2: TO" "DO")

    def test_header_that_does_not_say_what_it_is_for(self):
        self.write("render/math/box.h", "#pragma once\n")
        self.assert_finds(self.found(), "a header opens by saying what it is for")


class FormatTest(TreeTest):
    def setUp(self):
        super().setUp()
        self.write(".clang-format", "BasedOnStyle: Google\nColumnLimit: 100\n")

    def test_clean_tree(self):
        self.assertEqual(check_format.check(self.root), [])

    def test_bad_format(self):
        self.add("render/math/box.cc", "int  x ;\n")
        self.assert_finds(check_format.check(self.root),
                          "render/math/box.cc:2: not as clang-format writes it")


class DocsTest(TreeTest):
    PAGE = "## Of a scene\n\n| `max_lights` | {lights} |\n\n## Of a server\n\n{server}\n"

    def setUp(self):
        super().setUp()
        self.write("render/scene/scene_limits.h", "  uint64_t max_lights = 1'024;\n")
        self.write("server/limits.h", "  uint64_t max_blob_bytes = uint64_t{1} << 30;\n")
        self.write("proto/penumbra/v1/server_info.proto",
                   "uint32 max_lights = 4;\nuint64 max_blob_bytes = 15;\n")
        self.write("docs/adr/README.md", "[0001](0001-a.md)\n")
        self.write("docs/adr/0001-a.md", "# 0001\n")
        self.write("server/options.cc", 'app.add_option("--threads", command.threads);\n')
        self.write("server/log.cc", 'logger.Info("started", {});\nlogger.Write(level, "ended", f);\n')
        self.write("server/metrics/all.cc", 'Add("penumbra_scenes", "Scenes");\n')
        self.operations(["threads"], ["started", "ended"], ["penumbra_scenes"])
        self.page(1024, "| `max_blob_bytes` | 1073741824 |")

    def page(self, lights, server):
        self.write("docs/limits.md", self.PAGE.format(lights=lights, server=server))

    def operations(self, *tables):
        text = ""
        for section, names in zip(("Options", "Log", "Metrics"), tables):
            text += f"## {section}\n\n" + "".join(f"| `{name}` | what |\n" for name in names) + "\n"
        self.write("docs/operations.md", text)

    def found(self):
        return check_docs.check(self.root)

    def test_clean_tree(self):
        self.assertEqual(self.found(), [])

    def test_options_events_and_metrics_that_are_not_told(self):
        self.operations([], ["started", "ended"], ["penumbra_scenes"])
        self.assert_finds(self.found(), "Options: threads is missing")
        self.operations(["threads"], ["started"], ["penumbra_scenes"])
        self.assert_finds(self.found(), "Log: ended is missing")
        self.operations(["threads"], ["started", "ended"], [])
        self.assert_finds(self.found(), "Metrics: penumbra_scenes is missing")

    def test_options_that_are_invented(self):
        self.operations(["threads", "moons"], ["started", "ended"], ["penumbra_scenes"])
        self.assert_finds(self.found(), "Options: moons is nowhere in server/")

    def test_limit_that_differs(self):
        self.page(1025, "| `max_blob_bytes` | 1073741824 |")
        self.assert_finds(self.found(), "max_lights is 1025, render/scene/scene_limits.h has 1024")

    def test_limit_that_is_missing(self):
        self.page(1024, "")
        self.assert_finds(self.found(), "max_blob_bytes, which the server reports, is missing")

    def test_limit_that_is_not_reported(self):
        self.write("server/limits.h", "  uint64_t max_blob_bytes = uint64_t{1} << 30;\n"
                                      "  uint32_t max_moons = 3;\n")
        self.assert_finds(self.found(), "server/limits.h: max_moons is not in v1.Limits")

    def test_limit_that_is_invented(self):
        self.page(1024, "| `max_blob_bytes` | 1073741824 |\n| `max_moons` | 1 |")
        self.assert_finds(self.found(), "max_moons is not in server/limits.h")

    def test_broken_link(self):
        self.write("docs/page.md", "See [there](there.md).\n")
        self.assert_finds(self.found(), "docs/page.md: links to there.md")

    def test_record_that_is_not_listed(self):
        self.write("docs/adr/0002-b.md", "# 0002\n")
        self.assert_finds(self.found(), "0002-b.md is missing")


class CatalogueTest(TreeTest):
    ROWS = ('[A01]\nwhat = "numbers"\ntests = ["Mesh.A01*", "Deltas/A01Nan"]\n'
            '[B01]\nwhat = "names"\ntests = ["Wire.test_B01_names"]\n'
            '[B02]\nwhat = "images"\ndoes_not_apply = "there are none"\n')

    def setUp(self):
        super().setUp()
        self.write("tests/unit/mesh_test.cc", "TEST_F(Mesh, A01NanAndMore) {\nTEST(Mesh, IsMade) {\n")
        self.write("tests/unit/deltas_test.cc",
                   'const Row kRows[] = {{"A01Nan"}, {"Plain"}};\nTEST_P(Deltas, AreRefused) {\n'
                   "INSTANTIATE_TEST_SUITE_P(All, Deltas, ::testing::ValuesIn(kRows));\n")
        self.write("tests/unit/wire.py", "class Wire(TestCase):\n    def test_B01_names(self):\n")

    def found(self, rows=ROWS):
        self.write("tests/catalogue/rows.toml", rows)
        return check_catalogue.check(self.root, {"A": 1, "B": 2})

    def test_clean_tree(self):
        self.assertEqual(self.found(), [])
        self.assertEqual(check_catalogue.summary(self.root),
                         "catalogue: 2 of 2 rows that apply have tests, 1 do not apply")

    def test_row_that_is_missing_or_invented(self):
        self.assertEqual(
            self.found(self.ROWS.replace("[B02]", "[B03]")),
            ["B02: missing in tests/catalogue/rows.toml", "B03: is no row of the catalogue"])

    def test_row_without_tests_or_a_reason(self):
        self.assert_finds(self.found(self.ROWS.replace('does_not_apply = "there are none"', "")),
                          "B02: needs either tests or a reason")
        self.assert_finds(self.found(self.ROWS.replace("there are none", "")),
                          "B02: does not say why")

    def test_test_that_does_not_exist(self):
        self.write("tests/unit/mesh_test.cc", "TEST(Mesh, IsMade) {\n")
        self.assert_finds(self.found(), "A01: there is no test Mesh.A01*")

    def test_test_of_a_row_that_is_not_in_the_table(self):
        self.add("tests/unit/wire.py", "    def test_B01_more_names(self):\n")
        self.assert_finds(self.found(), "B01: Wire.test_B01_more_names is not in")

    def test_test_of_a_row_that_does_not_apply(self):
        self.add("tests/unit/mesh_test.cc", "TEST(Mesh, B02Images) {\n")
        self.assert_finds(self.found(), "B02: Mesh.B02Images is not in")

    def test_row_whose_tests_have_other_names(self):
        self.write("tests/unit/wire.py", "")
        self.assert_finds(self.found(self.ROWS.replace("Wire.test_B01_names", "Mesh.IsMade")),
                          "no test has a name that begins with B01")

    def test_test_of_no_row(self):
        self.add("tests/unit/mesh_test.cc", "TEST(Mesh, A09Nothing) {\n")
        self.assert_finds(self.found(), "Mesh.A09Nothing: A09 is no row")


class TechniquesTest(TreeTest):
    ROW = "| `samples` | uint | 64 | 1 to 1024 | how many |\n"

    def setUp(self):
        super().setUp()
        told = {"techniques": [{"name": "soft", "parameters": [
            {"name": "samples", "type": "uint", "default_value": "64", "range": "1 to 1024"}]}]}
        self.write("penumbra", f"#!/bin/sh\ncat <<'END'\n{json.dumps(told)}\nEND\n")
        (self.root / "penumbra").chmod(0o755)

    def found(self, table):
        head = "| parameter | type | default | range | meaning |\n| --- | --- | --- | --- | --- |\n"
        self.write("docs/techniques/soft.md", f"# soft\n\n{head}{table}\n| `other` | table |\n")
        return check_techniques.check(self.root, self.root / "penumbra")

    def test_clean_tree(self):
        self.assertEqual(self.found(self.ROW), [])

    def test_default_that_differs(self):
        self.assert_finds(self.found(self.ROW.replace("64", "63")), "samples is uint | 63")

    def test_parameter_that_is_missing_or_invented(self):
        self.assert_finds(self.found(""), "parameter samples is missing")
        self.assert_finds(self.found(self.ROW + "| `moons` | uint | 1 | any |\n"),
                          "moons is no parameter of soft")

    def test_page_of_no_technique(self):
        self.write("docs/techniques/hard.md", "# hard\n")
        self.assert_finds(self.found(self.ROW), "hard.md: the program has no technique")


class ReadmeTest(TreeTest):
    def found(self, text):
        self.write("README.md", text)
        return check_readme.check(self.root, self.root)

    def test_commands_run_in_order_in_one_folder(self):
        self.assertEqual(self.found("<!-- test -->\n```sh\necho 1 > a\n```\n"
                                    "<!-- test -->\n```sh\ntest -s a\n```\n"), [])

    def test_command_that_fails(self):
        self.assert_finds(self.found("<!-- test -->\n```sh\nls /nowhere-at-all\ntrue\n```\n"),
                          "nowhere-at-all")

    def test_unmarked_commands_do_not_run(self):
        self.assert_finds(self.found("```sh\nfalse\n```\n"), "no block is marked")


if __name__ == "__main__":
    unittest.main()
