"""Draw the map of the house, and name the imports that break its rules.

`python tasks.py house` writes docs/house.svg and prints the size of each room. A room
is a module or a package directly in pgm_lab or pgm_book; in pgm_lab it is one floor
above the highest room that it imports from, so that every line goes down. Command lines
(`__main__`) are doors, not rooms: they may import from above.
"""

import ast
import functools
import re
import sys
import textwrap
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import NamedTuple
from xml.sax.saxutils import escape

ROOT = Path(__file__).resolve().parents[2]
MAP = ROOT / "docs" / "house.svg"
LIBRARY, BOOK = "pgm_lab", "pgm_book"

Graph = dict[str, set[str]]


class Import(NamedTuple):
    """An import of a module, of any form and anywhere in a file."""

    file: str
    line: int
    importer: str
    imported: str  # a module of ours, or the name of a package from elsewhere


# --- Imports ---


@functools.cache
def imports(root: Path = ROOT) -> list[Import]:
    """Return all imports in both packages but those of type checkers and doors."""
    paths = sorted([*root.glob("pgm_*/**/*.py")])
    modules = {module_of(path, root): path for path in paths if is_source(path)}
    found = []
    for module, path in modules.items():
        tree = ast.parse(path.read_text(encoding="utf-8"))
        package = module if path.stem == "__init__" else module.rpartition(".")[0]
        for node in executed(tree):
            for name in imported(node, package):
                while name.partition(".")[0] in (LIBRARY, BOOK) and name not in modules:
                    name = name.rpartition(".")[0]  # a function of a module
                if name != module:
                    file = path.relative_to(root).as_posix()
                    found.append(Import(file, node.lineno, module, name))
    return found


def is_source(path: Path) -> bool:
    """Whether a file is a module; templates are not, and doors open everywhere."""
    return "templates" not in path.parts and path.stem != "__main__"


