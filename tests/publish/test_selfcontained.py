"""A published page loads nothing: every way to load something is refused."""

import base64

import nbformat
import pytest

from pgm_book.make.__main__ import main
from pgm_book.make.page import slides_page
from pgm_book.make.selfcontained import embed_images, problems
from tests.publish.example import example, text

HERE = "https://example.org/a"
PIXEL = "data:image/gif;base64,R0lGODlhAQABAIAAAP///wAAACwAAAAAAQABAAACAkQBADs="

# What Chromium asks for, without a click, when it shows the page.
FETCHES = [
    f'<svg><image href="{HERE}"/></svg>',
    f'<svg><image xlink:href="{HERE}"/></svg>',
    f'<svg><filter id="f"><feImage href="{HERE}"/></filter>'
    '<rect filter="url(#f)" width="9" height="9"/></svg>',
    f"<svg><style>@import '{HERE}';</style></svg>",
    f'<svg><script href="{HERE}"></script></svg>',
    f'<svg><foreignObject><img alt="x" src="{HERE}"></foreignObject></svg>',
    f"<script>fetch('{HERE}')</script>",
    f"<script>new Image().src = '{HERE}'</script>",
    f'<script src="{HERE}"></script>',
    f'<script type="module">import "{HERE}"</script>',
    f'<script type="module" src="{HERE}"></script>',
    f'<img alt="x" src="data:," onerror="fetch(\'{HERE}\')">',
    f"<details open ontoggle=\"fetch('{HERE}')\"></details>",
    f"<iframe srcdoc='<img src=\"{HERE}\">'></iframe>",
    f'<iframe src="{HERE}"></iframe>',
    f'<object data="{HERE}"></object>',
    f'<embed src="{HERE}">',
    f'<meta http-equiv="refresh" content="0; url={HERE}">',
    '<base href="https://example.org/"><img alt="x" src="a">',
    f'<form action="{HERE}"><input name="q"></form>'
    "<script>document.forms[0].submit()</script>",
    f'<input type="image" alt="x" src="{HERE}">',
    f'<body background="{HERE}">',
    f'<table background="{HERE}"><tr><td>x</table>',
    f'<table><tr><td background="{HERE}">x</table>',
    f'<link rel="stylesheet" href="{HERE}">',
    f'<link rel="icon" href="{HERE}"><link rel="preload" as="image" href="{HERE}">',
    f'<link rel="modulepreload" href="{HERE}">',
    f'<img alt="x" src="{HERE}">',
    f'<img alt="x" srcset="{HERE} 1x">',
    f'<img alt="x" src="\n{HERE.replace("t", chr(9) + "t", 1)}">',
    f'<picture><source srcset="{HERE}"><img alt="x"></picture>',
    f'<video poster="{HERE}"></video>',
    f'<video src="{HERE}" preload="auto"></video>',
    f'<audio src="{HERE}" preload="auto"></audio>',
    f'<video preload="auto"><source src="{HERE}"></video>',
    f"<style>@import '{HERE}';</style>",
    f"<style>@import url({HERE});</style>",
    f"<style>@\\69mport '{HERE}';</style>",
    f"<style>body {{ background: url('{HERE}') }}</style>",
    f"<style>body {{ background: URL({HERE}) }}</style>",
    f"<style>body {{ background: \\75rl({HERE}) }}</style>",
    f"<style>body {{ --x: url({HERE}); background: var(--x) }}</style>",
    f'<style>body {{ background: image-set("{HERE}" 1x) }}</style>',
    f'<style>body {{ background: -webkit-image-set("{HERE}" 1x) }}</style>',
    f"<style>body {{ background: -webkit-cross-fade(url({HERE}), none, 50%) }}</style>",
    f"<style>body {{ background-image: linear-gradient(red, red), url({HERE}) }}"
    "</style>",
    f"<style>@font-face {{ font-family: f; src: url({HERE}) }}"
    "body { font-family: f }</style>x",
    f"<style>@media all {{ body {{ background: url({HERE}) }} }}</style>",
    f"<style>body::after {{ content: url({HERE}) }}</style>",
    f"<style>body {{ cursor: url({HERE}), auto }}</style>",
    f"<style>ul {{ list-style-image: url({HERE}) }}</style><ul><li>x</ul>",
    f"<p style=\"background: url('{HERE}')\">x</p>",
    f"<p style=\"background: image-set('{HERE}' 1x)\">x</p>",
    f'<!--><img alt="x" src="{HERE}">-->',
    f'<!-- --!><img alt="x" src="{HERE}"> -->',
    f'<![CDATA[><img alt="x" src="{HERE}">]]>',
]

