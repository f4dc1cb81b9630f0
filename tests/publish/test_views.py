"""The slides on paper, on a phone, and zoomed; one pass over two decks."""

import io
import re
import unicodedata
from contextlib import contextmanager

import nbformat
import pytest
from nbformat.v4 import new_output
from pypdf import PdfReader

from pgm_book.common.predict import page as choices_page
from pgm_book.make.browser import find_browser, named_browser, offline_context
from pgm_book.make.page import slides_page
from tests.publish.conftest import CHAPTERS
from tests.publish.example import code, example, figure_output, text
from tests.publish.look import axe_violations, load_axe
from tests.publish.watch import Watched

CHOICES = [{"choice": f"choice {n}", "right": "yes", "feedback": f"Because {n}."}
           for n in ("one", "two")]  # fmt: skip
PREDICTION = code(
    "predict()",
    new_output("display_data", data={"text/html": choices_page("1.1", CHOICES)}),
    new_output("stream", name="stdout", text="what comes of it\n"),
    figure_output("what comes of it, drawn"),
    tags=("predict",),
)
LAPTOPS = [(1280, 720), (1366, 633), (1920, 947), (1024, 600)]


@pytest.fixture(scope="module")
def example_deck(tmp_path_factory):
    """A deck of all kinds of cells with a prediction."""
    folder = tmp_path_factory.mktemp("example")
    waits = [text("## Predict", "slide"), PREDICTION, text("The answer waits.")]
    nbformat.write(example(*waits), folder / "01_example.ipynb")
    return written(folder, folder / "01_example.ipynb")


@pytest.fixture(scope="module", params=["example", "07_pearson_registration"])
def deck(request, example_deck, tmp_path_factory):
    """That deck, and a real one."""
    if request.param == "example":
        return example_deck
    return written(tmp_path_factory.mktemp("views"), CHAPTERS[request.param])


def written(folder, notebook):
    path = folder / "slides.html"
    path.write_text(slides_page(notebook), encoding="utf-8")
    return path


@contextmanager
def opened(browser, deck, query="", **options):
    context = offline_context(browser, **options)
    watched = Watched(context)
    watched.page.goto(deck.as_uri() + query)
    watched.wait()
    yield watched.page
    assert watched.errors == []
    context.close()


def view(page) -> str:
    """Return which view is shown, once the page has taken notice of its window."""
    page.evaluate("() => new Promise((done) => setTimeout(done, 150))")
    shown = page.evaluate("document.documentElement.classList.contains('document')")
    return "document" if shown else "slides"


# Paper

SLIDES = """() => [...document.querySelectorAll(".slides > section > section")].map(
    (slide) => {
        const page = slide.getBoundingClientRect();
        const seen = [...slide.querySelectorAll("*")].filter((element) =>
            element.checkVisibility() && element.getBoundingClientRect().width > 0
            && !element.closest("aside, mjx-assistive-mml, svg *"));
        const cut = seen.filter((element) => {
            const box = element.getBoundingClientRect();
            return box.left < page.left || box.right > page.right
                || box.top < page.top || box.bottom > page.bottom;
        });
        return {
            size: [page.width, page.height],
            text: slide.innerText,
            images: slide.querySelectorAll("img").length,
            cut: cut.map((element) => element.outerHTML.slice(0, 80)),
        };
    })"""


def squeezed(words: str) -> str:
    return re.sub(r"\s", "", unicodedata.normalize("NFKC", words))


def test_a_slide_is_a_page_and_nothing_is_cut(browser, deck):
    with opened(browser, deck, viewport={"width": 1280, "height": 720}) as page:
        pdf = page.pdf(prefer_css_page_size=True)
        page.emulate_media(media="print")
        slides = page.evaluate(SLIDES)
        assert len(slides) == page.evaluate("Reveal.getTotalSlides()")
    pages = PdfReader(io.BytesIO(pdf)).pages
    assert len(pages) == len(slides)
    for number, (paper, slide) in enumerate(zip(pages, slides), start=1):
        assert slide["cut"] == [], f"slide {number}"
        assert slide["size"] == [1280, 720]
        assert paper.mediabox.width == 960 and paper.mediabox.height == 540  # pt
        printed = squeezed(paper.extract_text())
        missing = [
            word
            for word in re.findall(r"\w{3,}", slide["text"])
            if squeezed(word) not in printed
        ]
        assert missing == [], f"page {number}"
        assert len(paper.images) == slide["images"], f"page {number}"
        assert printed.endswith(str(number))


