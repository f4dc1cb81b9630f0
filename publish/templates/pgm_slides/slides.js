// Start of the slides. While the page has the class "preparing", every slide is laid
// out (and invisible), so that formulas and contents can be measured.

const SMALLEST_FIGURE = 260; // px of 720
const SMALLEST_TEXT = 60; // percent

function overflow(slide) {
  return Math.max(
    slide.scrollHeight - slide.clientHeight,
    slide.scrollWidth - slide.clientWidth,
  );
}

// What opens on a slide has to fit, too; of the choices of a prediction one is open.
function fit(slide) {
  const folded = slide.querySelectorAll("details:not([open])");
  folded.forEach((one) => { one.open = true; });
  shrink(slide);
  folded.forEach((one) => { one.open = false; });
}

// A slide that is too full gets smaller figures, then less air, then smaller text.
function shrink(slide) {
  for (const image of slide.querySelectorAll("img")) {
    const height = image.clientHeight - (slide.scrollHeight - slide.clientHeight);
    if (height < image.clientHeight) {
      image.style.maxHeight = `${Math.max(SMALLEST_FIGURE, height)}px`;
    }
  }
  slide.classList.toggle("compact", overflow(slide) > 0);
  for (let size = 95; overflow(slide) > 0 && size >= SMALLEST_TEXT; size -= 5) {
    slide.style.fontSize = `${size}%`;
  }
}

// Notes belong to a slide from its start, also if they follow a fragment; and the
// speaker's window has no style for MathJax, but shows MathML.
function prepareNotes(notes) {
  notes.closest("section").append(notes);
  for (const formula of notes.querySelectorAll("mjx-container")) {
    formula.replaceWith(formula.querySelector("math"));
  }
}

window.afterTypesetting = async () => {
  const images = [...document.images].map((image) => image.decode().catch(() => {}));
  await Promise.all(images);
  document.querySelectorAll(".slides > section > section").forEach(fit);
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
    slideNumber: "c/t",
    transition: "none",
    controlsTutorial: false,
    plugins: [RevealNotes],
  });
  // reveal.js calls the whole page an application; it is a document with landmarks.
  document.querySelector(".reveal").removeAttribute("role");
  const number = document.querySelector(".slide-number");
  number.setAttribute("role", "region");
  number.setAttribute("aria-label", "Slide number");
  document.documentElement.classList.remove("preparing");
};
