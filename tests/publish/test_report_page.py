"""The HTML reports, of a bundle and of a matching, as a reader's browser shows them."""

import pytest

from pgm_book.make.browser import offline_context
from pgm_lab import bundle, datasets, matching
from pgm_lab.camera import Camera
from pgm_lab.report import html
from pgm_lab.report.matching import html as matching_html
from tests.matching import photos
from tests.publish.look import axe_violations, bad_images, load_axe, show_all


def of_bundle():
    """The network of 2013 with its blunders, so that there is something to warn of."""
    data = datasets.muliawan2013()
    rays = data.photo, data.point, data.xy, data.sigma
    camera = Camera(*data.interior)
    network = bundle.Network(camera, data.exteriors, data.object_points, *rays)
    return html(bundle.adjust(network), about="Nine photos of 2013.")


def of_matching():
    """A matching of which there is much to warn, with every status."""
    status = ["accepted"] * 9 + [*matching.STATUSES] * 2
    found = photos.result(len(status), status, shift=(30.0, 1.0), sd=0.3)
    return matching_html(found, *photos.pair(), about="Two photos of a test.")


@pytest.fixture(scope="module", params=[of_bundle, of_matching])
def report(request, tmp_path_factory):
    path = tmp_path_factory.mktemp("report") / "report.html"
    path.write_text(request.param(), encoding="utf-8")
    return path


@pytest.mark.parametrize("width", [390, 1280])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_everyone_can_read_the_page(browser, report, scheme, width):
    """On a telephone and on a screen; only tables may scroll sideways."""
    viewport = {"width": width, "height": 900}
    context = offline_context(browser, color_scheme=scheme, viewport=viewport)
    page = context.new_page()
    requests = []
    page.on("request", lambda request: requests.append(request.url))
    page.goto(report.as_uri())
    load_axe(page)
    # A table that scrolls in its box hides cells, whose contrast axe cannot tell. It
    # can once the table is shown in its whole width, at the end.
    assert axe_violations(page, scrolled=True) == []
    assert bad_images(page) == []
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    paper = page.evaluate("getComputedStyle(document.body).backgroundColor")
    assert paper == {"light": "rgb(255, 255, 255)", "dark": "rgb(23, 24, 27)"}[scheme]
    assert [url for url in requests if not url.startswith("data:")] == [report.as_uri()]
    show_all(page)
    assert axe_violations(page, "color-contrast") == []
    context.close()
