"""The ledger as table, figure and index: nothing is lost or counted twice."""

import matplotlib.pyplot as plt
import pytest

from pgm_book.common import ledger
from pgm_lab import datasets, plot

ROWS = datasets.rows("audit")


def test_every_row_belongs_to_exactly_one_chapter():
    chapters = {row["chapter"] for row in ROWS}
    found = [row for chapter in chapters for row in ledger.verdicts(chapter)]
    assert len(found) == len(ROWS) == len(ledger.verdicts())


@pytest.mark.parametrize(
    ("unknown", "message"),
    [
        ({"chapter": "99"}, "no verdicts of chapter '99'"),
        ({"places": ["(2.5b)", "Table 99"]}, "no such place: Table 99"),
        ({"verdict": "wrong"}, "verdict must be one of"),
        ({"source": "Bani"}, "source must be one of"),
    ],
)
def test_what_the_ledger_does_not_have_is_named(unknown, message):
    with pytest.raises(ValueError, match=message):
        ledger.verdicts(**unknown)


def test_rows_are_those_of_source_and_verdict():
    found = ledger.verdicts(source="Bani 2010", verdict="not derivable")
    wanted = [
        row
        for row in ROWS
        if (row["source"], row["verdict"]) == ("Bani 2010", "not derivable")
    ]
    assert found == wanted and found
    assert ledger.verdicts("7", source="Bani 2010") == []


def test_sources_are_told_from_the_oldest_to_the_newest():
    told = [part.split(": ")[0] for part in ledger.summary(ROWS).split("; ")]
    years = [source.split()[-1] for source in told]
    assert years == sorted(years) and told != sorted(told)


def test_three_menus_filter_the_table(monkeypatch):
    given, shown = {}, []
    take = lambda draw, **menus: given.update(menus, draw=draw)  # noqa: E731
    monkeypatch.setattr(plot, "interact", take)
    monkeypatch.setattr(plot.basic, "publish_display_data", shown.append)
    ledger.explore()
    draw = given.pop("draw")
    draw(**{name: menu.value for name, menu in given.items()})
    plain = shown[-1]["text/plain"]
    assert plain.startswith(f"{len(ROWS)} verdicts: the whole ledger\n")
    for name, menu in given.items():
        values = {value for _, value in menu.options if value}
        assert values == {row[name] for row in ROWS}
    draw(source="Bani 2010", chapter="8", verdict="corrected")
    said = shown[-1]["text/plain"]
    assert "Bani 2010, chapter 8, corrected\n" in said
    draw(source="Bani 2010", chapter="7", verdict=None)
    assert shown[-1]["text/plain"].startswith("0 verdicts: Bani 2010, chapter 7")


def test_code_behind_an_equation_is_found_by_one_look():
    assert ledger.code("M 2.16") == [
        "pgm_lab.frames.pixel_to_photo",
        "pgm_lab.frames.image_centre",
    ]
    assert ledger.code("H 4") == ["pgm_lab.orientation.scale_factors"]
    # Two rows judge it, and the second is a misprint only
    assert ledger.code("M 2.23") == ["pgm_lab.camera.collinearity"]
    with pytest.raises(ValueError, match="no equation 'M 9.99'"):
        ledger.code("M 9.99")


@pytest.mark.parametrize(
    ("source", "place", "expected"),
    [
        ("Muliawan 2013", "(2.38) to (2.40)", ["M 2.38", "M 2.39", "M 2.40"]),
        ("Harintaka 2020", "(3) to (5)", ["H 3", "H 4", "H 5"]),
        ("Bani 2010", "Appendix B, (5a), (5b)", ["B 5a", "B 5b"]),
        ("Bani 2010", "Table 2.2, columns", ["B Table 2.2"]),
        ("Muliawan 2013", "(2.24), b11, b14 to b16", ["M 2.24"]),
    ],
)
def test_place_in_a_source_names_its_equations(source, place, expected):
    row = {"source": source, "place": place, "kind": "equation"}
    assert ledger.equations(row) == expected
    assert ledger.equations(row | {"kind": "statement"}) == []


def test_figure_shows_every_verdict_once():
    fig = ledger.figure(ROWS)
    width = sum(bar.get_width() for bar in fig.axes[0].patches)
    plt.close(fig)
    assert width == len(ROWS)


def test_summary_counts_what_the_figure_shows():
    words = ledger.summary(ROWS)
    numbers = [int(word) for word in words.replace(":", "").split() if word.isdigit()]
    years = [int(source[-4:]) for source in {row["source"] for row in ROWS}]
    assert sum(numbers) - sum(years) == len(ROWS)


@pytest.mark.parametrize("causes", [False, True])
def test_table_shows_what_is_printed_beside_what_we_get(monkeypatch, causes):
    shown = []
    monkeypatch.setattr(plot.basic, "publish_display_data", shown.append)
    rows = ledger.verdicts("1", places=["Metode, GSD"])
    ledger.table([*rows, rows[0] | {"test": "-: read, not proved"}], "GSD", causes)
    page = shown[0]["text/html"]
    assert ">20 cm<" in page and "22.9 cm" in page
    assert page.count("(Read, not proved.)") == 1
    assert (">unclear</td>" in page) == causes
