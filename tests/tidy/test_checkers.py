#!/usr/bin/env python3
"""Every checker takes a clean tree and finds each planted fault, so that none is blind."""
import pathlib
import shutil
import tempfile
import unittest

import check_decisions
import check_definitions
import check_english
import check_folders
import check_format
import check_includes
import check_layout
import check_lengths
import check_links
import check_styles
import check_unused
import check_vocabulary
import check_walks
import check_words

CLEAN = {
    "CMakeLists.txt": "project(x)\n",
    "CMakePresets.json": "{}\n",
    "CHANGELOG.md": "# Changes\n",
    "LICENSE": "Apache-2.0\n",
    ".clang-format": "BasedOnStyle: Google\nIndentWidth: 4\nColumnLimit: 100\n",
    "README.md": "# x\nSee [isa](isa/README.md) and `host/io/import.cpp`.\n",
    "isa/README.md": "isa\n",
    "isa/limits.def": 'LIMIT(int, max_lights, 4, "lights")\n',
    "isa/program.hpp": "#pragma once\n",
    "ringbus/README.md": "ringbus\n",
    "ringbus/rules/pass.hpp": "struct Pass {\n    int sample = 0;\n    int run();\n"
                              "    void end(int a) { run(); }\n};\n",
    "ringbus/schema/vocabulary.fbs": "enum Scalar : ubyte { uint8, int16 }\n",
    "ringbus/zmq/zmq_link.cpp": "#include <zmq.hpp>\n",
    "gp_firmware/README.md": "gp\n",
    "gp_firmware/node/node.cpp": '#include "gp_firmware/volume/slice.hpp"\n'
                                 '#include "ringbus/message.hpp"\n',
    "gp_firmware/volume/slice.hpp": '#include "generated/vocabulary.hpp"\n'
                                    '#include "gp_firmware/hal/memory.hpp"\n'
                                    '#include "isa/program.hpp"\n'
                                    '#include "ringbus/rules/pass.hpp"\n',
    "gp_firmware/hal/memory.hpp": "#pragma once\n",
    "renderer_firmware/README.md": "renderer\n",
    "renderer_firmware/main.cpp": '#include "ringbus/process/process.hpp"\n',
    "host/README.md": "host\n",
    "host/main.cpp": '#include "host/phantom/field.hpp"\n',
    "host/base/README.md": "base\n",
    "host/base/text.hpp": "int g();\n",
    "host/session/README.md": "session\n",
    "host/session/session.cpp": '#include "ringbus/message.hpp"\n',
    "host/inspect/README.md": "inspect\n",
    "host/inspect/record/walk.cpp": '#include "renderer_firmware/igc/region.hpp"\n',
    "host/WALKTHROUGHS.md": "1. `g()` in [text](base/text.hpp) calls\n   `Pass::run()` in\n"
                            "   [pass](../ringbus/rules/pass.hpp), and `Pass::end()`.\n",
    "host/io/README.md": "io\n",
    "host/serve/page/link/connection.js": "export {};\n",
    "host/serve/page/state/store.js":
        "/** @typedef {import('../link/connection.js').Reply} Reply */\nexport {};\n",
    "host/io/import.cpp": "#include <itkImageIOBase.h>\n",
    "host/phantom/README.md": "phantom\n",
    "host/phantom/field.cpp": "int f();\n",
    "tests/README.md": "tests\n",
}
LONG = "".join(f"    x = {i};\n" for i in range(71))
MEMBERS = "struct S {\n    S(int a) : a_{a}, b_{a} {\n" + LONG + "    }\n    int a_, b_;\n};\n"


