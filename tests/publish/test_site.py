"""The site in the browser, opened as files with the network cut."""

import re
import threading
from collections import Counter
from functools import partial
from html.parser import HTMLParser
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from bs4 import BeautifulSoup

from pgm_book.common import ledger
from pgm_book.make.browser import offline_context
from pgm_book.make.site import api, sources
from pgm_book.make.site.verdicts import all_verdicts
from pgm_lab import datasets
from tests.publish.look import axe_violations, load_axe
from tests.publish.watch import Watched

# One page of each kind
KINDS = [
    "index",
    "chapters/index",
    "chapters/07_pearson_registration",
    "guides/network",
    "reference/pgm_book.common.ledger",
    "verdicts",
    "equations",
    "glossary",
    "proofs/test_harintaka2020_ncc",
    "_modules/pgm_lab/ncc/_match",
    "search",
]

# So high that all of the list of pages is seen; else axe-core tells no contrast there.
TALL = {"width": 1280, "height": 4000}


@pytest.fixture(scope="module")
def context(browser):
    context = offline_context(browser, viewport={"width": 1280, "height": 900})
    yield context
    context.close()


@pytest.fixture
def page(context):
    watched = Watched(context)
    yield watched.page
    watched.page.close()
    assert not watched.errors


@pytest.fixture(scope="module")
def soup(site_folder):
    def read(page):
        text = (site_folder / f"{page}.html").read_text(encoding="utf-8")
        return BeautifulSoup(text, "html.parser")

    return read


class Links(HTMLParser):
    """The anchors of a page, what it links to and what it loads."""

    def __init__(self, path: Path):
        super().__init__()
        self.anchors: set[str] = {""}
        self.targets: set[str] = set()
        self.loaded: set[str] = set()
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.anchors |= {given.get("id"), given.get("name") if tag == "a" else None}
        target = given.get("href") or given.get("src")
        if target:
            (self.targets if tag == "a" else self.loaded).add(target)


def pages_of(site: Path) -> list[str]:
    """All pages but the listings of the package, which are all alike, save one."""
    names = (path.relative_to(site).as_posix() for path in site.rglob("*.html"))
    return sorted(
        n for n in names if not n.startswith("_") or n.endswith("_match.html")
    )


def test_every_internal_link_lives_and_nothing_is_loaded_from_elsewhere(site_folder):
    site = site_folder.resolve()
    links = {path: Links(path) for path in site.rglob("*.html")}
    dead = []
    for path, found in links.items():
        for target in found.targets | found.loaded:
            address = urlsplit(target)
            if address.scheme or address.netloc:
                elsewhere = target in found.loaded and address.scheme != "data"
                dead += [f"{path.name} loads {target}"] * elsewhere
                continue
            file = (path.parent / unquote(address.path)).resolve()
            file = file if address.path else path
            anchors = links[file].anchors if file in links else {""}
            if not file.is_file() or unquote(address.fragment) not in anchors:
                dead.append(f"{path.relative_to(site)}: {target}")
    assert not dead


def test_no_page_fails_has_a_red_formula_or_is_wider_than_a_phone(browser, site_folder):
    phone = offline_context(browser, viewport={"width": 390, "height": 844})
    watched = Watched(phone)
    wide, red = [], []
    for name in pages_of(site_folder):
        watched.page.goto((site_folder / name).as_uri())
        watched.page.evaluate("() => window.MathJax?.startup?.promise")
        root = "document.documentElement"
        if watched.page.evaluate(f"{root}.scrollWidth > {root}.clientWidth"):
            wide.append(name)
        red += watched.page.locator("[data-mml-node=merror]").all_text_contents()
    phone.close()
    elsewhere = [url for url in watched.requests if not url.startswith("file:")]
    assert (wide, red, watched.errors, elsewhere) == ([], [], [], [])


@pytest.mark.parametrize("name", KINDS)
def test_no_kind_of_page_violates_accessibility(browser, site_folder, name):
    context = offline_context(
        browser, viewport=TALL, color_scheme="light", reduced_motion="reduce"
    )
    page = context.new_page()
    # Of the rows of the verdicts, some of each kind; all are made alike.
    asked = {"search": "?q=collinearity", "verdicts": "?chapter=1"}.get(name, "")
    page.goto((site_folder / f"{name}.html").as_uri() + asked)
    page.evaluate("() => window.MathJax?.startup?.promise")
    page.evaluate(
        "document.querySelectorAll('details').forEach((fold) => { fold.open = true; })"
    )
    load_axe(page)
    assert not axe_violations(page)
    page.emulate_media(color_scheme="dark")
    page.locator("html[data-theme=dark]").wait_for()
    assert not axe_violations(page, "color-contrast")
    context.close()


