// The layout of a slide, 1280 x 720: text above its figures or beside them, chosen so
// that the back row reads both. pgm_book/make/sizes.py measures what came out.

const LABEL = 18; // px of 720: the smallest writing in a figure that a hall reads
const AMPLE = 22; // px: larger labels are no reason to narrow the text
const GAP = 28; // px between columns, and between figures side by side
const NARROWEST = 320; // px: a column of text
const UNKNOWN = 17; // px: labels of a picture that does not say how large they are

// Text in per cent of 30 px, whether there is less air, and the smallest text in px.
const TEXT = [
  [100, false, 24], [100, true, 24], [95, true, 24], [90, true, 24], [85, true, 24],
  [80, true, 24],
];
// What does not fit even so is refused or listed; it must not be cut off in addition.
const CRAMMED = [23, 22, 21, 20, 19, 18, 17, 16, 15, 14, 12, 10].map((px) => [px / 0.3, true, px]);

function overflow(slide) {
  return Math.max(
    slide.scrollHeight - slide.clientHeight,
    slide.scrollWidth - slide.clientWidth,
  );
}

// A slide of a few lines, without code or a figure, takes in the next one if both can be
// read together; so two quick questions stand on one slide.
function fitWithNext(slide, number) {
  fit(slide, number);
  const next = slide.nextElementSibling;
  if (!next || !isShort(slide) || staysAlone(next)) return;
  const heading = next.querySelector("h2, h3");
  const line = document.createElement("p");
  line.innerHTML = `<strong>${heading.innerHTML}</strong>`;
  const moved = [...next.childNodes];
  heading.replaceWith(line);
  slide.append(...moved);
  const layout = fit(slide, number);
  if (layout.good) {
    const seconds = [slide, next].map((one) => Number(one.dataset.timing ?? 0));
    if (sum(seconds)) slide.dataset.timing = sum(seconds);
    next.remove();
  } else {
    layout.place(0, false);
    line.replaceWith(heading);
    next.append(...moved);
    fit(slide, number);
  }
}

function isShort(slide) {
  if (staysAlone(slide) || slide.querySelector("h1, img, .input, .pgm-predict")) return false;
  // What asks may not stand beside its answer.
  if (textOf(slide.querySelector(".text:last-of-type") ?? slide).endsWith("?")) return false;
  slide.classList.add("measuring");
  const used = slide.offsetHeight;
  slide.classList.remove("measuring");
  return used < 0.6 * slide.clientHeight;
}

const staysAlone = (slide) =>
  slide.querySelector(".verdicts") || textOf(slide.querySelector("h1, h2, h3") ?? slide) === "Break";

// What opens on a slide has to fit, too. Of the choices of a prediction one is open at
// a time, and of the other folds of a slide as well: the tallest of each is laid out.
function fit(slide, number) {
  // A figure beside the text still appears when its place in the notebook says.
  slide.querySelectorAll(".fragment").forEach((fragment, index) => {
    fragment.dataset.fragmentIndex ??= index;
  });
  const folds = [...slide.querySelectorAll("details")];
  for (const fold of folds) {
    fold.name ||= `folds-${number}`;
  }
  slide.style.fontSize = `${TEXT.at(-1)[0]}%`; // where room is short
  slide.classList.add("compact");
  for (const group of new Set(folds.map((fold) => fold.name))) {
    tallest(folds.filter((fold) => fold.name === group)).open = true;
  }
  const layout = new Layout(slide);
  layout.choose();
  for (const fold of folds) {
    fold.open = true; // at another size of text another one may be the tallest
    if (overflow(slide) > 0) layout.choose();
  }
  for (const fold of folds) {
    fold.open = false;
  }
  return layout;
}

function tallest(folds) {
  const heights = folds.map((fold) => {
    fold.open = true; // which closes the others of its name
    return fold.offsetHeight;
  });
  return folds[heights.indexOf(Math.max(...heights))];
}

// The size of a picture in px, that of its smallest writing, and the most that it may
// be enlarged: to its own pixels at 1080 lines, or until its writing can be read.
function describe(image) {
  const [width, label] = ["--width", "--label"].map((name) =>
    parseFloat(image.style.getPropertyValue(name)));
  const { naturalWidth, naturalHeight } = image;
  const shown = width || naturalWidth / 1.5;
  const sharp = naturalWidth / 1.5 / shown;
  return {
    image,
    width: shown,
    height: (shown * naturalHeight) / naturalWidth,
    label: label || UNKNOWN,
    most: Math.max(sharp, label ? LABEL / label : 0),
  };
}

// The largest number for which `fits` holds, of those up to 4.
function largest(fits) {
  let [low, high] = [0, 4];
  for (let step = 0; step < 20; step += 1) {
    const middle = (low + high) / 2;
    if (fits(middle)) low = middle;
    else high = middle;
  }
  return low;
}

const sum = (numbers) => numbers.reduce((total, number) => total + number, 0);

