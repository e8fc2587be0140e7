# SPDX-License-Identifier: MIT
"""What make site does beside Doxygen: comments and documents in Doxygen's form, and the check of the links."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "test/runs"))

from simulator import call

HEADER = """\
/* Blinks an LED.
 *
 *     blink_begin(&blink);
 */
#define BLINK_MAX 3 // LEDs

/* One LED; 5 * 2 mA. */
struct blink {
    uint8_t id, bit; // of its port,
                     // 0 to 7
    // internal:
    uint8_t phase;
    // to be read:
    bool is_on; // now
};

/* Pauses the LED. */
void blink_pause(struct blink *blink,
                 uint8_t count);
void blink_resume(struct blink *blink);

void blink_end(void);
"""
FILTERED = r"""/** @file
Blinks an LED.

@verbatim
blink_begin(&blink);
@endverbatim */
#define BLINK_MAX 3 /**< LEDs */

/** One LED; 5 \* 2 mA. */
struct blink {
    uint8_t id; /**< of its port, 0 to 7 */
    uint8_t bit; /**< of its port, 0 to 7 */
/** @cond */
    uint8_t phase;
/** @endcond */
    // to be read:
    bool is_on; /**< now */
};

/** Pauses the LED. */
void blink_pause(struct blink *blink,
                 uint8_t count);
/** Pauses the LED. */
void blink_resume(struct blink *blink);

void blink_end(void);
"""
LIST = """\
/* Results. */
#define ALL(X) \\
    X(FINE, 0, "well, done") \\
    X(WRONG, 1, "wrong")

/* What a call returns. */
enum all {
#define ALL_ENUM_(name, number, text) name = number,
    ALL(ALL_ENUM_)
#undef ALL_ENUM_
};
"""


class Site(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def filtered(self, name, text):
        (self.folder / name).write_text(text)
        done = subprocess.run([ROOT / "scripts/doxygen_filter.py", name], cwd=self.folder, text=True,
                              stdout=subprocess.PIPE, check=True)
        return "\n".join(line.rstrip() for line in done.stdout.splitlines() if line.strip())

    def test_filter_header_comments_become_comments_of_doxygen(self):
        wanted = "\n".join(line for line in FILTERED.splitlines() if line)
        self.assertEqual(self.filtered("blink.h", HEADER), wanted)

    def test_filter_enum_of_a_list_has_its_rows(self):
        text = self.filtered("all.h", LIST)
        self.assertIn("    FINE = 0, /**< text: well, done */\n    WRONG = 1, /**< text: wrong */\n};", text)

    def test_filter_document_links_lead_to_pages_of_the_site(self):
        self.assertEqual(self.filtered("page.md", "# Page\n[a](docs/other.md#b-c) [h](include/cds55xx/a_b.h) "
                                       "[x](src/x.c)\n## B c\n```\n# [n](y.md)\n```\n"),
                         "# Page {#page}\n[a](other.html#other-b-c) [h](a__b_8h.html) [x](files/src/x.c)\n"
                         "## B c {#page-b-c}\n```\n# [n](y.md)\n```")

    def site(self, link):
        (self.folder / "a.html").write_text(f'<a href="{link}">x</a><p id="here">')
        return call(sys.executable, ROOT / "scripts/site.py", self.folder)

    def test_site_link_that_leads_nowhere_fails(self):
        for link in ["b.html", "a.html#there", "#there", "files/none.c"]:
            status, output = self.site(link)
            self.assertEqual((status, output.count(f"a.html: {link}: there is no such")), (1, 1), output)

    def test_site_good_links_pass(self):
        for link in ["a.html#here", "#here", "https://example.org/x", "#"]:
            self.assertEqual(self.site(link), (0, ""))


if __name__ == "__main__":
    unittest.main()
