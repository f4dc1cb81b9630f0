"""Draw the map of the house: the rooms of pgm_lab and who calls whom, from the imports.

`python tasks.py house` writes docs/house.svg and prints the size of each room. A room
is a module or a package directly in pgm_lab; it stands one floor above the highest
room that it imports from, so that every line goes down. In it stand its public modules.
Command lines (`__main__`) are doors, not rooms: they may import from above.
"""

import ast
import functools
import sys
import textwrap
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from xml.sax.saxutils import escape

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "pgm_lab"
MAP = ROOT / "docs" / "house.svg"

WIDTH, HEIGHT = 176, 112  # of a room, in the drawing's units
ACROSS, UP = 34, 84  # between two rooms, between two floors
MARGIN = 30

STYLE = """\
text { font: 17px sans-serif; text-anchor: middle; fill: #1d1d1f; }
text.modules { font-size: 12px; fill: #55555b; }
rect { fill: #eef1f5; stroke: #0072B2; stroke-width: 1.6; }
rect.paper { fill: #ffffff; stroke: none; }
path { fill: none; stroke: #6B6B6B; stroke-width: 1.3; }
"""


def imports(package: Path = PACKAGE) -> dict[str, set[str]]:
    """Return the modules of each module's imports, names relative to the package."""
    modules = {name_of(path, package): path for path in sorted(package.rglob("*.py"))}
    found = {}
    for module, path in modules.items():
        if not module or module.endswith("__main__"):
            continue
        found[module] = set()
        for node in imported(path.read_text(encoding="utf-8")):
            first, _, within = node.module.partition(".")
            if first == package.name:
                names = [f"{within}.{a.name}".lstrip(".") for a in node.names]
                found[module] |= {n if n in modules else within for n in names}
        found[module] -= {module, ""}
    return found


@functools.cache
def imported(text: str) -> list[ast.ImportFrom]:
    """Return what a module imports from others, of each text once."""
    nodes = executed(ast.parse(text))
    return [n for n in nodes if isinstance(n, ast.ImportFrom) and n.module is not None]


