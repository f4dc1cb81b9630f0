"""What the pages of the site hold, as Sphinx wrote them."""

from collections import Counter

import nbformat
import pytest
from bs4 import BeautifulSoup

from pgm_book.make.site import api, notebooks
from pgm_book.make.student import slide_type, tags
from pgm_lab import datasets
from tests.publish.conftest import CHAPTERS
from tests.publish.example import code, example, figure_output, text
from tests.publish.test_lesson import predicted


@pytest.fixture(scope="module")
def soup(site_folder):
    pages = {}

    def read(page):
        if page not in pages:
            written = (site_folder / f"{page}.html").read_text(encoding="utf-8")
            pages[page] = BeautifulSoup(written, "html.parser").article
        return pages[page]

    return read


def first_line(cell):
    return cell.source.strip().split("\n")[0]


def test_each_notebook_is_a_page_without_the_lecturers_notes(soup):
    for name, path in CHAPTERS.items():
        words = " ".join(soup(f"chapters/{name}").get_text().split())
        for cell in nbformat.read(path, as_version=4).cells:
            if slide_type(cell) == "notes" and len(cell.source) > 80:
                assert " ".join(first_line(cell)[:60].split()) not in words, cell.id
            if "claims" in tags(cell):
                assert first_line(cell) not in words, cell.id


def test_each_figure_of_a_notebook_is_a_file_with_its_alt_text(soup, site_folder):
    for name, path in CHAPTERS.items():
        told = [
            output.metadata["image/png"]["alt"]
            for cell in nbformat.read(path, as_version=4).cells
            for output in cell.get("outputs", [])
            if "image/png" in output.get("data", {})
            and slide_type(cell) != "notes"
            and "task" not in tags(cell)  # done alone: nothing of it is shown
        ]
        shown = soup(f"chapters/{name}").select("a.pgm-figure img")
        assert [image["alt"] for image in shown] == told
        for image in shown:
            assert (site_folder / "chapters" / image["src"]).is_file()


def test_each_exercise_has_its_solution_folded_below(soup):
    for name, path in CHAPTERS.items():
        cells = nbformat.read(path, as_version=4).cells
        asked = [cell for cell in cells if "BEGIN SOLUTION" in cell.source]
        asked = [cell for cell in asked if "task" not in tags(cell)]
        page = soup(f"chapters/{name}")
        assert len(page.select("details.pgm-solution")) == len(asked)
        assert "SOLUTION" not in page.get_text()


def test_a_solution_and_what_it_prints_stand_only_in_the_fold():
    page, _ = notebooks.prepare(example(), "01_example")
    folded = [cell for cell in page.cells if "One solution" in cell.source]
    others = [cell for cell in page.cells if cell not in folded]
    assert len(folded) == 1
    assert "secret = " in folded[0].source and "[2143.5 1423.5]" in folded[0].source
    assert "secret" not in str(others) and "[2143.5 1423.5]" not in str(others)


def test_what_is_right_below_a_prediction_waits_but_not_a_heading():
    cells = [predicted(), text("The answer."), predicted("1.2")]
    cells.append(text("### What comes next"))
    page, _ = notebooks.prepare(example(*cells), "01_example")
    answer, following = (page.cells[place].source for place in (-3, -1))
    assert 'class="pgm-waits"' in answer and "The answer." in answer
    assert following == "### What comes next"


def test_a_figure_without_alt_text_is_refused():
    cell = code("show_without_words(fig)", figure_output(alt=None))
    with pytest.raises(ValueError, match="show_without_words.*no alternative text"):
        notebooks.prepare(example(cell), "01_example")


def test_each_public_function_and_class_is_in_the_reference(soup):
    names = api.public_names()
    assert len(names) > 200
    for name, page in names.items():
        assert soup(page).find(id=name), name


def test_a_signature_is_as_the_source_writes_it(soup):
    shown = soup("reference/orientation").find(id="pgm_lab.orientation.intersect")
    assert "ArrayLike" in shown.get_text() and "_SupportsArray" not in shown.get_text()


def test_each_term_is_an_entry_in_both_languages_with_its_chapter(soup):
    page = soup("glossary")
    entries = {entry.get_text().rstrip("#") for entry in page.select("dt")}
    rows = datasets.rows("glossary.csv")
    missing = {row[key] for row in rows for key in ("english", "indonesian")} - entries
    assert not missing
    notebook = {row["number"]: row["notebook"] for row in datasets.rows("chapters.csv")}
    wanted = Counter(f"chapters/{notebook[row['chapter']]}.html" for row in rows)
    links = page.select('dd a[href^="chapters/"]')
    assert Counter(link["href"] for link in links) == wanted


def test_the_first_use_of_a_term_in_a_chapter_leads_to_its_entry(soup):
    entries = {entry["id"] for entry in soup("glossary").select("dt[id]")}
    for name in CHAPTERS:
        links = soup(f"chapters/{name}").select("a.pgm-term")
        targets = [link["href"].partition("#")[2] for link in links]
        assert set(targets) <= entries and len(set(targets)) == len(targets)
        assert all(link["title"] for link in links)
    registration = soup("chapters/07_pearson_registration")
    blunder = registration.find("a", class_="pgm-term", string="blunder")
    assert "kesalahan kasar" in blunder["title"]


def test_names_in_the_text_lead_to_the_reference_and_to_chapters(soup):
    page = soup("chapters/07_pearson_registration")
    targets = {link["href"] for link in page.select("a.reference.internal")}
    assert "../reference/registration.html#pgm_lab.registration.fit" in targets
    assert "07_case_fifty_shifts.html" in targets
    network = soup("guides/network").select('a[href^="../reference/bundle.html#"]')
    assert network


def test_the_sample_of_the_guide_lies_beside_it(soup, site_folder):
    files = [link["href"] for link in soup("guides/network").select("a[download]")]
    assert len(files) == 4
    assert all((site_folder / "guides" / file).is_file() for file in files)
