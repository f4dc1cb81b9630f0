// Otherwise a line may break between a formula and the full stop after it.
function keepPunctuation() {
  for (const formula of document.querySelectorAll("mjx-container:not([display])")) {
    const text = formula.nextSibling;
    const marks = text?.nodeType === Node.TEXT_NODE && text.data.match(/^[.,;:!?)]+/);
    if (!marks) continue;
    text.splitText(marks[0].length);
    const together = document.createElement("span");
    together.className = "unbroken";
    formula.before(together);
    together.append(formula, text);
  }
}

// Settings of MathJax. The page is ready once its formulas are set and, in the
// slides, once `afterTypesetting` has run.
window.MathJax = {
  tex: {
    inlineMath: [["$", "$"], ["\\(", "\\)"]],
    processEscapes: true,
  },
  options: { enableMenu: false },
  startup: {
    async pageReady() {
      await MathJax.startup.defaultPageReady();
      keepPunctuation();
      if (window.afterTypesetting) await window.afterTypesetting();
      document.documentElement.dataset.ready = "yes";
    },
  },
};
