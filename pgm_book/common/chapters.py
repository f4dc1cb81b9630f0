"""The chapters of the workbook as ``data/chapters.csv`` lists them: README's table."""

from pgm_lab import datasets
from pgm_lab.plot.basic import publish_display_data

HEADER = ("no.", "chapter", "asks", "sources", "minutes")


def table() -> None:
    """Show the table of the chapters, with links to their notebooks."""
    lines = [f"{row['number']:2}  {row['question']}" for row in _ready()]
    publish_display_data(
        {"text/markdown": markdown(), "text/plain": "\n".join([*lines, to_come()])}
    )


def markdown(folder: str = "") -> str:
    """Write the table of the ready chapters in Markdown, and name those to come.

    `folder` is where the notebooks lie, seen from the text, with a slash at its end.

    Examples
    --------
    >>> print(markdown("notebooks/").splitlines()[2])
    | 0 | [Start here](notebooks/00_start_here.ipynb) | How ... work? | all four | 15 |
    """
    lines = [HEADER, ["---"] * len(HEADER)]
    for row in _ready():
        title = f"[{row['title']}]({folder}{row['notebook']}.ipynb)"
        title += f", {row['with']}" if row["with"] else ""
        rest = row["question"], row["sources"], row["minutes"]
        lines.append([row["number"], title, *rest])
    written = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    return f"{written}\n\n{to_come()}".rstrip()


def to_come() -> str:
    """Name the chapters that have no notebook yet; nothing when all have one."""
    names = [
        f"{row['number']} {row['title']}"
        for row in datasets.rows("chapters.csv")
        if not row["notebook"]
    ]
    return f"To come: {', '.join(names)}." if names else ""


def _ready() -> list[dict[str, str]]:
    return [row for row in datasets.rows("chapters.csv") if row["notebook"]]
