for (const viewer of document.querySelectorAll(".viewer")) {
  const buttons = [...viewer.querySelectorAll("button")];
  const box = viewer.querySelector("input");
  let index = 0;
  const show = (i) => {
    index = (i + buttons.length) % buttons.length;
    const has = viewer.querySelector(`img[data-index="${index}"][data-kind="errors"]`);
    const kind = box.checked && has ? "errors" : "picture";
    for (const image of viewer.querySelectorAll("img"))
      image.hidden = Number(image.dataset.index) !== index || image.dataset.kind !== kind;
    buttons.forEach((b, j) => b.setAttribute("aria-pressed", j === index));
  };
  buttons.forEach((b, j) => b.addEventListener("click", () => show(j)));
  box.addEventListener("change", () => show(index));
  viewer.addEventListener("keydown", (e) => {
    if (e.key === "ArrowRight") show(index + 1);
    if (e.key === "ArrowLeft") show(index - 1);
  });
  show(0);
}
