// The second layer: folded away until somebody asks, unfolded on paper; and commands that are copied.
const unfold = (node) => {
  for (let at = node?.closest("details"); at; at = at.parentElement.closest("details")) at.open = true;
};
let folded = [];
addEventListener("beforeprint", () => {
  folded = [...document.querySelectorAll("details.paper:not([open])")];
  folded.forEach((layer) => { layer.open = true; });
});
addEventListener("afterprint", () => folded.forEach((layer) => { layer.open = false; }));
// A link to what is folded away unfolds it.
addEventListener("hashchange", () => unfold(document.getElementById(location.hash.slice(1))));

for (const shown of document.querySelectorAll("main pre")) {
  const frame = document.createElement("div"), button = document.createElement("button");
  frame.className = "copied";
  button.type = "button";
  button.textContent = "Copy";
  shown.replaceWith(frame);
  frame.append(shown, button);
  button.addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(shown.textContent);
      button.textContent = "Copied";
    } catch {  // a browser that allows it to no file: the text is selected instead
      getSelection().selectAllChildren(shown);
      button.textContent = "Selected";
    }
    setTimeout(() => { button.textContent = "Copy"; }, 2000);
  });
}
