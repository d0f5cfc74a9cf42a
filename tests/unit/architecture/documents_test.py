#!/usr/bin/python3
"""Documents that sources name and targets of links exist, and the index of docs/ names every page."""
import pathlib
import re
import sys
import unittest

from sources_test import FILES, ROOT, text_of

PAGES = [path for path in FILES if path.suffix == ".md"]
TEXTS = {".cpp", ".hpp", ".proto", ".py", ".md", ".toml", ".txt", ".sh", ".js", ".yml", ""}


def anchors(page):
    """Names of the headings of a page, as in links."""
    headings = re.findall(r"^#+ (.*)$", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}


class Documents(unittest.TestCase):
    def test_a_document_that_a_source_names_exists(self):
        sources = [path for path in FILES if path.suffix in TEXTS and not path.is_relative_to("docs")]
        lost = [f"{path}: {name}" for path in sources
                for name in re.findall(r"\bdocs/[\w/-]+\.md\b", text_of(path)) if not (ROOT / name).is_file()]
        self.assertEqual(lost, [])

    def test_a_link_leads_to_a_file(self):
        lost = [f"{page}: {target}" for page in PAGES
                for target in re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text_of(page))
                if not target.startswith("http") and not (ROOT / page.parent / target).exists()]
        self.assertEqual(lost, [])

    def test_a_link_into_a_page_leads_to_a_heading(self):
        lost = []
        for page in PAGES:
            for target, anchor in re.findall(r"\]\(([^)#\s]*)#([^)]*)\)", text_of(page)):
                if target.startswith("http") or (target and not target.endswith(".md")):
                    continue
                if anchor not in anchors(ROOT / page.parent / target if target else ROOT / page):
                    lost.append(f"{page}: {target}#{anchor}")
        self.assertEqual(lost, [])

    def test_the_runs_of_a_table_fit_its_rows_and_columns(self):
        sys.path.insert(0, str(ROOT / "docs"))
        import tables
        for page in PAGES:
            for mark in tables.MARK.finditer(text_of(page)):
                with self.subTest(page=page):
                    tables.table_of(mark)

    def test_the_index_names_every_page(self):
        index = text_of(pathlib.PurePosixPath("docs/README.md"))
        pages = [str(path.relative_to("docs")) for path in PAGES
                 if path.is_relative_to("docs") and path.name != "README.md"]
        self.assertEqual([page for page in pages if f"({page})" not in index], [])


if __name__ == "__main__":
    unittest.main()
