"""The reference: what is public in `pgm_lab`, a page a room.

A name that a room exports is on its page as ``room.name``, whatever its module;
whatever else a public module of the room contains follows under that module.
"""

import ast
import importlib
import inspect
import pkgutil
import re
import textwrap
from functools import cache
from pathlib import Path
from types import ModuleType

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

import pgm_book.common
import pgm_book.program
import pgm_lab
from pgm_book.common import ledger

# A listing of the source, and the link with which Sphinx leads back from it
LISTING = re.compile(r'(id="([\w.]+)">\s*<a class="viewcode-back" href="[^"#]*#)[^"]*')


def write(folder: Path) -> list[str]:
    """Write a page for each room of the package; return their names."""
    target = folder / "reference"
    target.mkdir()
    pages = []
    for room in rooms():
        name = _page_of(room)
        (target / f"{name}.rst").write_text(page(room), encoding="utf-8")
        pages.append(f"reference/{name}")
    return pages


@cache
def public_names() -> dict[str, str]:
    """Return the page of each public function and class by its full name."""
    return {
        f"{module.__name__}.{name}": f"reference/{_page_of(module)}"
        for room in rooms()
        for module, names in contents(room).items()
        for name in names
    }


@cache
def _names_of_things() -> dict[object, str]:
    return {thing(name): name for name in public_names()}


def public_name(name: str) -> str:
    """Return the name under which the reference has a function or class.

    Examples
    --------
    >>> public_name("pgm_lab.lsm.rigorous.adjust")
    'pgm_lab.lsm.adjust'
    """
    return _names_of_things().get(thing(name), name)


def thing(name: str) -> object:
    """Return the function or class of a full name."""
    module, _, last = name.rpartition(".")
    return pkgutil.resolve_name(f"{module}:{last}")


def rooms() -> list[ModuleType]:
    """Return what is public in the library, what lessons share, and the ledger's."""
    shared = [*_modules(pgm_book.common), *_modules(pgm_book.program)]
    named = {name.rpartition(".")[0] for name in _in_ledger()}
    lessons = sorted(name for name in named if name.startswith("pgm_book.ch"))
    return [
        *_modules(pgm_lab),
        *(one for one in shared if "real_pairs" not in one.__name__),
        *map(importlib.import_module, lessons),
    ]


def contents(room: ModuleType) -> dict[ModuleType, list[str]]:
    """Return the functions and classes of a room, each once, by the module to use."""
    found: dict[ModuleType, list[str]] = {}
    seen: set[object] = set()
    for module in [room, *_modules(room)]:
        found[module] = [
            name
            for name, thing in vars(module).items()
            if _offers(module, name, thing) and thing not in seen
        ]
        seen |= {getattr(module, name) for name in found[module]}
    return {module: names for module, names in found.items() if names}


def page(room: ModuleType) -> str:
    """Write the page of a room for autodoc."""
    parts = []
    every = {room: [], **contents(room)}
    for module, names in every.items():
        title = module.__name__
        parts.append(f"{title}\n{('=' if module is room else '-') * len(title)}")
        # A function may have the name of its module: then only the function is listed.
        shadowed = not inspect.ismodule(getattr(room, title.rpartition(".")[2], module))
        parts.append(f".. automodule:: {title}" + "\n   :no-index:" * shadowed)
        parts += [_entry(module, name) for name in names]
    return "\n\n".join(parts) + "\n"


def _entry(module: ModuleType, name: str) -> str:
    full = f"{module.__name__}.{name}"
    thing = getattr(module, name)
    if not inspect.isclass(thing):
        return f".. autofunction:: {full}"
    hidden = f":members:\n   :exclude-members: {_fields(thing)}"
    return f".. autoclass:: {full}\n   {hidden}"


def _fields(thing: type) -> str:
    """Name the fields of a dataclass: its docstring has them under Attributes."""
    return ", ".join(vars(thing).get("__annotations__", {})) or "__none__"