class Layout {
  constructor(slide) {
    this.slide = slide;
    const images = slide.querySelectorAll("figure img, .text p > img:only-child");
    this.figures = [...images]
      .filter((image) => !image.closest("aside, details"))
      .map(describe);
    this.predicts = slide.querySelector(".pgm-predict") !== null;
    this.heading = slide.querySelector("h1, h2, h3");
    this.units = this.movable();
    this.places = this.units.map((unit) => [unit, unit.parentNode, unit.nextSibling]);
    this.column = document.createElement("div");
    this.column.className = "figures";
  }

  // Take the largest text with which all fits and the figures can be read; if they
  // cannot, the largest figures.
  choose() {
    let best = null;
    for (const text of [...TEXT, ...CRAMMED]) {
      if (best && CRAMMED.includes(text)) break;
      for (const arrangement of this.arrangements()) {
        const reads = this.apply({ text, ...arrangement });
        if (arrangement.first && reads >= LABEL) {
          this.good = TEXT.includes(text);
          return;
        }
        const most = best?.reads ?? 0;
        const suffices = reads >= LABEL && most < LABEL;
        if (suffices || reads > 1.05 * most) best = { reads, text, ...arrangement };
      }
      if (best?.reads >= LABEL) break;
    }
    this.good = best?.reads >= LABEL && TEXT.includes(best.text);
    this.apply(best ?? { text: CRAMMED.at(-1), words: 0, row: false });
  }

  // Above one another; the figures in a row; or the text beside, as wide as that leaves
  // the figures large.
  arrangements() {
    const list = [{ words: 0, row: false, first: true }];
    if (this.predicts || !this.units.length) return list;
    const several = this.figures.length > 1;
    if (several) list.push({ words: 0, row: true });
    if (!this.hasWords()) return list;
    const full = this.slide.clientWidth;
    for (let words = 0.6 * full; words >= NARROWEST; words -= 0.04 * full) {
      list.push({ words, row: false });
      if (several) list.push({ words, row: true });
    }
    return list;
  }

  // Lay the slide out so; return the px of the smallest label, 0 if it does not fit.
  apply({ text: [size, tight, least], words, row }) {
    const { slide, figures } = this;
    slide.style.fontSize = `${size}%`;
    slide.classList.toggle("compact", tight);
    slide.style.setProperty("--least", `${least}px`);
    this.place(words, row);
    if (!figures.length) return overflow(slide) > 0 ? 0 : AMPLE;
    const zooms = this.zooms(this.room(words), row);
    figures.forEach(({ image, width }, index) => {
      image.style.setProperty("--shown", `${width * zooms[index]}px`);
    });
    if (overflow(slide) > 0) return 0;
    const labels = figures.map(({ label }, index) => label * zooms[index]);
    return Math.min(AMPLE, ...labels);
  }

  // Figures go into a column or a row of their own, or back to where they stood.
  place(words, row) {
    const { slide, column } = this;
    for (const [unit, parent, next] of [...this.places].reverse()) {
      parent.insertBefore(unit, next);
    }
    column.remove();
    slide.classList.toggle("beside", words > 0);
    column.classList.toggle("row", row);
    if (!words && !row) return;
    if (words) {
      slide.append(column);
      slide.style.setProperty("--words", `${words}px`);
      slide.style.setProperty("--top", `${this.below()}px`);
    } else {
      this.units[0].before(column);
    }
    column.append(...this.units);
  }

  // Where the text of the slide begins, below its heading.
  below() {
    const { heading } = this;
    if (!heading) return 0;
    const margin = parseFloat(getComputedStyle(heading).marginBottom);
    return heading.offsetTop + heading.offsetHeight + margin;
  }

  // Width and height that the text leaves to the figures.
  room(words) {
    const { slide, figures } = this;
    slide.classList.add("measuring");
    const holder = figures[0].image.parentElement;
    const width = words ? slide.clientWidth - words - GAP : holder.clientWidth;
    const used = words ? this.below() : slide.offsetHeight;
    slide.classList.remove("measuring");
    return { width, height: slide.clientHeight - used - 1 }; // heights are rounded
  }

  zooms({ width, height }, row) {
    const { figures, slide } = this;
    const gap = 0.6 * parseFloat(getComputedStyle(slide).fontSize);
    const at = (zoom) =>
      figures.map((figure) => Math.min(zoom, figure.most, width / figure.width));
    const sizes = (zoom, side) =>
      at(zoom).map((own, index) => own * figures[index][side]);
    return at(largest((zoom) => row
      ? sum(sizes(zoom, "width")) + GAP * (figures.length - 1) <= width
        && Math.max(...sizes(zoom, "height")) <= height
      : sum(sizes(zoom, "height")) + gap * figures.length <= height));
  }

  // A figure that appears later moves with its fragment, if that holds nothing else;
  // of a slide with another one no figure moves.
  movable() {
    const units = new Set();
    for (const { image } of this.figures) {
      const figure = image.parentElement;
      const fragment = figure.closest(".fragment");
      units.add(fragment ?? figure);
      if (fragment && textOf(fragment)) return [];
    }
    return [...units];
  }

  // Whether anything but headings stands beside the figures.
  hasWords() {
    const rest = this.slide.cloneNode(true);
    rest.querySelectorAll("h1, h2, h3, aside, figure").forEach((part) => part.remove());
    return textOf(rest) !== "";
  }
}

const textOf = (element) => element.textContent.trim();
