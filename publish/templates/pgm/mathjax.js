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
      if (window.afterTypesetting) await window.afterTypesetting();
      document.documentElement.dataset.ready = "yes";
    },
  },
};
