"""Write the table of the chapters into README: ``python -m pgm_book.make.chapters``."""

import re
import sys
from pathlib import Path

from pgm_book.common import chapters

README = Path(__file__).resolve().parents[2] / "README.md"
BEGIN, END = "<!-- chapters: from data/chapters.csv -->", "<!-- end of chapters -->"


def renewed(text: str) -> str:
    """Return the text of README with the table as data/chapters.csv has it now.

    Raises
    ------
    ValueError
        If the two comments that hold the table are not there.
    """
    table = f"{BEGIN}\n\n{chapters.markdown('notebooks/')}\n\n{END}"
    between = re.compile(f"{re.escape(BEGIN)}.*{re.escape(END)}", re.DOTALL)
    new, number = between.subn(lambda _: table, text)
    if number != 1:
        raise ValueError(f"README.md must hold {BEGIN} and {END} once")
    return new


def main() -> int:
    """Renew README.md."""
    text = renewed(README.read_text(encoding="utf-8"))
    README.write_text(text, encoding="utf-8", newline="\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
