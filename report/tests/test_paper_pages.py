"""The report and its supplement as pages, alone: they keep what `test_site` asks of every page.

A word in a section changes these two, which are soon made. Others stand in for the rest.
"""

from html import escape

import pytest

from report.site import build as pages
from report.site import proofs
from report.site.search import script
from report.tests.test_site import (  # noqa: F401 - asked of the pages that are made here
    index,
    test_pages_have_a_policy_that_lets_run_what_they_need_alone,
    test_pages_have_headings_in_steps_and_buttons_that_differ,
    test_pictures_have_their_size_and_keep_their_pixels,
    test_search_finds_tests_and_equations_by_name,
    test_sections_are_named_by_their_words_each_once,
    test_site_has_no_faults,
    test_site_sets_formulas_in_a_font_that_it_brings_along,
)

READS = ["report/*", "figures/*", "notebooks/*.ipynb", "tests/*", "environment.txt", "CITATION.cff"]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """Return a folder of the two pages, the proofs that they lead to, and empty pages."""
    folder = tmp_path_factory.mktemp("paper")
    made = pages.Site(folder)
    pages.add_shared(made)
    pages.add_reports(made, [])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(proofs, "code", lambda text: f"<pre>{escape(text)}</pre>")
        pages.add_proofs(made)
        pages.add_guide(made)
    for address in ("index.html", "chapters/00_index.html", "library/index.html"):
        made.page(address, address, "<h1>Elsewhere</h1>", kind="library")
    made.write("search-index.js", script(made.found))
    return folder
