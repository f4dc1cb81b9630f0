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

// What opens on a slide has to fit, too. Of the choices of a prediction one is open at
// a time, and of the other folds of a slide as well: the tallest of each is laid out.
function fit(slide, number) {
  const folds = [...slide.querySelectorAll("details")];
  for (const fold of folds) {
    fold.name ||= `folds-${number}`;
  }
  for (const group of new Set(folds.map((fold) => fold.name))) {
    tallest(folds.filter((fold) => fold.name === group)).open = true;
  }
  shrink(slide);
  for (const fold of folds) {
    fold.open = false;
  }
}

function tallest(folds) {
  const heights = folds.map((fold) => {
    fold.open = true; // which closes the others of its name
    return fold.offsetHeight;
  });
  return folds[heights.indexOf(Math.max(...heights))];
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
