// The live panel of `pipeline record`, drawn from the events of its server.
(() => {
"use strict";
const part = (name) => document.querySelector(`[data-${name}]`);
const TRIADS = [["accelerometer", "m/s²", 1, 0], ["gyroscope", "°/s", 180 / Math.PI, 3]];
let shown = "";

// A text that a screen reader announces changes only when it is another one.
const say = (name, text) => { if (part(name).textContent !== text) part(name).textContent = text; };

function draw({ view, traces, lines }) {
  say("lines", lines.join("\n"));
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
    const { svg, x, y } = drawing.plot([0, Math.max(values[0].length, 2)], drawing.span(values.flat()), "the last readings",
      `${triad} [${unit}]`, `The last readings of the ${triad}.`);
    values.forEach((axis, a) => svg.append(drawing.node("path", { class: "xyz"[a],
      d: `M${axis.map((value, i) => `${x(i).toFixed(1)} ${y(value).toFixed(1)}`).join("L")}` })));
    return svg;
  }));
}

const events = new EventSource("events");
events.onmessage = (event) => draw(JSON.parse(event.data));
events.onerror = () => say("message", "The recording has ended, or its server.");
})();