class Quiet(SimpleHTTPRequestHandler):
    """A server that does not write what it is asked for."""

    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def served(site_folder):
    """The address of the site on a server, as Pages shows it."""
    handler = partial(Quiet, directory=site_folder)
    with ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def search(page, address, words):
    """Search as a reader does, from the head of the first page; list what is found."""
    page.goto(f"{address}/index.html")
    page.locator(".search-button__button:visible").click()
    page.locator("dialog[open] input[name=q]").fill(words)
    page.keyboard.press("Enter")
    page.locator("#search-results .search-summary", has_text="found").wait_for()
    return page.locator("#search-results li > a")


FINDS = {
    "collinearity": "collinearity",
    "kolinearitas": "glossary.html#term-kolinearitas",
    "M 2.94": "equations.html#",
    "(M 2.94)": "equations.html#",
    "2.94": "equations.html#",
    "test_2_5a_undoes_2_3a": "proofs/test_bani2010.html",
}


def test_the_search_finds(page, site_folder):
    for words, first in FINDS.items():
        found = search(page, site_folder.as_uri(), words).first
        assert first in found.get_attribute("href"), words


def test_the_search_finds_a_word_of_the_glossary_in_its_chapter_too(page, site_folder):
    found = search(page, site_folder.as_uri(), "kolinearitas")
    pages = [link.get_attribute("href") for link in found.all()]
    assert any("chapters/05_intersection" in one for one in pages)


def test_the_search_of_a_server_finds_and_asks_no_other(browser, served):
    context = browser.new_context()
    watched = Watched(context)
    for words in ("collinearity", "kolinearitas", "M 2.94"):
        found = search(watched.page, served, words).first
        assert FINDS[words] in found.get_attribute("href"), words
    context.close()
    assert not watched.errors
    assert not [url for url in watched.requests if not url.startswith(served)]


def test_a_search_leads_to_the_function_of_an_equation_in_two_clicks(page, site_folder):
    search(page, site_folder.as_uri(), "M 2.94").first.click()
    page.wait_for_url("**/equations.html#*")
    assert page.locator("section:has(> :target) > h3", has_text="(M 2.94)").is_visible()
    page.locator("#m-2-94 a", has_text="bordered").click()
    page.wait_for_url("**/reference/bundle.html#pgm_lab.bundle.dense.bordered")


def test_each_row_of_the_ledger_leads_to_its_proof_and_its_functions(soup):
    rows = soup("verdicts").select("table.verdicts tbody tr")
    assert len(rows) == len(datasets.rows("audit"))
    for row, verdict in zip(rows, all_verdicts(), strict=True):
        targets = {link["href"] for link in row.select("a")}
        page, anchor = sources.place(verdict.row["test"])
        read = verdict.row["test"].startswith("-")
        assert (f"{page}.html#{anchor}" in targets) != read
        assert ("read, not proved" in row.get_text()) == read
        linked = {target.partition("#")[2] for target in targets}
        assert set(verdict.functions) <= linked, verdict.anchor
        assert any(target.startswith("chapters/") for target in targets)
        text = " ".join(row.get_text().split())
        for column in ("place", "printed", "obtained", "verdict", "cause"):
            assert " ".join(verdict.row[column].split()) in text


def test_the_index_names_a_function_or_says_why_not_for_each_equation(soup):
    sections = soup("equations").select("section.equation")
    shown = {section.h3.get_text().rstrip("#"): section for section in sections}
    assert set(shown) == {f"({e})" for v in all_verdicts() for e in v.equations}
    for cited, section in shown.items():
        names = ledger.code(cited.strip("()"))
        linked = {link["href"].partition("#")[2] for link in section.select("a")}
        assert {api.public_name(name) for name in names} <= linked
        assert names or "No function" in section.get_text()


