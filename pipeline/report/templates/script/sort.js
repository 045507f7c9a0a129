"use strict";
// Sorts the rows of a table by the column whose heading is clicked, and the other way round next.
for (const heading of document.querySelectorAll("table.board th")) {
  const button = document.createElement("button");
  button.append(...heading.childNodes);
  heading.append(button);
  button.addEventListener("click", () => {
    const body = heading.closest("table").tBodies[0];
    const falls = heading.getAttribute("aria-sort") !== "descending";
    for (const other of heading.parentElement.cells) other.removeAttribute("aria-sort");
    heading.setAttribute("aria-sort", falls ? "descending" : "ascending");
    const key = (row) => row.cells[heading.cellIndex];
    const compare = (one, other) => "order" in key(one).dataset
      ? Number(key(one).dataset.order) - Number(key(other).dataset.order)
      : key(one).textContent.localeCompare(key(other).textContent, "en", {numeric: true});
    body.append(...[...body.rows].sort((one, other) => (falls ? -1 : 1) * compare(one, other)));
  });
}