class Planted(unittest.TestCase):
    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.root)
        for name, text in CLEAN.items():
            self.plant(name, text)

    def plant(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def finds(self, checker, name, text, words):
        """`checker` takes the clean tree, and finds `words` once `text` is planted in `name`."""
        self.assertEqual(checker.check(self.root), [])
        before = CLEAN.get(name)
        self.plant(name, text)
        errors = checker.check(self.root)
        self.assertTrue(errors, f"{words}: not found")
        top = name.split("/")[0]
        self.assertTrue(any(top in error and words in error for error in errors), errors)
        if before is None:
            (self.root / name).unlink()
            if not any((self.root / name).parent.iterdir()):
                (self.root / name).parent.rmdir()
        else:
            self.plant(name, before)

    def test_includes(self):
        for name, included, words in (
                ("isa/a.hpp", '"ringbus/link.hpp"', "isa may not include ringbus"),
                ("ringbus/a.hpp", '"isa/program.hpp"', "ringbus may not include isa"),
                ("gp_firmware/a.cpp", '"renderer_firmware/a.hpp"', "may not include renderer"),
                ("host/base/a.cpp", '"gp_firmware/volume/slice.hpp"', "host may not include gp"),
                ("host/base/a.cpp", '"session.hpp"', "not a path from the top"),
                ("host/base/a.cpp", '"host/base/../io/import.hpp"', "not a path from the top"),
                ("host/base/a.cpp", "<host/io/import.hpp>", "in double quotes"),
                ("host/machine/a.cpp", "<zmq.hpp>", "only ringbus/zmq/*"),
                ("ringbus/node.cpp", "<zmq.h>", "only ringbus/zmq/*"),
                ("host/serve/director/a.cpp", "<libwebsockets.h>", "only host/serve/server/*.cpp"),
                ("host/base/a.cpp", "<OpenImageIO/imageio.h>", "only host/io includes"),
                ("host/phantom/a.cpp", "<itkImage.h>", "only host/io includes"),
                ("host/scene/a.cpp", "<cairo.h>", "only host/io includes"),
                ("host/surface/a.cpp", "<meshoptimizer.h>", "only host/io includes"),
                ("host/surface/a.cpp", "<assimp/scene.h>", "only host/io includes"),
                ("host/phantom/a.cpp", '"ringbus/message.hpp"', "only ringbus, nodes"),
                ("gp_firmware/volume/a.cpp", '"message_generated.h"', "only ringbus, nodes"),
                ("gp_firmware/volume/a.cpp", '"ringbus/link.hpp"', "a stage may not include"),
                ("gp_firmware/volume/a.cpp", '"gp_firmware/node/node.hpp"', "a stage may not"),
                ("host/base/a.cpp", '"host/session/session.hpp"',
                 "host/base may not include host/session"),
                ("host/io/values/a.cpp", '"host/io/import.hpp"',
                 "host/io/values may not include host/io/."),
                ("host/inspect/record/a.cpp", '"host/inspect/why/why.hpp"',
                 "host/inspect/record may not include host/inspect/why"),
                ("host/phantom/a.cpp", '"host/io/import.hpp"',
                 "host/phantom may not include host/io"),
                ("isa/a.cpp", '"isa/reference/bits.hpp"', "isa/. may not include isa/reference"),
                ("isa/contract/a.hpp", '"isa/reference/bits.hpp"',
                 "isa/contract may not include isa/reference"),
                ("ringbus/a.cpp", '"ringbus/trace/recorder.hpp"',
                 "ringbus/. may not include ringbus/trace"),
                ("ringbus/trace/a.cpp", '"ringbus/process/process.hpp"',
                 "ringbus/trace may not include ringbus/process"),
                ("renderer_firmware/fast/a.cpp", '"renderer_firmware/igc/igc.hpp"',
                 "renderer_firmware/fast may not include renderer_firmware/igc"),
                ("renderer_firmware/igc/a.cpp", '"renderer_firmware/hal/port.hpp"',
                 "renderer_firmware/igc may not include renderer_firmware/hal"),
                ("host/attic/a.cpp", '"host/base/text.hpp"', "is not in ROOMS"),
                ("gp_firmware/hal/a.cpp", '"gp_firmware/volume/slice.hpp"', "hal may not")):
            self.finds(check_includes, name, f"#include {included}\n", words)

    def test_rooms(self):
        self.plant("gp_firmware/node/job.hpp", '#include "ringbus/message.hpp"\n'
                   '#include "gp_firmware/render/a.hpp"\n#include "gp_firmware/hal/memory.hpp"\n')
        self.plant("gp_firmware/render/a.hpp", '#include "gp_firmware/geometry/a.hpp"\n')
        self.plant("gp_firmware/geometry/a.hpp", '#include "gp_firmware/surface/a.hpp"\n')
        self.plant("gp_firmware/surface/a.hpp", '#include "gp_firmware/volume/slice.hpp"\n')
        for room, above in (("hal", "volume"), ("volume", "surface"), ("surface", "geometry"),
                            ("geometry", "render"), ("render", "node")):
            self.finds(check_includes, f"gp_firmware/{room}/b.cpp",
                       f'#include "gp_firmware/{above}/a.hpp"\n', "may not include")
        self.finds(check_includes, "gp_firmware/node/b.cpp", '#include "gp_firmware/main.hpp"\n',
                   "gp_firmware/node may not include gp_firmware/.")
        self.finds(check_includes, "gp_firmware/shed/a.cpp", '#include "isa/program.hpp"\n',
                   "gp_firmware/shed is not in ROOMS")
        self.finds(check_includes, "host/a.cpp", '#include "gp_firmware/node/job.hpp"\n',
                   "host may not include gp_firmware")

    def test_every_room_is_a_folder_and_their_order_has_no_cycle(self):
        root = pathlib.Path(__file__).parents[2]
        for folder, rooms in check_includes.ROOMS.items():
            below = set()
            for room, includes in rooms.items():
                self.assertTrue((root / folder / room).is_dir(), f"{folder}/{room}")
                self.assertLessEqual(includes, below, f"{folder}/{room} is above what it includes")
                below.add(room)

    def test_imports_of_the_page(self):
        page = "host/serve/page"
        for name, text, words in (
                ("link/a.js", "import {Store} from '../state/store.js';\n",
                 f"{page}/link may not include {page}/state"),
                ("link/a.js", "import {\n  Store,\n} from '../state/store.js';\n",
                 f"{page}/link may not include {page}/state"),
                ("link/a.js", "/** @typedef {import('../main.js').App} App */\n",
                 f"{page}/link may not include {page}/."),
                ("slices/a.js", 'import "../machine/ring.js";\n',
                 f"{page}/slices may not include {page}/machine"),
                ("attic/a.js", "import '../link/connection.js';\n", "is not in ROOMS"),
                ("link/a.js", "import {x} from '../../server/x.js';\n", "is not served"),
                ("link/a.js", "import * as d3 from 'd3';\n", "is not a relative path")):
            self.finds(check_includes, f"{page}/{name}", text, words)

    def test_lengths(self):
        self.finds(check_lengths, "isa/a.cpp", "int x;\n" * 401, "401 lines")
        self.finds(check_lengths, "isa/a.cpp", "//" + "x" * 99 + "\n", "101 columns")
        self.finds(check_lengths, "isa/CMakeLists.txt", "#" + "x" * 100 + "\n", "101 columns")
        self.finds(check_lengths, "README.md", "x\n" * 121, "121 lines")
        self.finds(check_lengths, "isa/a.cpp", "void f() {\n" + LONG + "}\n",
                   ":1: function of 73 lines")
        self.finds(check_lengths, "isa/a.cpp", "namespace a {\n\nbool operator==(A a,\n"
                   "                B b) {\n" + LONG + "}\n}\n", ":3: function of 74 lines")
        self.finds(check_lengths, "isa/a.cpp", MEMBERS, ":2: function of 73 lines")
        self.finds(check_lengths, "isa/a.cpp", 'TEST_SUITE("s") {\nTEST_CASE("{") {\n' + LONG +
                   "}\n}\n", ":2: function of 73 lines")

    def test_lengths_spares_tables_and_short_functions(self):
        self.plant("isa/case_tables.cpp", "int x;\n" * 500)
        self.plant("isa/a.def", "//" + "x" * 200 + "\n")
        # Many short functions, a long initialiser, a brace in a comment, a string and a macro.
        self.plant("isa/a.cpp", "int t[] = {\n" + "    1,\n" * 90 + "};\n" +
                   "void f() {\n    g('{', \"{\");  // {\n}\n" * 30 + "#define A {\n" +
                   "enum class E {\n" + "    a,\n" * 80 + "};\n")
        self.plant("host/serve/page/texts/de/a.js", "//" + "x" * 200 + "\n")
        self.assertEqual(check_lengths.check(self.root), [])
        self.finds(check_lengths, "host/serve/page/texts/a.js", "//" + "x" * 99 + "\n", "columns")

    def test_layout(self):
        self.finds(check_layout, "extra/a.cpp", "", "extra: the top level is fixed")
        self.finds(check_layout, "notes.txt", "", "notes.txt: the top level is fixed")
        self.finds(check_layout, "host/scene/page.cpp", "", "host/scene: has no README.md")
        for gone in ("isa/README.md", "host/io/README.md", "LICENSE"):
            (self.root / gone).unlink()
            errors = check_layout.check(self.root)
            self.assertEqual(len(errors), 1, errors)
            self.plant(gone, CLEAN[gone])

    def test_members(self):
        members = "".join(f"    int a{i}_ = 0;\n" for i in range(21))
        self.finds(check_lengths, "host/base/text.hpp", "class C {\n" + members + "};\n",
                   "C has 21 data members")
        self.plant("host/base/text.hpp", "int g();\nclass C {\n    int f(int a_) { return a_; }\n"
                   + members.replace("    int a20_ = 0;\n", "") + "};\n")
        self.assertEqual(check_lengths.check(self.root), [])

    def test_english(self):
        for name, text, words in (
                ("isa/a.cpp", "int a;  ///< Of the tree.\n", "its subject"),
                ("isa/a.cpp", "/// As the paper has it.\n", "its subject"),
                ("isa/a.cpp", "int a;  ///< What it holds.\n", "its subject"),
                ("isa/a.hpp", "// Who may connect.\n", "its subject"),
                ("isa/a.cpp", "// Nobody waits longer.\n", "name the person"),
                ("isa/a.cpp", "// who is ready goes on\n", "name the person"),
                ("README.md", "`info` tells what is odd.\n", "print, report"),
                ("README.md", "It is drawn anew.\n", "again"),
                ("isa/a.def", "// the colour\n", "American"),
                ("isa/a.cpp", "int colour;\n", "American"),
                ("isa/a.cpp", "int a;  ///< A colour.\n", "American"),
                ("isa/a.cpp", 'int a = f("the center of gray", "the colour");\n', "American"),
                ("isa/a.cpp", 'int a = f("nobody waits");\n', "name the person"),
                ("README.md", "x " * 51 + "\n", "102 columns")):
            self.finds(check_english, name, text, words)
        self.plant("isa/README.md", "| a table | " + "x " * 60 + "|\nThose who ask get it.\n")
        self.plant("host/serve/page/texts/de/a.js", "// Farben: colour\n")
        self.assertEqual(check_english.check(self.root), [])

    def test_decisions(self):
        parts = "*Context:* a. *Decision:* b. *Reason:* c. *Cost:* none.\n"
        record = "**ISA-1. Words** (2026-11-21).\n" + parts
        row = "| ISA-1 | Words | [isa](../isa/README.md) |\n"
        self.plant("isa/README.md", record)
        self.plant("host/DECISIONS.md", row)
        for name, text, words in (
                ("gp_firmware/volume/README.md", "### GP-1 Size (2026-11-21)\n" + parts,
                 "add the row | GP-1 | Size | [gp_firmware/volume](../gp_firmware/volume/"),
                ("ringbus/A.md", record, "ISA-1 is also a decision of isa/README.md"),
                ("isa/A.md", "**ISA-2. Bits.** *Context:* d. *Decision:* e. *Cost:* f.\n",
                 "ISA-2 has no Reason"),
                ("isa/A.md", "*Decision:* d.\n", "1 decisions, but 0 headings with a number")):
            self.finds(check_decisions, name, text, words)
        self.plant("isa/README.md", "isa\n")
        self.assertIn("remove the row | ISA-1", check_decisions.check(self.root)[0])

    def test_folders(self):
        for number in range(30):
            self.plant(f"isa/many/part{number}.cpp", "")
        self.finds(check_folders, "isa/many/one_more.hpp", "", "isa/many: 31 source files")

    def test_unused(self):
        for name in [name for name in CLEAN if name.endswith((".hpp", ".cpp"))]:
            (self.root / name).unlink()
        self.plant("isa/used.hpp", "int used(int x);\nstd::vector<int> listed();\n")
        self.plant("isa/used.cpp", '#include "isa/used.hpp"\nint used(int x) { return x; }\n'
                   "std::vector<int> listed() { return {}; }\nint y = used(3);\n"
                   "auto z = 3 > y ? listed()\n               : std::vector<int>();\n")
        self.finds(check_unused, "isa/b.hpp", "", "isa/b.hpp: no file includes it")
        self.finds(check_unused, "isa/used.hpp", "int used(int x);\nstd::vector<int> listed();\n"
                   "double idle(double x);\n", "idle() is never called")

    def test_definitions(self):
        for text in ("namespace x {\nstruct Pass {\n};\n}  // namespace x\n",
                     "namespace x {\nclass Pass final : public Base {\n};\n}  // namespace x\n",
                     "namespace x {\nint f() {\n}\nenum class Pass { a };\n}  // namespace x\n"):
            self.plant("isa/pass.hpp", "namespace x {\nnamespace {\nstruct Run {\n};\n"
                       "}  // namespace\nstruct Pass {\n};\n}  // namespace x\n")
            self.finds(check_definitions, "ringbus/a.hpp", text,
                       "x::Pass is defined in isa/pass.hpp")
        self.plant("isa/a.cpp", "namespace x {\nnamespace {\nstruct Run {\n};\n}  // namespace\n"
                   "struct Pass;\n}  // namespace x\n")
        self.assertEqual(check_definitions.check(self.root), [])

    def test_words(self):
        for name, text, words in (
                ("isa/a.cpp", "// TODO: more\n", "TODO"), ("README.md", "FIXME\n", "FIXME"),
                ("isa/a.cpp", "// a stub\n", "stub"), ("isa/a.cpp", "Placeholder\n", "stands in"),
                ("isa/a.cpp", "std::this_thread::sleep_for(1ms);\n", "wait for an event"),
                ("isa/a.cpp", "usleep(3);\n", "usleep"), ("isa/a.cpp", "sleep(3);\n", "sleep"),
                ("isa/a.sh", "sleep 3\n", "wait for an event"),
                ("isa/a.py", "time.sleep(3)\n", "wait for an event"),
                ("isa/a.cpp", "x = hn::MulAdd(a, b, c);\n", "fuses"),
                ("isa/CMakeLists.txt", "add_compile_options(-march=native)\n", "between machines"),
                ("README.md", "see /" + "work/x\n", "one machine")):
            self.finds(check_words, name, text, words)
        page = "host/serve/page/panel/a.js"
        for text in ("row.innerHTML = name;", "row.outerHTML = name;", "document.write(name);",
                     "row.insertAdjacentHTML('beforeend', name);", "frame.srcdoc = name;"):
            self.finds(check_words, page, f"{text}\n", "a.js:1: ")
        for text in ("eval(name);", "new Function('a', name);", "const f = Function(name);"):
            self.finds(check_words, page, f"{text}\n", "runs a text as a program")
        self.finds(check_words, "host/serve/page/index.html", "<iframe srcdoc='x'>\n", "srcdoc")
        self.plant(page, "row.textContent = name;\nretrieval(name);\nconst isFunction = a => 1;\n")
        self.plant("tests/browser/a.js", "page.waitForFunction(new Function('a', text));\n")
        self.assertEqual(check_words.check(self.root), [])

    def test_vocabulary(self):
        scalar = "Scalar is defined in ringbus/schema/vocabulary.fbs"
        for name, text, words in (
                ("host/a.hpp", "inline constexpr std::size_t max_lights = 4;\n", "isa/limits.def"),
                ("host/a.hpp", "constexpr int most = 3, max_lights = 4;\n", "isa/limits.def"),
                ("host/a.js", "const MAX_LIGHTS = 4;\n", "isa/limits.def"),
                ("ringbus/schema/limits.def", 'LIMIT(int, max_lights, 8, "x")\n',
                 "another limits.def"),
                ("host/a.hpp", "enum class Scalar : std::uint8_t { a };\n", scalar),
                ("ringbus/schema/a.fbs", "enum Scalar : ubyte { a }\n", scalar),
                ("host/a.hpp", "struct Pass {\n", "Pass is defined in ringbus/rules/pass.hpp"),
                ("host/a.cpp", "static_assert(static_cast<int>(A::b) ==\n"
                               "              static_cast<int>(wire::A::b));\n", "use one"),
                ("host/a.cpp", "int words = 2 * 128 * 128;\n", "region_pixels")):
            self.finds(check_vocabulary, name, text, words)

    def test_walks(self):
        page = "host/WALKTHROUGHS.md"
        for step, words in (
                ("`gone()` in [text](base/text.hpp)", "gone() is not in base/text.hpp"),
                ("`g()` in [field](phantom/field.cpp)", "g() is not in phantom/field.cpp"),
                ("`run()` in [field](phantom/field.cpp)", "run() is not in"),
                ("`Other::run()` in [pass](../ringbus/rules/pass.hpp)", "Other::run() is not in"),
                ("`g()` in [text](base/text.hpp) calls `gone()`", "gone() is not in base/text.hpp"),
                ("`g()` in [text](base/gone.hpp)", "g() has no file behind it"),
                ("`g()` is called", "g() has no file behind it"),
                ("The host is idle.", "the step names no function")):
            self.finds(check_walks, page, f"1. `g()` in [text](base/text.hpp)\n2. {step}\n",
                       f"{page}:2: {words}")
        # A call, or a name in a comment, is no definition.
        self.plant("host/base/text.hpp", "int g();\nint f() { return used(1); }\n// int told();\n")
        for name in ("used", "told"):
            self.finds(check_walks, page, f"1. `{name}()` in [text](base/text.hpp)\n", name)

    def test_styles(self):
        sheet = "host/serve/page/parts.css"
        for text, words in (
                ("a { color: #fff; }\n", "a color that tokens.css does not name"),
                ("a {\n  border: 1px solid rgb(0, 0, 0) }\n", ":2: border: 1px solid rgb"),
                ("a { fill: white }\n", "a color"),
                ("a { font-size: 0.9em; }\n", "a size of letters"),
                ("a { font: 600 12px var(--font); }\n", "a size of letters"),
                ("@media print { a { gap: 4px; } }\n", "a distance"),
                ("a { padding: 0 3px var(--space-1); }\n", "a distance"),
                ("a { margin-top: 0.5em }\n", "a distance"),
                ("a { border-radius: 5px; }\n", "a corner")):
            self.finds(check_styles, sheet, text, words)
        self.finds(check_styles, "host/serve/page/a.js", "font = `${n}px system-ui`;\n", "a.js:1")
        self.plant(sheet, "/* #fff */ a:hover { margin: 0 auto calc(-1 * var(--space-2)); "
                   "font: 600 var(--type-small)/1.2 var(--font); gap: 0 var(--space-half); }\n"
                   "#add { border-radius: var(--radius); font: inherit; color: CanvasText; }\n")
        self.plant("host/serve/page/tokens.css", ":root { --ground: #000; font: 13px serif; }\n")
        self.assertEqual(check_styles.check(self.root), [])

    def test_links(self):
        self.finds(check_links, "isa/README.md", "[x](nowhere.md)\n", "nowhere.md")
        self.finds(check_links, "isa/README.md", "`host/gone.cpp`\n", "host/gone.cpp")
        self.finds(check_links, "isa/README.md", "`gone.*`\n", "gone.*")
        self.finds(check_links, "isa/README.md", "| file | holds |\n|---|---|\n| `import.cpp` |\n",
                   "lists import.cpp, which is not in isa")
        self.plant("isa/README.md", "`program.hpp`, `field.cpp`, `host/io/import.*`, `../LICENSE`, "
                   "[up](../README.md#x), [web](https://example.org/a.md), `build/gone.cpp`\n")
        self.assertEqual(check_links.check(self.root), [])

    @unittest.skipIf(shutil.which("clang-format") is None, "clang-format is not installed")
    def test_format(self):
        self.finds(check_format, "isa/a.cpp", "int  f( ){return 1;}\n", "clang-format -i isa/a.cpp")


if __name__ == "__main__":
    unittest.main()
