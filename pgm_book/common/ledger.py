"""The ledger of verdicts on published numbers, ``data/audit``: table, figure and index.

A row names chapter, source, place, kind (number, equation, program, statement), what is
printed, what is obtained, the verdict (reproduced, corrected, not derivable), the cause
of a defect (author, scan, unclear), for an equation the functions that implement it,
and the test under ``tests/audit`` that proves the verdict; "-: read, not proved" where
nothing that is printed lets a program decide.
"""

import re
from collections.abc import Collection

import matplotlib.pyplot as plt
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from pgm_lab import datasets, plot

VERDICTS = {
    "reproduced": (plot.BLUE, "white"),
    "corrected": (plot.ORANGE, "black"),
    "not derivable": (plot.GREY, "white"),
}

# How docstrings cite the sources: (M 2.95), (B 2.10), (H 4), (Br 1).
CITED_AS = {
    "Muliawan 2013": "M",
    "Bani 2010": "B",
    "Harintaka 2020": "H",
    "Brahmantara 2015": "Br",
}


def verdicts(
    chapter: str | None = None,
    places: Collection[str] | None = None,
    *,
    source: str | None = None,
    verdict: str | None = None,
) -> list[dict[str, str]]:
    """Rows of the ledger, all of them or those of a chapter, a source, a verdict.

    Parameters
    ----------
    chapter, source, verdict : str, optional
        For example "1" or "A1", "Bani 2010", "not derivable".
    places : collection of str, optional
        Places as written in the ledger.

    Raises
    ------
    ValueError
        If the ledger has no such chapter, source or verdict, or a place does not occur
        in the rows of the others. A chapter may have no rows of a source: then the list
        is empty.

    Examples
    --------
    >>> verdicts("1", places=["Metode, GSD"])[0]["verdict"]
    'corrected'
    """
    found = datasets.rows("audit")
    if chapter is not None and chapter not in {row["chapter"] for row in found}:
        raise ValueError(f"the ledger has no verdicts of chapter {chapter!r}")
    if source not in (None, *CITED_AS):
        raise ValueError(f"source must be one of {', '.join(CITED_AS)}; got {source!r}")
    if verdict not in (None, *VERDICTS):
        raise ValueError(
            f"verdict must be one of {', '.join(VERDICTS)}; got {verdict!r}"
        )
    wanted = {"chapter": chapter, "source": source, "verdict": verdict}
    for column, value in wanted.items():
        found = [row for row in found if value in (None, row[column])]
    if places is None:
        return found
    if missing := set(places) - {row["place"] for row in found}:
        names = ", ".join(sorted(missing))
        raise ValueError(f"the ledger has no such place: {names} (in `places`)")
    return [row for row in found if row["place"] in places]


def code(equation: str) -> list[str]:
    """Name the functions behind an equation of a source; none if it is not used.

    Parameters
    ----------
    equation : str
        As docstrings cite it: "M 2.95" of Muliawan 2013, "B 2.6a" of Bani 2010 ("B 5"
        of its appendix B), "H 4" of Harintaka 2020, "Br 1" of Brahmantara 2015.

    Raises
    ------
    ValueError
        If the ledger does not have that equation.

    Examples
    --------
    >>> code("M 2.38")
    ['pgm_lab.orientation.coplanarity.by_image']
    """
    rows = [row for row in verdicts() if equation in equations(row)]
    if not rows:
        raise ValueError(
            f"the ledger has no equation {equation!r}. Write it as docstrings do:"
            " 'M 2.95', 'B 2.6a', 'H 4' or 'Br 1'"
        )
    named = (name for row in rows for name in row["code"].split("; "))
    return list(dict.fromkeys(name for name in named if not name.startswith("-")))


