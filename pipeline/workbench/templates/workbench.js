// The tools of a page that `pipeline open` serves: it asks Python for every fit, remembers what was
// tried, and writes what the screen shows into the configuration.
(() => {
"use strict";
const { asked } = drawing;
const bar = document.querySelector(".bench-bar");
const status = bar.querySelector("[data-bench-status]"), lines = bar.querySelector("[data-bench-lines]");
const button = (name) => bar.querySelector(`[data-bench-do="${name}"]`);
const benches = [];
let stamp = steps.shown, writing = false;  // the stamps of the files that are there

function say(text, changed = []) {
  status.textContent = text;
  lines.hidden = changed.length === 0;
  lines.textContent = changed.map(({ line, before, after }) => [
    ...(before ? before.split("\n").map((one) => `− ${one}`) : []),
    ...(after ? after.split("\n").map((one, i) => `+ ${line + i}: ${one}`) : [])].join("\n")).join("\n");
}

// --- undo, redo, write ---------------------------------------------------------------------------

// Words after a step back or forth: on the screen alone, until it is written.
function stepped(what) {
  say(steps.isAsRun ? `${what}: the screen is as the file.`
    : `${what} on the screen; the file has its model until "Write to config".`);
}

function offer() {
  button("undo").disabled = steps.back === 0;
  button("redo").disabled = steps.forth === 0;
  button("write").disabled = steps.isAsRun && further.written === null;
  steps.store();
}

const actions = {
  undo() { steps.undo(); stepped("Undone"); },
  redo() { steps.redo(); stepped("Done again"); },
  write() { write(); },
  further: further.open,
  async run() {
    button("run").disabled = writing = true;
    say("The session is run …");
    try {
      await asked("run");
      steps.keep("history", null);  // the file is what was edited last
      location.reload();
    } catch (error) {
      button("run").disabled = writing = false;
      say(error.message);
    }
  },
};

async function write(own = null) {
  button("write").disabled = writing = true;  // its own news are none
  say("The session is run with it …");
  try {
    const answer = await asked("write", { state: steps.state(), own, further: further.written });
    steps.shown.data = answer.data;  // an effect more is other data, and what was tried holds for it
    steps.keep("written", answer);
    steps.store(null);
    benches.forEach((each) => each.keepTried());
    location.reload();
  } catch (error) {
    writing = false;
    heard();
    say(`Nothing was written. ${error.message}`);
    offer();
  }
}

// --- news of the files -----------------------------------------------------------------------------

function listen() {
  const events = new EventSource("events");
  events.addEventListener("files", (event) => {
    stamp = JSON.parse(event.data);
    if (!writing) heard();
  });
  events.addEventListener("error", () => say("The server has ended: type `pipeline open` again."));
}

function heard() {
  const { shown } = steps;
  if (stamp.report && stamp.report !== shown.report) location.reload();
  const changed = stamp.config !== shown.config || stamp.data !== shown.data;
  button("run").hidden = Boolean(stamp.report) && !changed;
  if (!stamp.report) say("The report is gone: \"Run\" writes it again.");
  else if (changed) say("The configuration or a log was changed; \"Run\" brings the results here.");
}

// --- the page ----------------------------------------------------------------------------------------

// One question of a triad at a time: of those that wait meanwhile the newest alone is asked.
const running = {}, newest = {};
async function ask(where, question) {
  const { triad } = question, mine = newest[triad] = {};
  await running[triad];
  if (newest[triad] !== mine) return new Promise(() => {});
  const answer = asked(where, { ...question, state: steps.state() });
  running[triad] = answer.catch(() => {});
  const refitted = await answer;
  for (const name of ["residual", "left_out"]) refitted[name] = refitted[name].map((value) => value ?? NaN);
  return refitted;
}

// A button behind every command of an answer that can be done on the page.
function doneHere(pattern, text, act) {
  for (const line of document.querySelectorAll(".answer pre")) {
    const match = pattern.exec(line.textContent);
    if (!match) continue;
    const here = Object.assign(document.createElement("button"), { type: "button", textContent: text });
    here.addEventListener("click", () => act(match[1]));
    line.after(here);
  }
}

window.workbench = {
  ask,
  begin(page) {
    drawing.short = page.short;
    for (const section of page.sections) {
      const update = section.update.bind(section), show = section.show.bind(section);
      section.update = () => { section.root.setAttribute("aria-busy", "true"); section.settled = false; steps.remember(); update(); };
      section.show = (refitted) => { section.root.removeAttribute("aria-busy"); section.settled = true; show(refitted); };
      section.settled = true;
      new Bench(section, benches, say, write);
      section.root.querySelector("details.sound")?.setAttribute("open", "");
    }
    showClips((setting) => {
      const charts = document.querySelector(`[data-rate="${CSS.escape(setting)}"]`);
      const place = charts?.insertBefore(document.createElement("figure"), charts.children[1] ?? null);
      place?.classList.add("card");
      return place;
    });
    for (const section of page.rateSections) {
      section.boxes.forEach((box) => box.addEventListener("change", steps.remember));
    }
    // The specific force in the poses of the gyroscope is the accelerometer's.
    const [first, second] = ["accelerometer", "gyroscope"].map((name) =>
      page.sections.find((section) => section.triad.triad === name));
    if (first && second) first.listeners.push(() => second.update());
    for (const name of Object.keys(actions)) button(name).addEventListener("click", actions[name]);
    document.addEventListener("keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") return;
      const name = event.shiftKey ? "redo" : "undo";
      if (!button(name).disabled) { event.preventDefault(); actions[name](); }
    });
    doneHere(/^pipeline add .* (\S+\.\S+)$/, "Tick it here", (target) => {
      page.tick(target);
      say(`${target} is ticked; "Write to config" saves it.`);
    });
    doneHere(/^pipeline import .* --into /, "Bring them here", further.open);
    further.begin(steps.state, offer);
    bar.querySelector("[data-bench-folder]").hidden = !location.pathname.startsWith("/session/");
    steps.begin(page, benches, (isStep) => {
      if (isStep) {
        say("");
        heard();
      }
      offer();
      further.update();
    });
    const written = steps.kept("written");
    if (written) {
      const undo = steps.back ? ' Undo shows what was before; "Write to config" writes that.' : "";
      say(written.lines.length ? `${written.path} was changed.${undo}` : "Nothing to write.", written.lines);
    }
    steps.drop("written");
    offer();
    listen();
  },
};
})();