def test_on_paper_fragments_and_results_are_there_and_sentences_are_not(browser, deck):
    """Also with the address by which reveal.js prints in a way of its own."""
    with opened(browser, deck, "?print-pdf") as page:
        pages = PdfReader(io.BytesIO(page.pdf(prefer_css_page_size=True))).pages
        assert len(pages) == page.evaluate("Reveal.getTotalSlides()")
        choices = page.locator(".pgm-predict details")
        page.emulate_media(media="print")
        for waiting in page.locator(".fragment, .html:has(.pgm-predict) ~ *").all():
            assert waiting.evaluate(
                "(e) => e.checkVisibility({ opacityProperty: true,"
                " visibilityProperty: true }) && e.offsetHeight > 0"
            )
        page.evaluate(
            "document.querySelector('.pgm-predict details').setAttribute('open', '')"
        )
        assert choices.count() > 1
        assert all(choice.is_visible() for choice in choices.all())
        sentences = page.locator(".pgm-predict details p").all()
        assert not any(sentence.is_visible() for sentence in sentences)
        overlays = ".controls, .progress, .slide-number, .reveal > footer, aside"
        assert not any(one.is_visible() for one in page.locator(overlays).all())


# A phone

SMALL_TEXT = """() => {
    const small = [];
    const walker = document.createTreeWalker(
        document.querySelector(".slides"), NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
        const element = walker.currentNode.parentElement;
        if (!walker.currentNode.data.trim() || !element.checkVisibility()) continue;
        if (element.closest("mjx-container, sub, sup, style, aside")) continue;
        const size = parseFloat(getComputedStyle(element).fontSize);
        if (size < 16) small.push(`${size} px: ${walker.currentNode.data.trim()}`);
    }
    return small;
}"""
PHONE = {"viewport": {"width": 390, "height": 844}, "is_mobile": True,
         "has_touch": True, "device_scale_factor": 2}  # fmt: skip


def swipe_up(page):
    client = page.context.new_cdp_session(page)
    for y in range(600, 200, -20):
        touch = {"type": "touchStart" if y == 600 else "touchMove"}
        client.send(
            "Input.dispatchTouchEvent", touch | {"touchPoints": [{"x": 200, "y": y}]}
        )
    client.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    page.wait_for_timeout(300)


def test_a_phone_gets_a_document(browser, deck):
    """Readable, not wider than the screen, scrolled and predicted by the finger."""
    with opened(browser, deck, **PHONE) as page:
        assert view(page) == "document"
        assert page.evaluate(SMALL_TEXT) == []
        assert page.evaluate("document.documentElement.scrollWidth") == 390
        assert page.evaluate("innerWidth") == 390, "laid out wider, and shrunk"
        slides = page.locator(".slides > section > section")
        assert all(slide.is_visible() for slide in slides.all())
        assert page.locator(".slides [aria-hidden=true] p").count() == 0
        load_axe(page)
        found = axe_violations(page)
        # Colours are those of the slides; of a phone's code axe sees only some.
        assert [one for one in found if not one.startswith("color-contrast")] == []
        for image in page.locator("figure img").all():
            if image.is_visible():
                assert image.bounding_box()["width"] > 300

        swipe_up(page)
        assert page.evaluate("scrollY") > 300
        assert page.evaluate("Reveal.getSlidePastCount()") == 0

        cell = page.locator(".cell:has(.pgm-predict)").first
        result = cell.locator(".html:has(.pgm-predict) ~ *").first
        assert not result.is_visible()
        cell.locator("summary").first.tap()
        assert result.is_visible()


