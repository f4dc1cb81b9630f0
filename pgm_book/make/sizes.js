// What a slide shows, and how large, in px of 1280 x 720; pgm_book/make/sizes.py judges it.
// Returns rows of kind, what it is, and the value.
(slide) => {
  const OTHER = "aside, sub, sup, style, script, mjx-container, .slide-footer";
  const CAPTION = "caption, figcaption, .of-verdicts"; // also where a source stands
  const folds = [...slide.querySelectorAll("details")];
  const rows = [];

  // Of folds of one name the browser keeps one open: first the first of each name ...
  const names = folds.map((fold) => fold.name);
  for (const fold of [...folds].reverse()) fold.open = true;
  for (const image of slide.querySelectorAll("img")) {
    const { clientWidth, clientHeight, naturalWidth, naturalHeight } = image;
    const shown = Math.min(clientWidth, (clientHeight * naturalWidth) / naturalHeight);
    const [label, width] = ["--label", "--width"].map((name) =>
      parseFloat(image.style.getPropertyValue(name)));
    const known = label && width && shown;
    rows.push(["figure label", image.alt, known ? (label * shown) / width : null]);
    rows.push(["enlargement", image.alt, (1.5 * shown) / (naturalWidth + 1)]);
  }
  let sticksOut = 0;
  for (const fold of [null, ...folds]) {
    if (fold) fold.open = true;
    sticksOut = Math.max(
      sticksOut,
      slide.scrollHeight - slide.clientHeight,
      slide.scrollWidth - slide.clientWidth,
    );
  }
  rows.push(["overflow", "", sticksOut]);

  // ... and then all of them.
  for (const fold of folds) {
    fold.removeAttribute("name");
    fold.open = true;
  }
  const walker = document.createTreeWalker(slide, NodeFilter.SHOW_TEXT);
  let first = null;
  while (walker.nextNode()) {
    const { data, parentElement: parent } = walker.currentNode;
    if (!data.trim() || parent.closest(OTHER) || !parent.checkVisibility()) continue;
    first ??= parent;
    const code = parent.closest("pre, code") ? "code" : "text";
    const kind = parent.closest(CAPTION) ? "caption" : code;
    const block = parent.closest("pre, p, li, td, th, summary, h1, h2, h3") ?? parent;
    rows.push([kind, block.textContent, parseFloat(getComputedStyle(parent).fontSize)]);
  }
  for (const formula of slide.querySelectorAll("mjx-container")) {
    const drawn = formula.querySelector("g[data-mml-node='math']");
    if (formula.closest("aside") || !formula.checkVisibility() || !drawn) continue;
    // A thousand units of MathJax are the size of its font.
    const size = 1000 * Math.abs(drawn.getScreenCTM().a);
    rows.push(["text", formula.querySelector("math")?.textContent ?? "formula", size]);
  }
  const listings = [...slide.querySelectorAll(".input pre, .text pre")];
  const lines = listings.map((pre) => pre.textContent.trimEnd().split("\n").length);
  rows.push(["lines of code", "", lines.reduce((sum, more) => sum + more, 0)]);
  const headed = first?.closest("h1, h2, h3");
  rows.push(["no heading", first?.textContent ?? "an empty slide", headed ? 0 : 1]);

  folds.forEach((fold, index) => {
    fold.open = false;
    if (names[index]) fold.name = names[index];
  });
  const title = slide.querySelector("h1, h2, h3")?.textContent ?? "";
  return { title, rows };
};