def executed(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all nodes but those that only a type checker reads."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            continue
        yield node
        yield from executed(node)


def name_of(path: Path, package: Path) -> str:
    """Dotted name of a module below the package; a package has that of its folder."""
    parts = path.relative_to(package).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def rooms(package: Path = PACKAGE) -> dict[str, set[str]]:
    """Return the rooms, and from which others each imports."""
    found: dict[str, set[str]] = {}
    for module, targets in imports(package).items():
        room = module.partition(".")[0]
        others = {target.partition(".")[0] for target in targets} - {room}
        found[room] = found.get(room, set()) | others
    return found


def floors(graph: dict[str, set[str]]) -> list[list[str]]:
    """Return the names floor by floor, from the ground up.

    Raises
    ------
    graphlib.CycleError
        If two of them need each other, directly or through others.
    """
    floor: dict[str, int] = {}
    for name in TopologicalSorter(graph).static_order():
        floor[name] = max(
            (floor[below] + 1 for below in graph.get(name, ())), default=0
        )
    levels: list[list[str]] = [[] for _ in range(max(floor.values(), default=-1) + 1)]
    for name in sorted(floor):
        levels[floor[name]].append(name)
    return levels


def direct(graph: dict[str, set[str]]) -> dict[str, set[str]]:
    """Leave out imports that lead through another room too: the drawing stays clear."""
    reach = {}
    for name in TopologicalSorter(graph).static_order():
        below = graph.get(name, set())
        reach[name] = below.union(*(reach[one] for one in below))
    return {
        name: {b for b in below if not any(b in reach[o] for o in below - {b})}
        for name, below in graph.items()
    }


def lines(package: Path = PACKAGE) -> dict[str, int]:
    """Return how many lines of code, comment and docstring each room has."""
    count: dict[str, int] = {}
    for path in package.rglob("*.py"):
        room = name_of(path, package).partition(".")[0]
        if room:
            text = path.read_text(encoding="utf-8")
            count[room] = count.get(room, 0) + text.count("\n")
    return count


def public(package: Path = PACKAGE) -> dict[str, list[str]]:
    """Return the public modules of each room that is a package."""
    found: dict[str, list[str]] = {}
    for module in imports(package):
        room, _, inside = module.partition(".")
        shown = [inside] if inside and not inside.startswith("_") else []
        found[room] = found.get(room, []) + shown
    return found


def ordered(levels: list[list[str]], graph: dict[str, set[str]]) -> list[list[str]]:
    """Put each room of a floor near the rooms below it that it calls."""
    place: dict[str, float] = {}
    result = []
    for level in levels:

        def pull(name: str) -> float:
            below = [place[one] for one in graph.get(name, ())]
            return sum(below) / len(below) if below else 0.0

        row = sorted(level, key=lambda name: (pull(name), name))
        for k, name in enumerate(row):
            place[name] = k - (len(row) - 1) / 2
        result.append(row)
    return result


def drawing(package: Path = PACKAGE) -> str:
    """Return the map as SVG text: the ground floor below, a line for each import."""
    graph = rooms(package)
    below = direct(graph)
    levels = ordered(floors(graph), below)
    wide = max(map(len, levels)) * (WIDTH + ACROSS) + 2 * MARGIN
    high = len(levels) * (HEIGHT + UP) - UP + 2 * MARGIN
    centre = {
        name: (
            wide / 2 + (k - (len(row) - 1) / 2) * (WIDTH + ACROSS),
            high - MARGIN - HEIGHT / 2 - floor * (HEIGHT + UP),
        )
        for floor, row in enumerate(levels)
        for k, name in enumerate(row)
    }
    page = f'viewBox="0 0 {wide} {high}" role="img"'
    title = f"The {len(graph)} rooms of pgm_lab; each line is an import, downwards"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {page}>',
        f"<title>{title}</title>",
        f"<style>{STYLE}</style>",
        f'<rect class="paper" width="{wide}" height="{high}"/>',
    ]
    rows = [[centre[name] for name in row] for row in levels]
    modules = public(package)
    for name, targets in sorted(below.items()):
        for target in sorted(targets):
            parts.append(f'<path d="{curve(centre[name], centre[target], rows)}"/>')
    for name, (x, y) in sorted(centre.items()):
        box = f'x="{x - WIDTH / 2:g}" y="{y - HEIGHT / 2:g}" rx="6"'
        parts.append(f'<rect {box} width="{WIDTH}" height="{HEIGHT}"/>')
        parts.append(f'<text x="{x:g}" y="{y - 34:g}">{escape(name)}</text>')
        for k, words in enumerate(textwrap.wrap(" ".join(modules[name]), 27)):
            place = f'x="{x:g}" y="{y - 14 + 15 * k:g}"'
            parts.append(f'<text class="modules" {place}>{escape(words)}</text>')
    return "\n".join([*parts, "</svg>", ""])


def curve(start: tuple, end: tuple, rows: list[list[tuple]]) -> str:
    """Return a path from room to room, between the rooms of the floors it crosses."""
    places = [start]
    for row in reversed(rows):
        if start[1] < row[0][1] < end[1]:
            straight = (places[-1][0] + end[0]) / 2
            step = (WIDTH + ACROSS) / 2
            gaps = [x + side * step for x, _ in row for side in (-1, 1)]
            places.append((min(gaps, key=lambda x: abs(x - straight)), row[0][1]))
    places.append(end)
    text = ""
    for (x, y), (u, v) in zip(places, places[1:]):
        y, v = y + HEIGHT / 2, v - HEIGHT / 2
        text += f"{'L' if text else 'M'}{x:g} {y:g}"
        text += f"C{x:g} {y + UP / 2:g} {u:g} {v - UP / 2:g} {u:g} {v:g}"
    return text


def main() -> int:
    """Write the map; say how large the house is, or which rooms form a circle."""
    try:
        modules, text = floors(imports()), drawing()
    except CycleError as error:
        print("a circle of imports:", " -> ".join(error.args[1]), file=sys.stderr)
        return 1
    MAP.write_text(text, encoding="utf-8", newline="\n")
    count, levels = lines(), floors(rooms())
    for floor, row in reversed(list(enumerate(levels))):
        print(f"{floor}  " + ", ".join(f"{name} {count[name]}" for name in row))
    print(f"{len(count)} rooms on {len(levels)} floors, {sum(count.values())} lines,")
    print(f"{sum(map(len, modules))} modules on {len(modules)} floors, no circle")
    return 0


if __name__ == "__main__":
    sys.exit(main())
