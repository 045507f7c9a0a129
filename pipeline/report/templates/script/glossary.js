// The glossary: a term shows its entry where it stands, under the mouse, with the keyboard's focus,
// at a touch.
const tip = document.getElementById("tip");
const hide = () => {
  tip.hidden = true;
  document.querySelector("[aria-describedby=tip]")?.removeAttribute("aria-describedby");
};
const show = (term) => {
  hide();
  const entry = document.getElementById(term.hash.slice(1));
  tip.textContent = entry.querySelector("dd").textContent;
  tip.hidden = false;
  tip.style.left = tip.style.top = "0";  // where its width is free, to measure it
  term.setAttribute("aria-describedby", "tip");
  const at = term.getBoundingClientRect(), size = tip.getBoundingClientRect();
  const room = document.documentElement.clientWidth - size.width - 8;
  const above = at.bottom + size.height + 8 > window.innerHeight;
  tip.style.left = `${Math.max(8, Math.min(at.left, room)) + window.scrollX}px`;
  tip.style.top = `${(above ? at.top - size.height - 4 : at.bottom + 4) + window.scrollY}px`;
};
for (const term of document.querySelectorAll("a.term")) {
  term.addEventListener("mouseenter", () => show(term));
  term.addEventListener("mouseleave", hide);
  term.addEventListener("focus", () => show(term));
  term.addEventListener("blur", hide);
  term.addEventListener("click", (event) => { event.preventDefault(); show(term); });
}
document.addEventListener("keydown", (event) => { if (event.key === "Escape") hide(); });
