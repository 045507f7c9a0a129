// Files that are dropped on a page or chosen there, and how its server gets them.
const dropped = (() => {
"use strict";
let batch = 0, names = new Set();

// Files that are dropped on ``area`` or chosen in ``input`` go to ``take``.
function onto(area, input, take) {
  input.addEventListener("change", () => { if (input.files.length) take(...input.files); });
  for (const [name, is] of [["dragover", true], ["dragleave", false], ["drop", false]]) {
    area.addEventListener(name, (event) => {
      event.preventDefault();
      area.classList.toggle("dropping", is);
      if (name === "drop" && event.dataTransfer.files.length) take(...event.dataTransfer.files);
    });
  }
}

// Files of one drop keep their names; a name that is there already goes into a folder of its drop.
// What is refused is given back in words, and the others are taken: every folder has a stray file.
async function bring(files, say) {
  batch += 1;
  const paths = files.map((file) => file.webkitRelativePath || file.name);
  const clash = paths.some((path) => names.has(path)), refused = [];
  for (const [i, file] of files.entries()) {
    say(`${i + 1} of ${files.length}: ${paths[i]}`);
    const path = clash ? `drop${batch}/${paths[i]}` : paths[i];
    try {
      await drawing.sent(`bring/${path.split("/").map(encodeURIComponent).join("/")}`, file);
      names.add(path);
    } catch (error) {
      refused.push(error.message);
    }
  }
  return [...refused.slice(0, 3), ...(refused.length > 3 ? [`So are ${refused.length - 3} more.`] : [])];
}

return {
  onto,
  get count() { return names.size; },
  clear() { names = new Set(); },
  // What the server has of them is removed there too.
  async forget() {
    await drawing.asked("forget");
    names = new Set();
  },
  // Files and folders for the server; ``take`` gets what was refused.
  begin(area, files, folder, say, take) {
    const brought = async (...all) => take(await bring(all, say));
    onto(area, files, brought);
    folder.addEventListener("change", () => brought(...folder.files));  // a drop is taken once
  },
};
})();
