// Start of the slides. While the page has the class "preparing", every slide is laid
// out (and invisible), so that formulas and contents can be measured.

// Notes belong to a slide from its start, also if they follow a fragment; and the
// speaker's window has no style for MathJax, but shows MathML.
function prepareNotes(notes) {
  notes.closest("section").append(notes);
  for (const formula of notes.querySelectorAll("mjx-container")) {
    formula.replaceWith(formula.querySelector("math"));
  }
}

// A presenter has one key to go on: it first opens the right choice of a prediction,
// and with it the result. (`pgmViews` asks this before reveal.js takes a key.)
const NEXT = ["ArrowRight", "ArrowDown", "PageDown", " ", "n"];

function opensTheRightChoice(event) {
  const choices = [...Reveal.getCurrentSlide().querySelectorAll(".pgm-predict details")];
  const right = choices.find((choice) => choice.textContent.includes("✓"));
  if (!right || right.open || event.shiftKey || !NEXT.includes(event.key)) return false;
  right.open = true;
  event.preventDefault();
  return true;
}

// The space bar on a choice that has the focus opens that one, as in any page.
function opensItsChoice(event) {
  return event.key === " " && event.target.closest?.(".pgm-predict") != null;
}

// The last slide may be one of several in the last column, where reveal.js stops at the
// first of them.
function goesToTheEnd() {
  const { h, v } = Reveal.getIndices(Reveal.getSlides().at(-1));
  Reveal.slide(h, v);
}

const SLIDES = ".slides > section > section";

window.afterTypesetting = async () => {
  const images = [...document.images].map((image) => image.decode().catch(() => {}));
  await Promise.all(images);
  for (const [number, slide] of document.querySelectorAll(SLIDES).entries()) {
    if (slide.isConnected) fitWithNext(slide, number);
  }
  document.querySelectorAll("aside.notes").forEach(prepareNotes);
  // The heading of a slide comes right below the title, whatever its size.
  for (const heading of document.querySelectorAll(".slides h3")) {
    heading.setAttribute("aria-level", "2");
  }

  await Reveal.initialize({
    width: 1280,
    height: 720,
    margin: 0,
    center: false,
    hash: true,
    navigationMode: "linear",
    keyboard: { 35: goesToTheEnd }, // the key End
    slideNumber: "c/t",
    transition: "none",
    controlsTutorial: false,
    // Slides without seconds take none, if any slide has some: the speaker's pace.
    ...(document.querySelector("section[data-timing]") && { defaultTiming: 0 }),
    plugins: [pgmViews, ...(window.RevealNotes ? [RevealNotes] : [])],
  });
  // reveal.js calls the whole page an application; it is a document with landmarks.
  document.querySelector(".reveal").removeAttribute("role");
  const number = document.querySelector(".slide-number");
  number.setAttribute("role", "region");
  number.setAttribute("aria-label", "Slide number");
  document.documentElement.classList.remove("preparing");
};