def equations(row: dict[str, str]) -> list[str]:
    """Equations that a row of the ledger is about, as docstrings cite them.

    Examples
    --------
    >>> equations(verdicts("5", places=["(2.41), (2.42)"])[0])
    ['M 2.41', 'M 2.42']
    """
    if row["kind"] != "equation":
        return []
    numbers: list[str] = []
    for first, last in re.findall(r"\((\d[\w.]*)\)(?: to \((.*?)\))?", row["place"]):
        numbers += _up_to(first, last) if last else [first]
    numbers = numbers or [row["place"].partition(",")[0]]  # "Table 2.2, columns"
    return [f"{CITED_AS[row['source']]} {number}" for number in numbers]


def _up_to(first: str, last: str) -> list[str]:
    """All numbers of equations from "2.38" to "2.40"."""
    chapter = first[: first.rfind(".") + 1]
    start, stop = int(first.removeprefix(chapter)), int(last.removeprefix(chapter))
    return [f"{chapter}{number}" for number in range(start, stop + 1)]


def table(rows: list[dict[str, str]], caption: str, causes: bool = False) -> None:
    """Show verdicts as a table, with the causes of corrections in a last column."""
    header = ["source", "printed", "what we get", "verdict"] + ["cause"] * causes
    columns = ["printed", "obtained", "verdict"] + ["cause"] * causes
    cells = [
        [f"{row['source']}, {row['place']}", *(row[name] for name in columns)]
        for row in rows
    ]
    for cell, row in zip(cells, rows):
        if row["test"].startswith("-"):
            cell[2] += " (Read, not proved.)"
    plot.table(header, cells, caption)


def explore() -> None:
    """Show the ledger as a table that three menus filter: source, chapter, verdict.

    In a page that does not run, the table contains the whole ledger.
    """
    import ipywidgets

    chapters = dict.fromkeys(row["chapter"] for row in verdicts())
    menus = {"source": _by_year(verdicts()), "chapter": chapters, "verdict": VERDICTS}

    def draw(**chosen: str | None) -> None:
        found = verdicts(**chosen)
        named = ", ".join(
            f"chapter {value}" if name == "chapter" else value
            for name, value in chosen.items()
            if value
        )
        count = f"{len(found)} verdict{'s' * (len(found) != 1)}"
        table(found, f"{count}: {named or 'the whole ledger'}", causes=True)

    plot.interact(
        draw,
        **{
            name: ipywidgets.Dropdown(
                options=[("all", None), *zip(values, values)],
                value=None,
                description=name,
            )
            for name, values in menus.items()
        },
    )


def figure(rows: list[dict[str, str]]) -> Figure:
    """Draw how many verdicts of each kind each source has; `summary` describes it."""
    sources = _by_year(rows)[::-1]
    fig, ax = plt.subplots(figsize=(10, 3.2))
    left = [0] * len(sources)
    for verdict, (colour, ink) in VERDICTS.items():
        count = [_count(rows, source, verdict) for source in sources]
        bars = ax.barh(sources, count, left=left, color=colour, label=verdict)
        numbers = [str(n) if n else "" for n in count]
        ax.bar_label(bars, numbers, label_type="center", color=ink, weight="bold")
        left = [a + b for a, b in zip(left, count)]
    ax.set_axisbelow(True)
    ax.set(xlabel="number of verdicts")
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.grid(axis="y", visible=False)
    ax.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    return fig


def summary(rows: list[dict[str, str]]) -> str:
    """Describe in words what `figure` shows.

    Examples
    --------
    >>> summary(verdicts("1", places=["Metode, GSD"]))
    'Harintaka 2020: 0 reproduced, 1 corrected, 0 not derivable.'
    """
    lines = []
    for source in _by_year(rows):
        counts = (f"{_count(rows, source, verdict)} {verdict}" for verdict in VERDICTS)
        lines.append(f"{source}: {', '.join(counts)}")
    return "; ".join(lines) + "."


def _by_year(rows: list[dict[str, str]]) -> list[str]:
    return sorted({row["source"] for row in rows}, key=lambda source: source[-4:])


def _count(rows: list[dict[str, str]], source: str, verdict: str) -> int:
    return sum(row["source"] == source and row["verdict"] == verdict for row in rows)
