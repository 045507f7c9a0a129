// Axes for dots and lines, and questions to the server: what all pages of the workbench share.
const drawing = (() => {
"use strict";
const SVG = "http://www.w3.org/2000/svg", WIDTH = 400, HEIGHT = 260, LEFT = 52, FOOT = 34, TOP = 20;

function node(name, attributes = {}, text = "") {
  const made = document.createElementNS(SVG, name);
  Object.entries(attributes).forEach(([key, value]) => made.setAttribute(key, value));
  if (text) made.textContent = text;
  return made;
}

const span = (values) => {
  const finite = values.filter(Number.isFinite);
  const low = Math.min(...finite), high = Math.max(...finite), room = 0.06 * (high - low) || 1;
  return [low - room, high + room];
};

// Round values within a range, three to six of them.
function ticks(low, high) {
  const raw = (high - low) / 4, decade = 10 ** Math.floor(Math.log10(raw));
  const step = decade * [1, 2, 5, 10].find((each) => decade * each >= raw * (1 - 1e-9));
  const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => Number(((first + i) * step).toPrecision(12)));
}

const exact = (value) => String(value).replace("-", "−");

// The same of a logarithmic axis: places, which are logarithms, and texts.
function logTicks(low, high) {
  const values = high - low < 2 ? ticks(10 ** low, 10 ** high)
    : ticks(low, high).filter(Number.isInteger).map((place) => Number((10 ** place).toPrecision(1)));
  return values.map((value) => [Math.log10(value), exact(value)]);
}

// Axes from these ranges, ``marks`` being places and texts of the upward one; gives the drawing and what turns values into places.
function plot([left, right], [low, high], across, upward, words, marks = null) {
  const svg = node("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": words, class: "chart" });
  const x = (value) => LEFT + (value - left) / (right - left) * (WIDTH - LEFT - 8);
  const y = (value) => HEIGHT - FOOT - (value - low) / (high - low) * (HEIGHT - FOOT - TOP);
  for (const value of ticks(left, right)) {
    svg.append(node("text", { class: "tick", x: x(value), y: HEIGHT - FOOT + 14, "text-anchor": "middle" }, exact(value)));
  }
  for (const [value, text] of marks ?? ticks(low, high).map((each) => [each, exact(each)])) {
    svg.append(node("text", { class: "tick", x: LEFT - 5, y: y(value) + 4, "text-anchor": "end" }, text));
  }
  svg.append(node("text", { class: "title", x: (LEFT + WIDTH) / 2, y: HEIGHT - 4, "text-anchor": "middle" }, across),
    node("text", { class: "title", x: 2, y: 10 }, upward));
  if (!marks && low < 0 && high > 0) svg.append(node("path", { class: "zero", d: `M${LEFT} ${y(0)}H${WIDTH - 8}` }));
  return { svg, x, y };
}

// The course of a line through points, in the places that a plot has for them.
const course = ({ x, y }, xs, ys) => (xs.length
  ? `M${xs.map((value, i) => `${x(value).toFixed(1)} ${y(ys[i]).toFixed(1)}`).join("L")}` : "");

// The answer of the server in JSON; what it refuses is an error with its words.
async function answered(request) {
  const response = await request.catch(() => { throw new Error("The server has ended: type `pipeline open` again."); });
  const text = await response.text();
  if (!response.headers.get("content-type")?.includes("json")) throw new Error(text || `no answer (${response.status})`);
  const answer = JSON.parse(text);
  if (!response.ok) throw new Error(answer.error);
  return answer;
}

const asked = (where, question = {}) => answered(fetch(where, { method: "POST",
  headers: { "content-type": "application/json" }, body: JSON.stringify(question) }));

// A file to the server, as it is.
const sent = (where, file) => answered(fetch(where, { method: "POST", body: file }));

const short = (value) => String(Number(value.toPrecision(3))).replace("-", "−");
return { node, span, plot, course, logTicks, answered, asked, sent, short, HEIGHT, FOOT };
})();
