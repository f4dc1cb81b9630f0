"""The policy of a published page: a browser loads nothing for it."""

import re

import pytest

from pgm_book.make.page import TEMPLATES

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