# What waits for a click, for reveal.js, for another place or for another browser.
WAITS = [
    f'<svg><use href="{HERE}#part"/></svg>',
    f'<svg><rect width="9" height="9" filter="url({HERE}#f)"/></svg>',
    f'<svg><rect width="9" height="9" style="filter: url({HERE}#f)"/></svg>',
    '<img alt="x" src="//example.org/a">',
    f'<video><track default src="{HERE}"></video>',
    f'<form action="{HERE}"><button>x</button></form>',
    f'<a href="#" ping="{HERE}">x</a>',
    "<a href=\"javascript:fetch('https://example.org')\">x</a>",
    '<a href=" java\nscript:alert()">x</a>',
    '<a href="file:///home/ada/a.html">x</a>',
    '<a href="data:text/html,x">x</a>',
    f'<section data-background-image="{HERE}"></section>',
    f'<section data-background-iframe="{HERE}"></section>',
    f'<img alt="x" data-src="{HERE}">',
    f'<frameset><frame src="{HERE}"></frameset>',
    f'<applet archive="{HERE}"></applet>',
    f'<html manifest="{HERE}"></html>',
    f'<blockquote cite="{HERE}">x</blockquote>',
    f'<link rel="dns-prefetch" href="{HERE}">',
    f'<link rel="preconnect" href="{HERE}">',
    f'<script type="speculationrules">{{"prefetch": [{{"urls": ["{HERE}"]}}]}}'
    "</script>",
    f'<style>body {{ background: image("{HERE}") }}</style>',
    f'<style>body {{ background: src("{HERE}") }}</style>',
    "<style>body { background: url(paper.png) }</style>",
    '<style>body { background: url("a\nb") }</style>',
    f'<noscript><img alt="x" src="{HERE}"></noscript>',
    f"<textarea></textarea><template><img alt='x' src='{HERE}'></template>",
    f'<math><mi href="{HERE}">x</mi></math>',
    f"<p>$\\style{{background: url({HERE})}}{{x}}$</p>",
    f'<p>$\\mmlToken{{mi}}[style="background: url({HERE})"]{{x}}$</p>',
    '<img alt="x" src="#">',
    '<img alt="x" src="data:text/html,x">',
    "<unheard-of>x</unheard-of>",
    '<p unheard-of="x">x</p>',
    "<style>@unheard-of;</style>",
    "<style>p { width: unheard-of(1) }</style>",
]

FINE = [
    f'<a href="{HERE}">Bani</a><a href="#b">below</a><a href="mailto:a@b.org">us</a>',
    '<a href="05_intersection.ipynb">chapter 5</a><a href="a/b?at=1:2#c:d">there</a>',
    f'<img alt="dot" src="{PIXEL}" width="9">',
    f"<style>p {{ background: url({PIXEL}) }} p:not(.a) > b {{ top: calc(1px) }}"
    "</style>",
    '<p style="mask: url(#m); color: rgb(0 0 0)" aria-label="x" class="a b">x</p>',
    '<table><tr><th scope="col" colspan="2" style="text-align:right">x</table>',
    "<details open><summary>x</summary></details><p>$\\frac{1}{2}$ and a:b</p>",
    "<pre>\\style{x}</pre><code>&lt;svg&gt;</code>",
    '<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>x</title></html>',
]


@pytest.mark.parametrize("html", FETCHES + WAITS)
def test_what_could_load_something_is_refused(html):
    assert problems(html)


@pytest.mark.parametrize("html", FINE)
def test_what_loads_nothing_is_fine(html):
    assert problems(html) == []
    assert problems(embed_images(html, ".")) == []


@pytest.mark.parametrize("html", FETCHES)
def test_a_browser_does_load_it(browser, html):
    """So the list above is true, and nothing in it is refused without a reason."""
    context = browser.new_context()
    asked = []
    context.route("https://example.org/**", lambda r: (asked.append(r), r.abort()))
    page = context.new_page()
    page.set_content(f"<!DOCTYPE html>{html}", wait_until="domcontentloaded")
    for _ in range(100):
        if not asked:
            page.wait_for_timeout(50)
    context.close()
    assert asked


@pytest.fixture
def refused(tmp_path, capsys):
    """Return a function that publishes a text, and gives what the command says."""
    folder = tmp_path / "notebooks"
    folder.mkdir()

    def publish(source):
        nbformat.write(example(text(source, "slide")), folder / "01_example.ipynb")
        build = tmp_path / "build"
        code = main(["slides", "--notebooks", str(folder), "--build", str(build)])
        written = build.exists() and [
            path.read_text("utf-8") for path in build.rglob("*.html")
        ]
        return code, capsys.readouterr().err, written

    return publish


@pytest.mark.parametrize(
    "html", ["<svg><image href='a.png'/></svg>", "<base href='a'>"]
)
def test_the_command_refuses_it_and_names_the_cell(refused, html):
    code, message, written = refused(html)
    assert (code, written) == (1, False)
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
    code, message, written = refused(f"![A map](<{address}>)")
    assert (code, written) == (1, False)
    assert f"![A map](<{address[:20]}" in message  # it quotes the beginning of a cell
    page = embed_images(f'<img alt="x" src="{address}">', tmp_path / "notebooks")
    assert base64.b64encode(secret.read_bytes()).decode() not in page


def test_a_comment_of_the_author_is_dropped(tmp_path):
    said = text("One.\n\n<!-- not for the class -->\n\nTwo.", "slide")
    nbformat.write(example(said), tmp_path / "01_example.ipynb")
    assert "not for the class" not in slides_page(tmp_path / "01_example.ipynb")


def test_a_script_is_ours_to_the_letter():
    page = "<script>start();</script>"
    assert problems(page, ["start();\n"]) == []
    assert problems(page, ["start()"])
    assert problems('<script src="a.js">start();</script>', ["start();"])