def test_the_counts_are_those_of_the_ledger(soup):
    counts = Counter((r["source"], r["verdict"]) for r in datasets.rows("audit"))
    rows = soup("verdicts").select("table.verdict-counts tbody tr")
    for row in rows:
        numbers = [int(cell.get_text()) for cell in row.select("td")]
        source = row.th.get_text()
        assert numbers[:-1] == [counts[source, verdict] for verdict in ledger.VERDICTS]
        assert numbers[-1] == sum(numbers[:-1])
    assert len(rows) == len(ledger.CITED_AS)


def shown(page) -> int:
    """Rows of the table that are seen; what the page says of their number."""
    number = page.locator("table.verdicts tbody tr:visible").count()
    said = page.locator("[role=status].verdict-number").inner_text()
    assert int(re.match(r"\d+", said)[0]) == number
    return number


def test_the_verdicts_are_filtered_by_clicks_and_words(page, site_folder):
    rows = datasets.rows("audit")
    page.goto((site_folder / "verdicts.html").as_uri())
    assert shown(page) == len(rows)
    wanted = {"source": "Muliawan 2013", "verdict": "corrected"}
    found = [r for r in rows if wanted.items() <= r.items()]
    page.get_by_label(f"{len(found)} corrected, Muliawan 2013").click()
    page.wait_for_url("**?source=Muliawan+2013&verdict=corrected#table")
    assert shown(page) == len(found)
    page.locator("select[name=chapter]").select_option("6")
    assert shown(page) == sum(row["chapter"] == "6" for row in found)
    page.get_by_label("words").press_sequentially("(M 2.94)")
    assert shown(page) == 1
    assert "words=%28M+2.94%29" in page.url
    page.reload()  # the address keeps the choice
    assert shown(page) == 1
    page.get_by_role("button", name="show all").click()
    page.wait_for_function("!location.search")
    assert shown(page) == len(rows)
    page.get_by_label("words").fill("no such word")
    told = page.locator(".verdict-number")
    assert told.inner_text().startswith("No verdict has all of that.")


def test_a_link_to_a_row_shows_it_whatever_is_chosen(page, site_folder):
    verdict = next(v for v in all_verdicts() if v.row["source"] == "Bani 2010")
    address = (site_folder / "verdicts.html").as_uri()
    page.goto(f"{address}?source=Muliawan+2013#{verdict.anchor}")
    assert page.locator(f"[id='{verdict.anchor}']").is_visible()


def test_without_javascript_all_rows_are_there_and_no_idle_control(
    browser, site_folder
):
    context = offline_context(browser, java_script_enabled=False)
    page = context.new_page()
    page.goto((site_folder / "verdicts.html").as_uri())
    number = page.locator("table.verdicts tbody tr:visible").count()
    controls = page.locator(".verdict-controls").is_visible()
    context.close()
    assert (number, controls) == (len(datasets.rows("audit")), False)


def test_the_first_page_has_a_picture_a_sentence_and_a_prediction(page, site_folder):
    page.goto((site_folder / "index.html").as_uri())
    assert page.locator("article img").first.evaluate("image => image.naturalWidth")
    assert page.locator("article p").first.inner_text().endswith(".")
    answer = page.locator(".pgm-predict details p").first
    assert not answer.is_visible()
    page.locator(".pgm-predict summary").first.click()
    assert answer.is_visible()


def test_a_prediction_of_a_chapter_opens_without_a_kernel(page, site_folder):
    page.goto((site_folder / "chapters/07_pearson_registration.html").as_uri())
    choices = page.locator(".pgm-predict").first
    result = choices.locator("xpath=ancestor::*[contains(@class,'cell_output')]//img")
    assert not choices.locator("details p").first.is_visible()
    assert not result.first.is_visible()
    choices.locator("summary").first.click()
    assert choices.locator("details p").first.is_visible()
    assert result.first.is_visible()


def test_the_pages_of_proofs_hold_their_files_to_the_last_line():
    for file in sources.AUDIT.glob("test_*.py"):
        text = file.read_text(encoding="utf-8")
        blocks = sources.blocks(text)
        lines = [line for block in blocks for line in block.lines]
        assert lines == text.splitlines()
        tests = re.findall(r"^def (test_\w+)", text, re.MULTILINE)
        assert [block.name for block in blocks if block.name] == tests