def test_turning_the_phone_turns_the_view_at_the_same_slide(browser, example_deck):
    with opened(browser, example_deck, "#/3", **PHONE) as page:
        assert view(page) == "document"
        slides = page.locator(".slides > section > section")
        shown = page.evaluate("Reveal.getSlidePastCount()")
        assert abs(slides.nth(shown).bounding_box()["y"]) < 5
        slides.nth(shown + 1).evaluate("(slide) => slide.scrollIntoView()")
        page.set_viewport_size({"width": 844, "height": 390})
        assert view(page) == "slides"
        assert page.evaluate("Reveal.getSlidePastCount()") == shown + 1
        assert slides.nth(shown + 1).bounding_box()["height"] < 390
        middle = "document.elementFromPoint(innerWidth / 2, innerHeight / 2)"
        assert page.evaluate(f"Reveal.getCurrentSlide().contains({middle})")
        assert not page.evaluate("document.documentElement.scrollWidth > innerWidth")
        page.set_viewport_size({"width": 390, "height": 844})
        assert view(page) == "document"
        assert abs(slides.nth(shown + 1).bounding_box()["y"]) < 5


# A hall, and a reader who zooms


@pytest.mark.parametrize("ratio", [1, 2])
def test_windows_of_a_laptop_and_of_the_speaker_s_view_show_slides(
    browser, example_deck, ratio
):
    with opened(browser, example_deck, device_scale_factor=ratio) as page:
        for width, height in LAPTOPS:
            page.set_viewport_size({"width": width, "height": height})
            assert view(page) == "slides"
            scale = min(width / 1280, height / 720)
            assert abs(page.evaluate("Reveal.getScale()") - scale) < 0.01
        small = f'<iframe src="{example_deck.as_uri()}" width="400" height="225">'
        page.set_content(small)
        frame = page.frames[-1]
        frame.wait_for_function("document.documentElement.dataset.ready")
        assert view(frame) == "slides"


TEXT_SIZE = """() => {
    const line = document.querySelector(".slides section section li");
    const slides = line.closest(".slides");
    const scale = slides.getBoundingClientRect().width / slides.offsetWidth;
    return parseFloat(getComputedStyle(line).fontSize) * scale * devicePixelRatio;
}"""


@pytest.mark.parametrize("window", ["1280,720", "1920,1080"])
def test_zoom_of_the_browser_enlarges_the_text(browser, example_deck, window, tmp_path):
    """Zoom as the reader's menu sets it, before and after the page is opened."""
    chromium = browser.browser_type
    context = chromium.launch_persistent_context(
        tmp_path / "profile",
        executable_path=named_browser() or find_browser(chromium.executable_path),
        args=["--disable-gpu", "--no-sandbox", f"--window-size={window}"],
        no_viewport=True,
        offline=True,
    )
    settings = context.new_page()
    settings.goto("chrome://settings/")

    def zoom(factor):
        settings.evaluate("(x) => chrome.settingsPrivate.setDefaultZoom(x)", factor)
        page.wait_for_timeout(300)
        return view(page), page.evaluate(TEXT_SIZE)

    settings.evaluate("chrome.settingsPrivate.setDefaultZoom(2)")
    page = context.pages[0]
    page.bring_to_front()
    page.goto(example_deck.as_uri())
    page.wait_for_function("document.documentElement.dataset.ready")
    assert view(page) == "document", "zoomed before it was opened"
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    page.keyboard.press("End")
    page.wait_for_function("scrollY + innerHeight > document.body.scrollHeight - 5")
    kind, size = zoom(1)
    assert kind == "slides"
    assert zoom(1.25) == ("slides", pytest.approx(size, rel=0.02))
    assert zoom(2) == ("document", pytest.approx(2 * size, rel=0.02))
    context.close()


def test_zoom_of_a_browser_that_measures_its_window_in_zoomed_pixels(
    browser, example_deck
):
    """As Firefox does: only the pixels of the device a pixel of the page tell."""
    with opened(
        browser, example_deck, viewport={"width": 1920, "height": 1080}
    ) as page:
        for side in ("Width", "Height"):
            same = f"'outer{side}', {{ get: () => inner{side} }}"
            page.evaluate(f"Object.defineProperty(window, {same})")
        before = page.evaluate(TEXT_SIZE)
        client = page.context.new_cdp_session(page)
        zoomed = {"width": 960, "height": 540, "deviceScaleFactor": 2, "mobile": False}
        client.send("Emulation.setDeviceMetricsOverride", zoomed)
        assert view(page) == "document"
        assert page.evaluate(TEXT_SIZE) == pytest.approx(2 * before, rel=0.02)
