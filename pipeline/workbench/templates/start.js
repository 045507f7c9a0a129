// The page of a folder: its sessions, and logs that are brought.
(() => {
"use strict";
const { asked } = drawing;
const part = (name) => document.querySelector(`[data-${name}]`);
const form = part("use"), brought = part("brought"), AXES = ["x", "y", "z"];
let batch = 0, names = new Set(), listed = "";

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

// Files of one drop keep their names; a name that is there already goes into a folder of its drop.
// What is refused is said, and the others are taken: every folder has a stray file.
async function take(...files) {
  batch += 1;
  const paths = files.map((file) => file.webkitRelativePath || file.name);
  const clash = paths.some((path) => names.has(path)), refused = [];
  for (const [i, file] of files.entries()) {
    brought.textContent = `${i + 1} of ${files.length}: ${paths[i]}`;
    const path = clash ? `drop${batch}/${paths[i]}` : paths[i];
    try {
      await drawing.sent(`bring/${path.split("/").map(encodeURIComponent).join("/")}`, file);
      names.add(path);
    } catch (error) {
      refused.push(error.message);
    }
  }
  const words = [...refused.slice(0, 3), ...(refused.length > 3 ? [`So are ${refused.length - 3} more.`] : [])];
  await guess(words).catch((error) => { brought.textContent = [...words, error.message].join(" "); });
}

async function guess(refused = []) {
  brought.textContent = "The files are read …";
  const answer = await asked("guess", { scale: Number(form.scale.value) || null });
  brought.textContent = [`${names.size} file${names.size === 1 ? "" : "s"}.`, ...refused, ...answer.passed_over].join(" ");
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
  const { svg, x, y } = drawing.plot(drawing.span(time), drawing.span(values.flat()), `${name}: time [s]`,
    `${triad} [${unit}]`, `${triad} of ${name}, axis by axis against time.`);
  values.forEach((axis, a) => svg.append(drawing.node("path", { class: AXES[a],
    d: `M${axis.map((value, i) => `${x(time[i]).toFixed(1)} ${y(value).toFixed(1)}`).join("L")}` })));
  return svg;
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
    names = new Set();
    await list();
    if (!answer.fault) await show(answer.number, words);
  } catch (error) {
    words.textContent = error.message;
  }
});
form.scale.addEventListener("change", () => guess());
part("forget").addEventListener("click", async () => {
  await asked("forget");
  names = new Set();
  form.hidden = true;
  brought.textContent = "Forgotten: nothing is kept here.";
});
drawing.droppable(part("drop"), part("files"), take);
part("folder").addEventListener("change", () => take(...part("folder").files));  // a drop is taken once
const again = () => list().finally(() => setTimeout(again, 1000)).catch(() => {});
again();
})();