def _offers(module: ModuleType, name: str, thing: object) -> bool:
    """Whether a module says that a function or class is to be taken from it."""
    documented = inspect.isfunction(thing) or inspect.isclass(thing)
    if name.startswith("_") or not documented:
        return False
    home = thing.__module__
    if hasattr(module, "__path__"):  # a room offers what it imports by name
        listed = getattr(module, "__all__", None)
        if listed is not None:
            return name in listed
        return home == module.__name__ or home.startswith(f"{module.__name__}._")
    return home == module.__name__ or f"{module.__name__}.{name}" in _in_ledger()


@cache
def _in_ledger() -> set[str]:
    """Full names of the functions that implement a published equation."""
    return {name for row in ledger.verdicts() for name in row["code"].split("; ")}


def _modules(package: ModuleType) -> list[ModuleType]:
    names = pkgutil.iter_modules(getattr(package, "__path__", []))
    return [
        importlib.import_module(f"{package.__name__}.{info.name}")
        for info in names
        if not info.name.startswith("_")
    ]


def _page_of(module: ModuleType) -> str:
    """Return the name of the page that has a module: a room of the library has one."""
    package, room, *_ = module.__name__.split(".")
    return room if package == "pgm_lab" else module.__name__


def setup(app: Sphinx) -> None:
    """Read the docstrings as they are meant."""
    app.connect("autodoc-process-docstring", keep_bars)
    app.connect("autodoc-process-signature", as_written)
    app.connect("doctree-read", keep_types)
    app.connect("html-page-context", lead_back)


def as_written(app, what, name, thing, *_) -> tuple[str, str] | None:
    """Write a signature as it is in the source: ArrayLike, not all it may be."""
    try:
        (tree,) = ast.parse(textwrap.dedent(inspect.getsource(thing))).body
    except (OSError, TypeError, ValueError):
        return None
    written_in = vars(inspect.getmodule(thing))
    for node in ast.walk(tree):
        # The full name of a class of ours, so that it becomes a link.
        meant = written_in.get(node.id) if isinstance(node, ast.Name) else None
        if inspect.isclass(meant) and meant.__module__.startswith(
            ("pgm_lab.", "pgm_book.")
        ):
            node.id = f"{meant.__module__}.{meant.__qualname__}"
    if isinstance(tree, ast.FunctionDef):
        returns = ast.unparse(tree.returns) if tree.returns else ""
        if what == "method" and tree.args.args:
            del tree.args.args[0]  # self or cls
        return f"({ast.unparse(tree.args)})", returns
    fields = [ast.unparse(line) for line in tree.body if type(line) is ast.AnnAssign]
    if issubclass(thing, BaseException):  # it is raised with a message alone
        return None
    return (f"({', '.join(fields)})", "") if fields else None


def keep_bars(app, what, name, thing, options, lines: list[str]) -> None:
    """Keep |v|, which is a length here and a substitution in reStructuredText."""
    in_example = False
    for number, line in enumerate(lines):
        in_example = bool(line.strip()) and (in_example or line.lstrip()[:3] == ">>>")
        if not in_example:
            lines[number] = line.replace("|", "\\|")


def keep_types(app: Sphinx, tree: nodes.document) -> None:
    """Keep the words of a type, "sequence of names", from becoming links by chance."""
    for link in list(tree.findall(addnodes.pending_xref)):
        # Those of role obj are between backquotes, on purpose.
        if link["refdomain"] == "py" and link["reftype"] != "obj":
            if "." not in link["reftarget"]:
                told = link.next_node(addnodes.pending_xref_condition)
                link.replace_self((told or link).children)


def lead_back(app: Sphinx, page: str, _template: str, context: dict, *_) -> None:
    """Lead each listing back to its entry: Sphinx takes one room or module for all."""
    if not page.startswith(("_modules/pgm_lab/", "_modules/pgm_book/")):
        return
    module = page.removeprefix("_modules/").replace("/", ".")

    def entry(listing: re.Match) -> str:
        name, dot, member = listing[2].partition(".")
        return f"{listing[1]}{public_name(f'{module}.{name}')}{dot}{member}"

    context["body"] = LISTING.sub(entry, context["body"])
