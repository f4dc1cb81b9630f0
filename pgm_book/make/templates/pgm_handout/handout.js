// The figure of an answer floats beside it: a box as high takes both overleaf.
window.afterTypesetting = async () => {
  const images = [...document.querySelectorAll(".cell.answer > figure:first-child img")];
  await Promise.all(images.map((image) => image.decode()));
  for (const image of images) {
    image.closest(".cell").style.setProperty("--high", `${image.offsetHeight}px`);
  }
};
