"""The three subcommands with small files of their own, in a folder with a blank."""

import functools

import pytest

from pgm_lab import bundle, matching, registration, report
from tests.command.calls import Call
from tests.matching import photos
from tests.networks import real
from tests.registration import images


@pytest.fixture
def folder(tmp_path):
    one = tmp_path / "my data"
    one.mkdir()
    return one


@pytest.fixture
def outputs(tmp_path):
    """A folder for what is written."""
    one = tmp_path / "outputs"
    one.mkdir()
    return one


@functools.cache
def adjusted():
    return bundle.adjust(real())


@pytest.fixture
def adjust(folder):
    files = list(bundle.write(real(), folder / "network"))
    return Call("adjust", files, "Bundle adjustment")


@pytest.fixture
def match(folder):
    return Call("match", photos.save(folder), "Image matching")


@pytest.fixture
def register(folder):
    return Call("register", images.save(folder), "Image registration")


# By subcommand: the function that works, the result that takes no time, and the one
# that draws
WORK = {
    "adjust": ((bundle, "adjust"), adjusted, (report, "html")),
    "match": ((matching, "match"), photos.result, (report.matching, "html")),
    "register": (
        (registration, "register"),
        images.result,
        (report.registration, "html"),
    ),
}


@pytest.fixture(params=WORK)
def call(request):
    """Each subcommand in turn."""
    return request.getfixturevalue(request.param)


@pytest.fixture
def quick(monkeypatch):
    """Nothing is computed and nothing drawn, for what comes around that."""
    for name, (_, _, drawing) in WORK.items():
        no_work(monkeypatch, name)
        monkeypatch.setattr(*drawing, lambda *_, **__: "the page")


def no_work(monkeypatch, name, found=None, asked=None):
    """Have a subcommand find what is given, and note what was asked."""
    (module, function), result, _ = WORK[name]
    found = result() if found is None else found  # before that is replaced
    original = getattr(module, function)

    @functools.wraps(original)
    def instead(*arguments, **options):
        if asked is not None:
            asked.update(options)
        return found

    monkeypatch.setattr(module, function, instead)
