"""The equation index: from (M 2.94) to the function that computes it and its proof."""

import inspect
import re
from collections import defaultdict
from pathlib import Path

from pgm_book.common import ledger
from pgm_book.make.site import api, sources
from pgm_book.make.site.verdicts import Verdict, all_verdicts

PAGE = "equations"

TEXT = """\
:html_theme.sidebar_secondary.remove: true

The equation index
==================

From the number of an equation to the function that implements it. Docstrings cite in
the same way: (M 2.94) is equation (2.94) of Muliawan 2013, (B 2.10) of Bani 2010, (H 4)
of Harintaka 2020, (Br 2) of Brahmantara 2015; (B 5) is (5) in the appendix B of Bani
2010. The search finds them too, as does ``pgm_book.common.ledger.code("M 2.94")``.
"""


def write(folder: Path) -> list[str]:
    """Write the equation index."""
    parts = [TEXT]
    for source, found in by_source().items():
        parts.append(sources.heading(source, "-") + "\n")
        for cited in sorted(found, key=order):
            parts.append(entry(cited, found[cited]))
    (folder / f"{PAGE}.rst").write_text("\n".join(parts), encoding="utf-8")
    return [PAGE]


def by_source() -> dict[str, dict[str, list[Verdict]]]:
    """The verdicts on each equation of each source."""
    found: dict[str, dict[str, list[Verdict]]] = {
        source: defaultdict(list) for source in ledger.CITED_AS
    }
    for verdict in all_verdicts():
        for cited in verdict.equations:
            found[verdict.row["source"]][cited].append(verdict)
    return found


def order(cited: str) -> list[tuple[int, str]]:
    """A key that puts "M 2.9" before "M 2.10" and "B 2.14a" before "B 2.14b".

    Examples
    --------
    >>> sorted(["B 2.14b", "B 2.9", "B 2.14a"], key=order)
    ['B 2.9', 'B 2.14a', 'B 2.14b']
    """
    parts = re.findall(r"(\d*)(\D*)", cited.partition(" ")[2])
    return [(int(number or 10**6), text) for number, text in parts if number or text]


def entry(cited: str, verdicts: list[Verdict]) -> str:
    """One equation: its functions with what they do, its verdicts with their proofs."""
    title = f"({cited})"
    number = cited.partition(" ")[2]
    # What the search finds first, with the letter of the source or without it.
    lines = [f".. index:: ! {title}, ! ({number})", "", ".. rst-class:: equation", ""]
    lines.append(sources.heading(title, "~") + "\n")  # its anchor is m-2-94
    functions = dict.fromkeys(name for v in verdicts for name in v.functions)
    for name in functions:
        lines.append(f"- :py:obj:`{name}`: {_plain(does(name))}")
    if not functions:
        notes = "; ".join(dict.fromkeys(verdict.note for verdict in verdicts))
        lines.append(f"- No function: {notes}.")
    for verdict in verdicts:
        page, anchor = sources.place(verdict.row["test"])
        lines.append(
            f"- {verdict.mark} {verdict.row['verdict']}:"
            f" `{_plain(verdict.row['place'])} <verdicts.html#{verdict.anchor}>`__,"
            f" `its proof <{page}.html#{anchor}>`__"
        )
    return "\n".join([*lines, ""])


def does(name: str) -> str:
    """First line of a function's docstring."""
    text = inspect.getdoc(api.thing(name)) or ""
    return text.partition("\n\n")[0].replace("\n", " ").replace("`", "")


def _plain(text: str) -> str:
    """Text in which reStructuredText sees no markup."""
    return re.sub(r"([\\`*_<>|])", r"\\\1", text)
