"""The ledger in JupyterLab: a real choice in its menus, and the table that follows."""

import re
import shutil
from pathlib import Path

import pytest

from pgm_book.common import ledger
from tests.publish.test_lab import LOADED, RUN, address, lab

NAME = "A2_verdicts"
__all__ = ["address", "lab"]


@pytest.fixture(scope="module")
def lesson():
    """The notebook; its place tells where the package is."""
    return Path(__file__).resolve().parents[2] / "notebooks" / f"{NAME}.ipynb"


@pytest.fixture(scope="module")
def work(lesson, tmp_path_factory):
    """The folder that the lab opens."""
    folder = tmp_path_factory.mktemp("lab") / "work"
    folder.mkdir()
    shutil.copy(lesson, folder / lesson.name)
    return folder


def test_a_choice_in_the_menus_filters_the_table(lab):
    page = lab(NAME)
    page.get_by_role("menuitem", name="Run", exact=True).click()
    page.get_by_text("Run All Cells", exact=True).click()
    menus = page.locator(".widget-dropdown select")
    panel = page.locator(".jp-WindowedPanel-outer")
    for _ in range(LOADED // 200):
        if menus.count() == 3:
            break
        panel.evaluate("panel => panel.scrollBy(0, 400)")
        page.wait_for_timeout(200)
    area = page.locator(".jp-OutputArea", has=menus.first).first
    table = area.locator("table.pgm-table")
    for menu, value in ((0, "Harintaka 2020"), (2, "not derivable")):
        menus.nth(menu).select_option(label=value)
    rows = ledger.verdicts(source="Harintaka 2020", verdict="not derivable")
    caption = table.locator("caption")
    said = f"{len(rows)} verdicts: Harintaka 2020, not derivable"
    caption.filter(has_text=re.compile(f"^{said}$")).wait_for(timeout=RUN)
    assert table.locator("tbody tr").count() == len(rows)
