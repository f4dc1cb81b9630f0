// Two views of the same page: slides, which reveal.js scales to the window, and a
// document to scroll (narrow.css). A window gets the document when it is narrow, as a
// phone held upright is, or when the reader zooms, because slides would stay as they are.
// A plugin of reveal.js.

const NARROW = 700; // CSS px; narrower than half of a lecturer's screen
const ZOOMED = 1.4;
const SMALLEST_READING = 18; // CSS px
const TEXT_OF_A_SLIDE = 30; // px of 720
const page = document.documentElement; // its size is the window's, also where pinched

// How far the reader zoomed in. Most browsers measure the inside of the window in zoomed
// pixels and the outside in those of the screen; panels beside the page take from the
// width or from the height, but not from both. Firefox measures both alike, but gets
// more pixels of the device for one of the page. On a phone, nothing is known or needed.
const atStart = { ratio: devicePixelRatio, width: innerWidth * devicePixelRatio };

function zoom() {
  const outside = Math.min(outerWidth / page.clientWidth, outerHeight / page.clientHeight);
  const sameWindow = Math.abs(innerWidth * devicePixelRatio / atStart.width - 1) < 0.05;
  return Math.max(1, outside, sameWindow ? devicePixelRatio / atStart.ratio : 1);
}

function view() {
  // In the speaker's view the slides stand in small frames.
  if (window !== window.top) return "slides";
  return page.clientWidth < NARROW || zoom() >= ZOOMED ? "document" : "slides";
}

// Text of the document is as much larger than that of the slides as the reader zoomed.
function readingSize() {
  const scale = Math.min(page.clientWidth / 1280, page.clientHeight / 720);
  return Math.max(SMALLEST_READING, TEXT_OF_A_SLIDE * scale * zoom());
}

window.pgmViews = {
  id: "pgm-views",
  init(reveal) {
    const slides = document.querySelector(".slides");
    const shown = () => (page.classList.contains("document") ? "document" : "slides");

    // What scrolls in its box can be scrolled by the keyboard, too.
    function focusBoxes() {
      const boxes = slides.querySelectorAll("pre, table, mjx-container[display]");
      for (const box of boxes) {
        const fits = box.clientWidth > 0 && box.scrollWidth <= box.clientWidth;
        if (fits || shown() === "slides") box.removeAttribute("tabindex");
        else box.tabIndex = 0;
      }
    }

    function showDocument() {
      page.classList.add("document");
      slides.dataset.preventSwipe = "";
      for (const slide of slides.querySelectorAll("section")) {
        slide.hidden = false;
        slide.removeAttribute("aria-hidden");
      }
      reveal.getCurrentSlide().scrollIntoView();
    }

    function showSlides() {
      const read = reveal.getSlides().find(
        (slide) => slide.getBoundingClientRect().bottom > innerHeight / 3,
      );
      page.classList.remove("document");
      delete slides.dataset.preventSwipe;
      const { h, v } = reveal.getIndices(read);
      reveal.slide(h, v);
      reveal.layout();
    }

    function adapt() {
      page.style.setProperty("--reading", `${readingSize()}px`);
      if (view() !== shown()) {
        if (view() === "document") showDocument();
        else showSlides();
      }
      focusBoxes();
    }

    Object.assign(reveal.getConfig(), {
      view: null, // none for print, whatever the address says: print.css serves all
      scrollActivationWidth: null,
      keyboardCondition: (event) =>
        shown() === "slides" && !opensItsChoice(event) && !opensTheRightChoice(event),
    });
    // Its rules for paper are not for slides that were laid out already.
    page.classList.add("print-pdf");
    reveal.on("ready", () => {
      adapt();
      window.addEventListener("resize", adapt);
    });
  },
};
