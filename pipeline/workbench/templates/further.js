// Further poses of an open session: logs are dropped, shown and fitted with the others; the script of
// the workbench writes them.
const further = (() => {
"use strict";
const { asked } = drawing;
const part = (name) => document.querySelector(`[data-further${name ? `-${name}` : ""}]`);
let leftOut = new Set(), isFit = false, state = null, changed = null, asking = null;

const say = (text) => { part("words").textContent = text; };

// The newest question alone is answered on the page.
async function update(refused = []) {
  if (!dropped.count) return;
  const mine = asking = {};
  part("forget").hidden = false;
  isFit = false;
  changed();
  say("The session is fitted with them …");
  try {
    const answer = await asked("further", { state: state(), left_out: [...leftOut] });
    if (asking === mine) show(answer, refused);
  } catch (error) {
    if (asking !== mine) return;
    part("figures").textContent = "";
    say([...refused, error.message].join(" "));
  }
  if (asking === mine) changed();
}

function show({ head, rows, places, figures, notes }, refused) {
  const cells = (texts, tag) => texts.map((text) => Object.assign(document.createElement(tag), { textContent: text }));
  part("head").replaceChildren(...cells(head, "th"));
  part("rows").replaceChildren(...rows.map((texts) => {
    const row = document.createElement("tr");
    row.append(...cells(texts, "td"));
    return row;
  }));
  part("places").replaceChildren(...places.map(({ key, says, on }) => {
    const label = document.createElement("label"), box = document.createElement("input");
    Object.assign(box, { type: "checkbox", checked: on });
    box.addEventListener("change", () => {
      if (box.checked) leftOut.delete(key); else leftOut.add(key);
      update();
    });
    label.append(box, ` ${says}`);
    return label;
  }));
  part("figures").textContent = figures.join("\n");
  part("shown").hidden = false;
  isFit = true;
  say([...refused, ...notes, `${rows.length} pose${rows.length === 1 ? "" : "s"}: "Write to config" keeps them.`].join(" "));
}

function open() {
  part("").open = true;
  part("").scrollIntoView({ block: "start" });
  part("files").focus();
}

return {
  open, update,
  // The runs that the logs do not join, for a write; null without logs that were fitted.
  get written() { return isFit ? [...leftOut] : null; },
  begin(screen, onChange) {
    state = screen;
    changed = onChange;
    dropped.begin(part("drop"), part("files"), part("folder"), say, (refused) =>
      (dropped.count ? update(refused) : say(refused.join(" "))));
    part("forget").addEventListener("click", async () => {
      asking = null;
      await dropped.forget();
      leftOut = new Set();
      isFit = false;
      part("shown").hidden = part("forget").hidden = true;
      say("Forgotten: nothing is kept of them.");
      changed();
    });
    asked("forget").catch(() => {});  // what an earlier page has dropped
  },
};
})();
