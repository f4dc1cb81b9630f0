"""Print the table: ``python -m pgm_book.common.real_pairs FOLDER [ROW ...]``."""

import argparse
import sys
import time
from pathlib import Path

from pgm_book.common.real_pairs.pairs import SOURCES, fetch, find
from pgm_book.common.real_pairs.rows import ROWS


def main(arguments: list[str]) -> int:
    """Measure the rows that were asked for, or all."""
    parser = argparse.ArgumentParser(prog="python -m pgm_book.common.real_pairs")
    parser.add_argument("folder", type=Path)
    parser.add_argument("rows", nargs="*", metavar="ROW", help=", ".join(ROWS))
    parser.add_argument("--fetch", action="store_true", help="get missing files first")
    given = parser.parse_args(arguments)
    unknown = [name for name in given.rows if name not in ROWS]
    if unknown:
        parser.error(f"no such row: {', '.join(unknown)}; there are {', '.join(ROWS)}")
    if given.fetch:
        fetch(given.folder)
    for source in SOURCES:
        missing = [name for name in source.files if find(given.folder, name) is None]
        state = f"missing: {', '.join(missing)}" if missing else source.licence
        print(f"{source.name:10} {source.origin}; {state}")
    for name in given.rows or ROWS:
        start = time.perf_counter()
        for what, pair, figures in ROWS[name](given.folder):
            print(f"{what:22} | {pair:38} | {figures}", flush=True)
        print(f"{'':22} ({time.perf_counter() - start:.0f} s)")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