def module_of(path: Path, root: Path = ROOT) -> str:
    """Return the dotted name of a module; a package has that of its folder."""
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def executed(tree: ast.AST) -> Iterator[ast.AST]:
    """Yield all nodes but those that only a type checker reads."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and getattr(node.test, "id", "") == "TYPE_CHECKING":
            continue
        yield node
        yield from executed(node)


def imported(node: ast.AST, package: str) -> list[str]:
    """Return the full names that a node imports."""
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        base = node.module or ""
        if node.level:
            above = package.split(".")[: len(package.split(".")) - node.level + 1]
            base = ".".join([*above, *([base] if base else [])])
        return [f"{base}.{alias.name}" for alias in node.names]
    return []


# --- Rules ---

# What shows a result to a user; nothing else in the library draws.
SHOWS = {"plot", "report", "stereo_map"}
DRAWING = {"matplotlib", "mpl_toolkits", "ipympl", "ipywidgets", "IPython"}


def broken(found: list[Import]) -> dict[str, list[str]]:
    """Return what breaks each rule: the line, and what to do."""
    rules: dict[str, list[str]] = {"book": [], "lessons": [], "drawing": []}
    for one in found:
        here, there = one.importer.split("."), one.imported.split(".")
        place = f"{one.file}:{one.line} imports {one.imported}"
        if here[0] == LIBRARY and there[0] == BOOK:
            do = "move what it needs into pgm_lab, or this module into pgm_book"
            rules["book"].append(f"{place}: {do}")
        lessons = is_lesson(here) and is_lesson(there)
        if lessons and here[1] != there[1]:
            do = "what two lessons share belongs in pgm_book/common, or in pgm_lab"
            rules["lessons"].append(f"{place}: {do}")
        if here[0] == LIBRARY and here[1:2] and here[1] not in SHOWS:
            if there[0] in DRAWING:
                do = "only plot, report and stereo_map draw; return values instead"
                rules["drawing"].append(f"{place}: {do}")
    return rules | {"circles": circle(found)}


def is_lesson(parts: list[str]) -> bool:
    """Whether a name is in the folder of a lesson, pgm_book.ch07 or chA1."""
    return parts[0] == BOOK and bool(re.fullmatch(r"ch(\d\d|A\d)", (parts + [""])[1]))


def circle(found: list[Import]) -> list[str]:
    """Return the imports of a circle of modules or rooms, if there is one."""
    for names in (str, room_of):
        graph = graph_of(found, names)
        try:
            TopologicalSorter(graph).prepare()
        except CycleError as error:
            steps = list(zip(error.args[1][1:], error.args[1]))  # importer, imported
            do = "break the circle here: move what both need below them"
            return [
                f"{one.file}:{one.line} imports {one.imported}: {do}"
                for step in steps
                for one in found
                if (names(one.importer), names(one.imported)) == step
            ]
    return []


def room_of(module: str) -> str:
    """Return the room of a module: ncc._match is in pgm_lab.ncc."""
    return ".".join(module.split(".")[:2])


def graph_of(found: list[Import], names=str) -> Graph:
    """Return who imports whom, of our modules or of their rooms."""
    graph: Graph = {}
    for one in found:
        graph.setdefault(names(one.importer), set())
        if one.imported.partition(".")[0] in (LIBRARY, BOOK):
            graph[names(one.importer)].add(names(one.imported))
    tops = {LIBRARY, BOOK}
    return {name: below - {name} - tops for name, below in graph.items()}


# --- The map ---

ACROSS, UP, MARGIN = 26, 70, 30  # between rooms, between floors, around all
STYLE = """\
text { font: 17px sans-serif; text-anchor: middle; fill: #1d1d1f; }
text.modules { font-size: 12px; fill: #55555b; }
text.package { font-size: 22px; text-anchor: start; }
rect { fill: #eef1f5; stroke: #0072B2; stroke-width: 1.6; }
rect.lesson { fill: #fdf3e1; stroke: #a86400; }
rect.paper { fill: #ffffff; stroke: none; }
path { fill: none; stroke: #6B6B6B; stroke-width: 1.3; }
"""


class Box(NamedTuple):
    """A room on the map: its middle and size, and what is written in it."""

    x: float
    y: float
    wide: float
    high: float
    name: str
    words: list[str]


def sizes(root: Path = ROOT) -> dict[str, int]:
    """Return how many lines of Python each room has."""
    count: dict[str, int] = {}
    for path in sorted(root.glob("pgm_*/**/*.py")):
        room = room_of(module_of(path, root))
        if room not in (LIBRARY, BOOK):
            lines = path.read_text(encoding="utf-8").count("\n")
            count[room] = count.get(room, 0) + lines
    return count


def floors(graph: Graph) -> list[list[str]]:
    """Return the names floor by floor, from the ground up; no circle may be in them."""
    floor: dict[str, int] = {}
    for name in TopologicalSorter(graph).static_order():
        below = graph.get(name, ())
        floor[name] = max((floor[one] + 1 for one in below), default=0)
    levels: list[list[str]] = [[] for _ in range(max(floor.values(), default=-1) + 1)]
    for name in sorted(floor):
        levels[floor[name]].append(name)
    return levels


def direct(graph: Graph) -> Graph:
    """Leave out imports that lead through another room too: the drawing stays clear."""
    reach: Graph = {}
    for name in TopologicalSorter(graph).static_order():
        below = graph.get(name, set())
        reach[name] = below.union(*(reach[one] for one in below))
    return {
        name: {b for b in below if not any(b in reach[o] for o in below - {b})}
        for name, below in graph.items()
    }


def storeys(count: dict[str, int], graph: Graph) -> list[list[str]]:
    """Return the rows of the map from below: floors of the library, then the book."""
    library = {n: below for n, below in graph.items() if n.startswith(f"{LIBRARY}.")}
    below, place, rows = direct(library), dict[str, float](), []
    for level in floors(library):
        # Near the rooms below that it calls
        pull = {
            name: sum(place[b] for b in below[name]) / max(1, len(below[name]))
            for name in level
        }
        rows.append(sorted(level, key=lambda name, pull=pull: (pull[name], name)))
        place |= {name: k - (len(level) - 1) / 2 for k, name in enumerate(rows[-1])}
    book = sorted(name for name in count if name.startswith(f"{BOOK}."))
    lessons = [name for name in book if is_lesson(name.split("."))]
    shared = [name for name in book if name not in lessons]
    return rows + [row for row in (shared, lessons) if row]


def boxes(count: dict[str, int], graph: Graph, public: Graph) -> dict[str, Box]:
    """Return the place of each room, its sides by the root of its lines."""
    found: dict[str, Box] = {}
    top, before = 0.0, ""
    for row in storeys(count, graph):
        drawn = []
        for name in row:
            short = name.partition(".")[2]
            wide = max(2.6 * count[name] ** 0.5, 9.6 * len(short) + 24, 84)
            modules = " ".join(sorted(public.get(name, ())))
            words = [
                f"{round(count[name], -2):,} lines",
                *textwrap.wrap(modules, int(wide / 6.6)),
            ]
            high = max(1.3 * count[name] ** 0.5, 32 + 15 * len(words))
            drawn.append(Box(0, 0, wide, high, short, words))
        tallest = max(box.high for box in drawn)
        package = row[0].partition(".")[0]
        top += UP * (1.6 if before not in ("", package) else 1) if before else 0
        x = -(sum(box.wide for box in drawn) + ACROSS * (len(drawn) - 1)) / 2
        for name, box in zip(row, drawn):
            middle = x + box.wide / 2
            found[name] = box._replace(x=middle, y=-(top + tallest / 2))
            x += box.wide + ACROSS
        top, before = top + tallest, package
    return found


def drawing(root: Path = ROOT) -> str:
    """Return the map as SVG text: the library, a line for each import, and the book."""
    found, count = imports(root), sizes(root)
    graph = {name: set[str]() for name in count} | graph_of(found, room_of)
    public: Graph = {}
    for path in root.glob(f"{LIBRARY}/*/*.py"):
        if not path.stem.startswith("_"):
            public.setdefault(room_of(module_of(path, root)), set()).add(path.stem)
    rooms = boxes(count, graph, public)
    left = min(box.x - box.wide / 2 for box in rooms.values()) - MARGIN
    top = min(box.y - box.high / 2 for box in rooms.values()) - 2 * MARGIN
    page = f'x="{left:.0f}" y="{top:.0f}" width="{-2 * left:.0f}"'
    page += f' height="{MARGIN - top:.0f}"'
    view = " ".join(re.findall(r"-?\d+", page))
    title = "The rooms of pgm_lab, and above them those of pgm_book, which use them"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="{view}" role="img">',
        f"<title>{title}; each line is an import, downwards</title>",
        f"<style>{STYLE}</style>",
        f'<rect class="paper" {page}/>',
    ]
    library = {name: below for name, below in graph.items() if LIBRARY in name}
    for name, below in sorted(direct(library).items()):
        for other in sorted(below):
            line = curve(rooms[name], rooms[other], rooms)
            parts.append(f'<path id="{name}-{other}" d="{line}"/>')
    for package in (LIBRARY, BOOK):
        own = [box for name, box in rooms.items() if name.startswith(f"{package}.")]
        if own:
            high = min(box.y - box.high / 2 for box in own) - 14
            text = f'x="{left + MARGIN:.0f}" y="{high:.0f}"'
            parts.append(f'<text class="package" {text}>{package}</text>')
    for name, box in sorted(rooms.items()):
        kind = ' class="lesson"' if is_lesson(name.split(".")) else ""
        corner = f'x="{box.x - box.wide / 2:.0f}" y="{box.y - box.high / 2:.0f}"'
        side = f'width="{box.wide:.0f}" height="{box.high:.0f}" rx="6"'
        parts.append(f"<rect{kind} {corner} {side}/>")
        y = box.y - 7.5 * len(box.words) + 4
        parts.append(f'<text x="{box.x:.0f}" y="{y:.0f}">{escape(box.name)}</text>')
        for k, words in enumerate(box.words):
            at = f'x="{box.x:.0f}" y="{y + 18 + 15 * k:.0f}"'
            parts.append(f'<text class="modules" {at}>{escape(words)}</text>')
    return "\n".join([*parts, "</svg>", ""])


def contents(svg: str) -> set[str]:
    """Return rooms, modules and imports of a map; sizes change with every line."""
    shown = re.findall(r'id="([^"]+)"|>([^<]+)</text>', svg)
    words = {word for pair in shown for text in pair for word in text.split()}
    return {word for word in words if not word[0].isdigit()}


def curve(start: Box, end: Box, rooms: dict[str, Box]) -> str:
    """Return a path from room to room, between the rooms of the floors it crosses."""
    places = [(start.x, start.y + start.high / 2, start.y + start.high / 2)]
    for y in sorted({box.y for box in rooms.values() if start.y < box.y < end.y}):
        row = [box for box in rooms.values() if box.y == y]
        half = max(box.high for box in row) / 2
        step = ACROSS / 2
        gaps = [b.x + side * (b.wide / 2 + step) for b in row for side in (-1, 1)]
        straight = (places[-1][0] + end.x) / 2
        gap = min(gaps, key=lambda x: abs(x - straight))
        places.append((gap, y - half, y + half))
    places.append((end.x, end.y - end.high / 2, 0))
    text = ""
    for (x, _, y), (u, v, _) in zip(places, places[1:]):
        middle = (y + v) / 2
        text += f"{'L' if text else 'M'}{x:.0f} {y:.0f}"
        text += f"C{x:.0f} {middle:.0f} {u:.0f} {middle:.0f} {u:.0f} {v:.0f}"
    return text


def main() -> int:
    """Write the map, say how large the house is and which imports break a rule."""
    found = imports()
    faults = [fault for rule in broken(found).values() for fault in rule]
    print("".join(f"{fault}\n" for fault in faults), end="", file=sys.stderr)
    if circle(found):
        return 1
    MAP.write_text(drawing(), encoding="utf-8", newline="\n")
    count = sizes()
    graph = {name: set[str]() for name in count} | graph_of(found, room_of)
    for row in reversed(storeys(count, graph)):
        print(", ".join(f"{name.partition('.')[2]} {count[name]}" for name in row))
    for package in (BOOK, LIBRARY):
        lines = [n for name, n in count.items() if name.startswith(f"{package}.")]
        print(f"{package}: {len(lines)} rooms, {sum(lines)} lines")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
