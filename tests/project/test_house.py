"""The map of the house is drawn from the imports, and the imports keep the rules."""

import re
from graphlib import CycleError
from xml.etree import ElementTree

import pytest

from tools import house


@pytest.fixture
def package(tmp_path):
    """Two rooms, one above the other, and a door that imports from above."""
    folder = tmp_path / "pgm_lab"
    for path, text in {
        "__init__.py": "",
        "ground.py": "import math\n",
        "upper/__init__.py": "from pgm_lab.upper.stairs import up\n",
        "upper/stairs.py": "from pgm_lab import ground\n",
        "upper/_inside.py": "from pgm_lab.upper import stairs\n",
        "ground_door/__init__.py": "",
        "ground_door/__main__.py": "from pgm_lab import upper\n",
    }.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8")
    return folder


def test_the_map_in_docs_is_current():
    assert house.MAP.read_text(encoding="utf-8") == house.drawing(), (
        "the imports have changed: run `python tasks.py house`"
    )


def test_no_modules_need_each_other():
    house.floors(house.imports())
    house.floors(house.rooms())


def test_a_room_stands_above_those_it_imports_from(package):
    assert house.rooms(package) == {
        "ground": set(),
        "upper": {"ground"},
        "ground_door": set(),
    }
    assert house.floors(house.rooms(package)) == [["ground", "ground_door"], ["upper"]]


def test_a_circle_of_imports_is_found(package):
    (package / "ground.py").write_text("from pgm_lab.upper import stairs\n")
    with pytest.raises(CycleError):
        house.floors(house.rooms(package))


def test_an_import_for_the_type_checker_alone_is_none(package):
    text = "if TYPE_CHECKING:\n    from pgm_lab.upper import stairs\n"
    (package / "ground.py").write_text(text)
    assert house.rooms(package)["ground"] == set()


def test_an_import_that_leads_through_another_room_is_not_drawn():
    graph = {"a": {"b", "c"}, "b": {"c"}, "c": set()}
    assert house.direct(graph) == {"a": {"b"}, "b": {"c"}, "c": set()}


def test_every_import_that_is_drawn_goes_down():
    svg = ElementTree.fromstring(house.drawing())
    paths = [one.get("d") for one in svg.iter("{http://www.w3.org/2000/svg}path")]
    assert len(paths) == sum(map(len, house.direct(house.rooms()).values())) > 10
    for path in paths:
        rows = [float(pair.split()[1]) for pair in re.findall(r"[\d.]+ [\d.]+", path)]
        assert rows[0] < rows[-1]


def test_a_module_with_an_underscore_is_imported_in_its_own_folder_only():
    strangers = [
        f"{module} imports {target}"
        for module, targets in house.imports().items()
        for target in targets
        if "._" in f".{target}" and "." in target
        if not module.startswith(target.rpartition(".")[0])
    ]
    assert strangers == []


def test_the_walk_of_one_pixel_names_files_that_are_there():
    text = (house.ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    walk = re.findall(r"^\| (\d+) \| .+ \| `(pgm_lab/.+)` \|$", text, re.MULTILINE)
    assert [number for number, _ in walk] == [str(i) for i in range(1, 11)]
    assert [path for _, path in walk if not (house.ROOT / path).is_file()] == []


# Of StereoMap: its logic is in other modules, which do not draw
DRAWING = ("plot", "report", "ledger", "command")
DRAWING += ("stereo_map.drawing", "stereo_map._panels")


def test_what_computes_imports_nothing_that_draws():
    for module, targets in house.imports().items():
        if not module.startswith(DRAWING):
            drawing = [t for t in targets if t.startswith(("plot", "report", "ledger"))]
            assert drawing == [], module
