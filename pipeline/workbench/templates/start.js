// The page of a folder: its sessions, and logs that are brought.
(() => {
"use strict";
const { asked } = drawing;
const part = (name) => document.querySelector(`[data-${name}]`);
const form = part("use"), brought = part("brought");
let listed = "";

const cell = (row, text) => { row.insertCell().textContent = text; };

// The list is what the files are now; it is drawn anew where they have changed.
async function list() {
  const { sessions } = await drawing.answered(fetch("sessions"));
  if (JSON.stringify(sessions) === listed) return;
  listed = JSON.stringify(sessions);
  part("sessions").replaceChildren(...sessions.map((session) => {
    const row = document.createElement("tr"), open = document.createElement("button");
    const verdicts = Object.entries(session.verdicts).map(([triad, text]) => `${triad}: ${text}`);
    open.className = "link";
    open.textContent = session.title;
    open.setAttribute("aria-label", `${session.was_run ? "open" : "run and open"} ${session.title}, ${session.path}`);
    open.addEventListener("click", () => show(session.number, part("sessions-words")));
    row.insertCell().append(open);
    cell(row, session.path);
    cell(row, session.problem || verdicts.join("; ") || "not run yet");
    return row;
  }));
  part("sessions-words").textContent = sessions.length ? "" : "There is none yet: bring a log, or type `pipeline demo`.";
}

async function show(number, words) {
  words.textContent = "The session is run …";
  try {
    location.href = (await asked("open", { number })).address;
  } catch (error) {
    words.textContent = error.message;
  }
}

async function guess(refused = []) {
  brought.textContent = "The files are read …";
  const answer = await asked("guess", { scale: Number(form.scale.value) || null });
  brought.textContent = [`${dropped.count} file${dropped.count === 1 ? "" : "s"}.`, ...refused, ...answer.passed_over].join(" ");
  part("lines").textContent = answer.lines.join("\n");
  part("plots").replaceChildren(...answer.plots.map(drawn));
  part("scale").hidden = answer.scales.length === 0;
  if (answer.scales.length) {
    form.scale.replaceChildren(new Option("not known", ""), ...answer.scales.map(({ per_deg: scale, says }) =>
      new Option(says, scale)));
  }
  part("of-session").hidden = !answer.is_session;
  form.hidden = false;
  part("clips").replaceChildren();
  await showClips(() => {
    const place = part("clips").appendChild(document.createElement("figure"));
    place.className = "card";
    return place;
  });
}

function drawn({ name, triad, unit, time_s: time, values }) {
  const chart = drawing.plot(drawing.span(time), drawing.span(values.flat()), `${name}: time [s]`,
    `${triad} [${unit}]`, `${triad} of ${name}, axis by axis against time.`);
  chart.svg.append(...values.map((axis, a) => drawing.node("path", { class: "xyz"[a], d: drawing.course(chart, time, axis) })));
  return chart.svg;
}

form.addEventListener("submit", async (event) => {
  event.preventDefault();
  const words = part("used"), number = (field) => (form[field].value === "" ? null : Number(form[field].value));
  words.textContent = "The configuration is tried …";
  try {
    const answer = await asked("use", { name: form.name.value, latitude: number("latitude"),
      height: number("height") ?? 0, scale: number("scale") });
    part("text").textContent = answer.text;
    part("text").hidden = false;
    words.textContent = [`${answer.path} was written.`, ...answer.changes, answer.fault ?? ""].join(" ");
    dropped.clear();
    await list();
    if (!answer.fault) await show(answer.number, words);
  } catch (error) {
    words.textContent = error.message;
  }
});
form.scale.addEventListener("change", () => guess());
part("forget").addEventListener("click", async () => {
  await dropped.forget();
  form.hidden = true;
  brought.textContent = "Forgotten: nothing is kept here.";
});
dropped.begin(part("drop"), part("files"), part("folder"), (text) => { brought.textContent = text; }, (refused) =>
  guess(refused).catch((error) => { brought.textContent = [...refused, error.message].join(" "); }));
const again = () => list().finally(() => setTimeout(again, 1000)).catch(() => {});
again();
})();
