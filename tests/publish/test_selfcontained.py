"""A published page loads nothing, and no file from elsewhere goes with it."""

import re

import nbformat
import pytest

from pgm_book.make.__main__ import main
from pgm_book.make.page import TEMPLATES, slides_page
from tests.publish.example import example, text

HERE = "https://example.org"
POLICY = re.compile(r"<meta http-equiv=\"Content-Security-Policy\"[^>]*>")

# What Chromium asks for, without a click, when it shows the page.
FETCHES = [
    '<svg><image href="{}"/></svg>',
    '<svg><filter id="f"><feImage href="{}"/></filter>'
    '<rect filter="url(#f)" width="9" height="9"/></svg>',
    "<svg><style>@import '{}';</style></svg>",
    "<script>fetch('{}')</script>",
    "<script>new Image().src = '{}'</script>",
    '<script src="{}"></script>',
    '<script type="module">import "{}"</script>',
    '<img alt="x" src="data:," onerror="fetch(\'{}\')">',
    "<details open ontoggle=\"fetch('{}')\"></details>",
    '<object data="{}"></object>',
    '<embed src="{}">',
    '<input type="image" alt="x" src="{}">',
    '<table background="{}"><tr><td>x</table>',
    '<link rel="stylesheet" href="{}">',
    '<img alt="x" src="{}">',
    '<img alt="x" srcset="{} 1x">',
    '<picture><source srcset="{}"><img alt="x"></picture>',
    '<video poster="{}"></video>',
    '<audio src="{}" preload="auto"></audio>',
    "<style>@import '{}';</style>",
    "<p style=\"background: url('{}')\">x</p>",
    "<p style=\"background: image-set('{}' 1x)\">x</p>",
    "<style>ul {{ list-style-image: url({}) }}</style><ul><li>x</ul>",
    "<style>@font-face {{ font-family: f; src: url({}) }}"
    "b {{ font-family: f }}</style><b>x</b>",
    '<!--><img alt="x" src="{}">-->',
]


@pytest.mark.parametrize("template", ["pgm_slides", "pgm_handout", None])
def test_the_policy_of_a_page_lets_a_browser_load_nothing(browser, template):
    """Without it the browser loads each of these, so the list is true."""
    policy = ""
    if template:
        file = TEMPLATES / template / "index.html.j2"
        policy = POLICY.search(file.read_text(encoding="utf-8"))[0]
    context = browser.new_context()
    asked = set()
    context.route(
        f"{HERE}/**", lambda route: (asked.add(route.request.url), route.abort())
    )
    page = context.new_page()
    addresses = [f"{HERE}/{n}" for n in range(len(FETCHES))]
    for html, address in zip(FETCHES, addresses):
        whole = f"<!DOCTYPE html><head>{policy}</head>{html.format(address)}"
        page.set_content(whole, wait_until="domcontentloaded")
        for _ in range(1 if template else 60):
            page.wait_for_timeout(50)
            if address in asked:
                break
    context.close()
    assert sorted(set(addresses) - asked) == (sorted(addresses) if template else [])


@pytest.fixture
def refused(tmp_path, capsys):
    """Return a function that publishes a text, and gives what the command says."""
    folder = tmp_path / "notebooks"
    folder.mkdir()

    def publish(source):
        nbformat.write(example(text(source, "slide")), folder / "01_example.ipynb")
        build = tmp_path / "build"
        assert main(["slides", f"--notebooks={folder}", f"--build={build}"]) == 1
        assert not build.exists()
        return capsys.readouterr().err

    return publish


@pytest.mark.parametrize(
    "html",
    [
        f'<iframe src="{HERE}"></iframe>',
        f'<base href="{HERE}">',
        f'<meta http-equiv="refresh" content="0; url={HERE}">',
        f'<form action="{HERE}"></form>',
        "<script>start()</script>",
        f'<link rel="icon" href="{HERE}">',
    ],
)
def test_what_leads_elsewhere_is_refused_with_its_cell(refused, html):
    message = refused(html)
    assert "may not be in a page" in message and "cell " in message


@pytest.mark.parametrize(
    "name",
    [
        "../secret.png",
        "%2e%2e/secret.png",
        "a/../../secret.png",
        "link.png",
        "{}/secret.png",
    ],
)
def test_a_picture_outside_the_folder_stays_there(refused, tmp_path, name):
    """A published page goes to others: no file from elsewhere goes with it."""
    secret = tmp_path / "secret.png"
    secret.write_bytes(b"nobody's business")
    if name == "link.png":
        (tmp_path / "notebooks" / name).symlink_to(secret)
    address = name.format(tmp_path)
    message = refused(f"![A map](<{address}>)")
    assert f"![A map](<{address[:20]}" in message  # it quotes the beginning of a cell
    assert "is not in the file" in message


def test_a_picture_beside_the_notebook_is_put_into_the_file(tmp_path):
    (tmp_path / "a map.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"/>'
    )
    notebook = example(text("![A map](<a map.svg>)"))
    nbformat.write(notebook, tmp_path / "01_example.ipynb")
    page = slides_page(tmp_path / "01_example.ipynb")
    assert 'alt="A map" src="data:image/svg+xml;base64,' in page
