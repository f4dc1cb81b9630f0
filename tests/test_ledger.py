"""The ledger as table and figure: nothing is lost or counted twice."""

import matplotlib.pyplot as plt
import pytest

from pgm_lab import datasets, ledger, plot

ROWS = datasets.rows("audit.csv")


def test_every_row_belongs_to_exactly_one_chapter():
    chapters = {row["chapter"] for row in ROWS}
    found = [row for chapter in chapters for row in ledger.verdicts(chapter)]
    assert len(found) == len(ROWS) == len(ledger.verdicts())


def test_unknown_chapter_and_place_are_named():
    with pytest.raises(ValueError, match="no verdicts of chapter '99'"):
        ledger.verdicts("99")
    with pytest.raises(ValueError, match="no such place: Table 99"):
        ledger.verdicts("1", places=["(2.5b)", "Table 99"])


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


def test_table_shows_what_is_printed_beside_what_we_get(monkeypatch):
    shown = []
    monkeypatch.setattr(plot.basic, "publish_display_data", shown.append)
    ledger.table(ledger.verdicts("1", places=["Metode, GSD"]), "GSD")
    assert ">20 cm<" in shown[0]["text/html"] and "22.9 cm" in shown[0]["text/html"]
    assert "unclear" not in shown[0]["text/html"]


def test_table_shows_the_causes_when_asked(monkeypatch):
    shown = []
    monkeypatch.setattr(plot.basic, "publish_display_data", shown.append)
    ledger.table(ledger.verdicts("1", places=["Metode, GSD"]), "GSD", causes=True)
    assert '<td class="text">unclear</td>' in shown[0]["text/html"]
