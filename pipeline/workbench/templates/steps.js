// What the screen shows beyond the files, the steps back and forth, and what outlives a new page.
const steps = (() => {
"use strict";
const MOST_STEPS = 100;  // of the history; chosen
const shown = document.documentElement.dataset;  // the stamps of the files that the page shows
let page = null, benches = [], changed = null;
let undone = [], done = [], now = "", asRun = "", restoring = false;

const mine = (name) => `${shown.data} ${name}`;  // other data, other sitting
const keep = (name, value) => {
  try { sessionStorage.setItem(mine(name), JSON.stringify(value)); } catch { /* more than it holds */ }
};
const drop = (name) => sessionStorage.removeItem(mine(name));
const kept = (name) => JSON.parse(sessionStorage.getItem(mine(name)) ?? "null");
const benchOf = (section) => benches.find((each) => each.section === section);

const state = () => ({
  triads: Object.fromEntries(page.sections.map((section) => [section.triad.triad, {
    ticked: section.order.map((effect) => effect.name),
    out: section.triad.labels.filter((_, k) => section.out.has(k)),
    back: [...benchOf(section)?.back ?? []] }])),
  terms: Object.fromEntries(page.rateSections.flatMap(({ rate, boxes }) => {
    const ticked = rate.terms.filter((_, i) => boxes[i].checked);
    const differs = rate.terms.some((term, i) => term.in_model !== boxes[i].checked);
    return differs ? [[rate.setting, ticked.map((term) => term.name)]] : [];
  })),
});

// The whole screen, also what the file has: a step of the history holds whatever is written since.
const screen = () => JSON.stringify({
  triads: Object.fromEntries(benches.map((each) => [each.section.triad.triad, {
    ticked: each.section.order.map((effect) => effect.name), without: each.without() }])),
  terms: Object.fromEntries(page.rateSections.map(({ rate, boxes }) =>
    [rate.setting, rate.terms.filter((_, i) => boxes[i].checked).map((term) => term.name)])),
});

// A step, unless the screen is what it was.
function remember() {
  const next = screen();
  if (restoring || next === now) return;
  done.push(now);
  undone = [];
  now = next;
  changed(true);
}

function restore(text) {
  const { triads, terms } = JSON.parse(text);
  restoring = true;
  for (const section of page.sections) {
    const bench = benchOf(section);
    const { ticked, without } = triads[section.triad.triad] ?? { ticked: [], without: bench.excluded };
    bench.comesBack(bench.excluded.filter((label) => !without.includes(label)));
    section.order = ticked.map((name) => section.effects.find((effect) => effect.name === name))
      .filter(Boolean);
    section.out = new Set(without.map((label) => section.triad.labels.indexOf(label)).filter((k) => k >= 0));
    for (const effect of section.effects) {
      section.boxes.get(effect.name).checked = section.order.includes(effect);
    }
  }
  for (const { rate, boxes } of page.rateSections) {
    const ticked = terms[rate.setting];
    boxes.forEach((box, i) => {
      box.checked = ticked ? ticked.includes(rate.terms[i].name) : rate.terms[i].in_model;
    });
  }
  now = screen();
  page.sections.forEach((section) => section.update());
  page.rateSections.forEach((section) => section.update());
  restoring = false;
  changed(false);
}

return {
  shown, keep, drop, kept, state, remember,
  get back() { return done.length; },
  get forth() { return undone.length; },
  get isAsRun() { return now === asRun; },
  undo() { undone.push(now); restore(done.pop()); },
  redo() { done.push(now); restore(undone.pop()); },
  // Another model of a triad, as one more step.
  show(triad, model) {
    const whole = JSON.parse(screen());
    whole.triads[triad] = model;
    done.push(now);
    undone = [];
    restore(JSON.stringify(whole));
  },
  // For the next page; ``unwritten`` is the screen where the file has not got it.
  store(unwritten = now === asRun ? null : now) {
    keep("history", { done: done.slice(-MOST_STEPS), undone, now: unwritten });
  },
  // ``onChange`` is told whether a step was made, or one was taken back or forth.
  begin(parts, ofTriads, onChange) {
    [page, benches, changed] = [parts, ofTriads, onChange];
    asRun = now = screen();
    const before = kept("history");
    if (!before) return;
    ({ done, undone } = before);
    if (before.now) restore(before.now);
  },
};
})();
