// The script of the page; its modules, in the order of their use, are put in here at rendering.
(() => {
"use strict";
// Columns of numbers come as 32-bit numbers in base64.
const unpacked = (text) => Array.from(
  new Float32Array(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer));
const data = JSON.parse(document.getElementById("refit-data").textContent,
  (_, value) => (value && value.f32 ? unpacked(value.f32) : value));
const {
  shown_sd: SHOWN_SD,  // residual charts show at least this many typical sds
  nice: NICE,          // limits of an axis, in any decade
} = data.constants;
// What a served page asks with, a function of the question that gives a promise; null in a file.
const asks = window.workbench?.ask ?? null;

{% include "script/numbers.js" %}

{% include "script/refits.js" %}

{% include "script/tiles.js" %}

{% include "script/residual_chart.js" %}

{% include "script/fall.js" %}

{% include "script/section.js" %}

{% include "script/rate_section.js" %}

{% include "script/sphere.js" %}

{% include "script/poses.js" %}

{% include "script/glossary.js" %}

{% include "script/layers.js" %}

const sections = data.triads.map((triad) => new Section(triad, data.config));
const rateSections = data.rates.map((rate) => new RateSection(rate, data.config));
sections.forEach((section) => new Poses(section));

// The box of gyroscope.g_sensitivity or rate.17rpm.once_per_rev.
function tick(target) {
  const [triad, ...name] = target.split(".");
  sections.filter((section) => section.triad.triad === triad)
    .forEach((section) => section.tick(name.join(".")));
  rateSections.filter((section) => triad === "rate" && name[0] === section.rate.setting)
    .forEach((section) => section.tick(name[1]));
}

// A copy of the file still names the files of the session that it was made of.
document.querySelector("[data-moved]").hidden = location.protocol !== "file:"
  || decodeURIComponent(new URL(".", location.href).href) === decodeURIComponent(`${data.made_in}/`);

window.workbench?.begin({ sections, rateSections, short, tick });

// report.html#tick=gyroscope.g_sensitivity,rate.17rpm.once_per_rev opens with these boxes ticked.
const ticks = /^#tick=(.*)$/.exec(decodeURIComponent(location.hash));
(ticks ? ticks[1].split(",") : []).forEach(tick);
})();
