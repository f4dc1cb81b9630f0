"""A prediction is one page of choices, the same in every run."""

import re

import pytest

from pgm_book.common import checks
from pgm_book.common import predict as _predict


@pytest.fixture
def shown(monkeypatch):
    """A function that returns what a prediction shows."""
    seen = []
    monkeypatch.setattr(_predict, "publish_display_data", seen.append)

    def show(number):
        checks.predict(number)
        return seen.pop()

    return show


def test_each_choice_is_closed_and_has_its_sentence(shown):
    page = shown("2.1")["text/html"]
    rows = _predict.choices_of("2.1")
    found = re.findall(r"<details (.*?)><summary>(.*?)</summary><p>(.*?)</p>", page)
    assert [choice for _, choice, _ in found] == [row["choice"] for row in rows]
    assert {attributes for attributes, _, _ in found} == {'name="predict-2.1"'}
    for row, (_, _, sentence) in zip(rows, found):
        mark = "✓" if row["right"] == "yes" else "✗"
        assert sentence == f"{mark} {row['feedback']}"


def test_where_there_is_no_page_the_feedback_is_not_told(shown):
    plain = shown("2.1")["text/plain"]
    assert "0.6: the gain stays" in plain and "contrast" not in plain


def test_a_viewer_that_hides_nothing_is_told(shown):
    """Without the style the line is there; with it, only where nothing waits."""
    page = shown("2.1")["text/html"]
    style = re.search("<style>.*</style>", page, re.DOTALL)[0]
    assert _predict.SHOWN in page.replace(style, "")
    for shown_in, waits in (
        (".jp-OutputArea", ".jp-OutputArea-child"),
        (".cell", ".html"),
    ):
        assert f"{waits}:has(.pgm-predict):not(:has(.pgm-predict [open]))" in style
        assert f"{shown_in} .pgm-shown" in style


def test_signs_of_html_in_a_choice_are_shown_as_they_are():
    row = {"choice": "x < 1 & $a > b$", "right": "no", "feedback": '"a" <b>'}
    page = _predict.page("9.1", [row])
    assert "<summary>x &lt; 1 &amp; $a &gt; b$</summary>" in page
    assert '✗ "a" &lt;b&gt;</p>' in page


@pytest.mark.parametrize("number", ["99.1", "2", "2.10"])
def test_an_unknown_number_is_named(number):
    with pytest.raises(ValueError, match=f"number: there is no prediction {number} in"):
        checks.predict(number)
