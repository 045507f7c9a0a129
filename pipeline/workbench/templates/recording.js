// The live panel of `pipeline record`, drawn from the events of its server.
(() => {
"use strict";
const part = (name) => document.querySelector(`[data-${name}]`);
const TRIADS = [["accelerometer", "m/s²", 1, 0], ["gyroscope", "°/s", 180 / Math.PI, 3]];
let shown = "", known = "";

// A text that a screen reader announces changes only when it is another one.
const say = (name, text) => { if (part(name).textContent !== text) part(name).textContent = text; };

// The sds of a triad from pose to pose, each on an axis of powers of ten.
function sds({ triad, poses, sds: all }) {
  return all.map(({ name, unit, values }) => {
    const logs = values.map(Math.log10), range = drawing.span(logs);
    const chart = drawing.plot(drawing.span(poses), range, `poses of the ${triad}`, `sd of its ${name} [${unit}]`,
      `Sd of the ${name} of the ${triad} by ${poses.at(-1)} poses: ${drawing.short(values.at(-1))} ${unit}.`, drawing.logTicks(...range));
    chart.svg.append(drawing.node("path", { d: drawing.course(chart, poses, logs) }),
      ...poses.map((n, i) => drawing.node("circle", { cx: chart.x(n), cy: chart.y(logs[i]), r: 3 })));
    return chart.svg;
  });
}

function determined(outlook) {
  const now = JSON.stringify(outlook);
  if (now === known) return;
  known = now;
  part("known").hidden = !outlook.some((each) => each.poses_now);
  say("enough", outlook.filter((each) => each.enough).map((each) => `✓ ${each.triad}: ${each.enough}.`).join(" "));
  part("advice").replaceChildren(...outlook.filter((each) => each.advice).map((each) => {
    const line = document.createElement("p");
    line.textContent = `${each.advice}.`;
    return line;
  }));
  part("sds").replaceChildren(...outlook.filter((each) => each.poses.length).map((each) => {
    const both = document.createElement("div");
    both.append(...sds(each));
    return both;
  }));
}

// One picture after the other, as fast as the browser takes them.
function watch(words) {
  say("camera-words", words);
  if (!words || !part("camera").hidden) return;
  part("camera").hidden = false;
  let n = 0;
  const next = () => { n += 1; part("picture").src = `picture?${n}`; };
  part("picture").addEventListener("load", () => { part("picture").hidden = false; setTimeout(next, 100); });
  part("picture").addEventListener("error", () => { part("picture").hidden = true; setTimeout(next, 2000); });
  next();
}

function draw({ view, traces, lines, camera, outlook }) {
  say("lines", lines.join("\n"));
  watch(camera);
  determined(outlook);
  if (!view.phase) return;
  say("message", `${view.phase}: ${view.message}`);
  document.querySelector("progress").value = view.progress;
  const done = view.directions.filter((each) => each.recorded).length;
  say("line", `plate ${view.plate}: ${done} of ${view.directions.length} poses; now up: ${view.up || "?"}; `
    + `${drawing.short(view.rpm)} rpm by data sheet; ${view.rate_hz.toFixed(1)} samples/s, ${view.damaged} damaged`);
  part("directions").replaceChildren(...view.directions.map(({ name, recorded }) => {
    const item = document.createElement("li");
    item.textContent = `${recorded ? "✓" : "·"} ${name}`;
    item.className = recorded ? "recorded" : "";
    return item;
  }));
  say("lay", view.next ? `lay next: ${view.next.name}` : "complete");
  if (shown !== (view.next?.name ?? "")) {
    shown = view.next?.name ?? "";
    part("drawing").innerHTML = view.next?.drawing ?? "";  // made by the program from numbers alone
  }
  part("traces").replaceChildren(...TRIADS.map(([triad, unit, factor, first]) => {
    const values = traces.slice(first, first + 3).map((axis) => axis.map((value) => value * factor));
    const chart = drawing.plot([0, Math.max(values[0].length, 2)], drawing.span(values.flat()), "the last readings",
      `${triad} [${unit}]`, `The last readings of the ${triad}.`);
    chart.svg.append(...values.map((axis, a) => drawing.node("path", {
      class: "xyz"[a], d: drawing.course(chart, [...axis.keys()], axis) })));
    return chart.svg;
  }));
}

const events = new EventSource("events");
events.onmessage = (event) => draw(JSON.parse(event.data));
events.onerror = () => say("message", "The recording has ended, or its server.");
})();
