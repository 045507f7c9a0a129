// The script of the page; its modules, in the order of their use, are put in here at rendering.
(() => {
"use strict";
// Columns of numbers come as 32-bit numbers in base64.
const unpacked = (text) => Array.from(
  new Float32Array(Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer));
const data = JSON.parse(document.getElementById("refit-data").textContent,
  (_, value) => (value && value.f32 ? unpacked(value.f32) : value));
const {
  visible_share: VISIBLE_SHARE,    // of a signature, below which it cannot be determined
  smallest_block: SMALLEST_BLOCK,  // 1 - largest leverage of a pose
  misfit_p_value: MISFIT_P_VALUE,  // below it the Birge ratio multiplies the sds
  fewest_dof: FEWEST_DOF,          // with fewer the page's refit is not exact
  shown_sd: SHOWN_SD,              // residual charts show at least this many typical sds
  nice: NICE,                      // limits of an axis, in any decade
} = data.constants;

{% include "script/linear_algebra.js" %}

{% include "script/f_distribution.js" %}

{% include "script/refit.js" %}

{% include "script/numbers.js" %}

{% include "script/leave_out.js" %}

{% include "script/tiles.js" %}

{% include "script/judgement.js" %}

{% include "script/residual_chart.js" %}

{% include "script/fall.js" %}

{% include "script/section.js" %}

{% include "script/rate_section.js" %}

{% include "script/sphere.js" %}

{% include "script/poses.js" %}

{% include "script/glossary.js" %}

const sections = data.triads.map((triad) => new Section(triad, data.config));
const rateSections = data.rates.map((rate) => new RateSection(rate, data.config));
sections.forEach((section) => new Poses(section));

// report.html#tick=gyroscope.g_sensitivity,rate.17rpm.once_per_rev opens with these boxes ticked.
const ticks = /^#tick=(.*)$/.exec(decodeURIComponent(location.hash));
for (const target of ticks ? ticks[1].split(",") : []) {
  const [triad, ...name] = target.split(".");
  sections.filter((section) => section.triad.triad === triad)
    .forEach((section) => section.tick(name.join(".")));
  rateSections.filter((section) => triad === "rate" && name[0] === section.rate.setting)
    .forEach((section) => section.tick(name[1]));
}
})();
