// A clip with what was measured drawn on it, on one axis of time with the gyroscope.
class ClipPlayer {
  constructor(place, clips) {
    this.clips = clips;
    this.place = place;
    place.innerHTML = PLAYER;
    place.classList.add("player");
    const fill = (select, names) => select.replaceChildren(...names.map((name, i) => new Option(name, i)));
    fill(this.part("clip"), clips.map((clip) => clip.name));
    this.part("clip").parentElement.hidden = clips.length < 2;
    const logs = () => {
      const { logs: names, log } = this.clip;
      fill(this.part("log"), names);
      this.part("log").selectedIndex = log;
      this.part("log").parentElement.hidden = names.length === 0;
    };
    logs();
    this.part("clip").addEventListener("change", () => { logs(); this.load(); });
    this.part("log").addEventListener("change", () => this.load());
    this.part("show").addEventListener("click", () => this.load());
    this.part("play").addEventListener("click", () => this.play(!this.playing));
    this.part("at").addEventListener("input", () => this.show(Number(this.part("at").value)));
  }

  part(name) { return this.place.querySelector(`[data-player-${name}]`); }

  get clip() { return this.clips[this.part("clip").selectedIndex]; }

  async load() {
    this.play(false);
    this.part("words").textContent = "The clip is read …";
    const log = this.part("log").selectedIndex;
    try {
      this.course = await drawing.asked("clip", { number: this.clip.number, log: log < 0 ? null : log });
    } catch (error) {
      this.part("words").textContent = error.message;
      return;
    }
    this.part("show").hidden = true;
    this.part("stage").hidden = false;
    this.part("at").max = this.course.pictures.length - 1;
    this.draw();
    this.show(Math.min(Number(this.part("at").value), this.course.pictures.length - 1));
  }

  // In the clip's own time, whatever the browser can keep up with.
  play(is) {
    this.playing = is;
    this.part("play").textContent = is ? "Pause" : "Play";
    if (!is) return;
    const { pictures } = this.course, last = pictures.length - 1, input = this.part("at");
    let k = Number(input.value) < last ? Number(input.value) : 0;
    const begun = performance.now() / 1000 - pictures[k];
    const step = () => {
      if (!this.playing) return;
      const now = performance.now() / 1000 - begun;
      while (k < last && pictures[k + 1] <= now) k += 1;
      if (this.part("picture").complete) this.show(k);
      if (k < last) requestAnimationFrame(step);
      else this.play(false);
    };
    step();
  }

  draw() {
    const { so_far: soFar, turns, gyroscope, pictures } = this.course;
    const lines = [turns, soFar, ...(gyroscope ? [gyroscope] : [])];
    const range = (name) => drawing.span(lines.flatMap((line) => line[name]));
    const [low, high] = range("rpm"), times = [...lines.flatMap((line) => line.time_s), 0, pictures.at(-1)];
    const chart = this.plot = drawing.plot([Math.min(...times), Math.max(...times)], [low, high], "time [s]", "rate of the plate [rpm]",
      "Rate of the plate against time: by the clip from turn to turn, by the clip so far, and by the gyroscope.");
    const { svg, x } = chart;
    const path = (name, { time_s: time, rpm }) => drawing.node("path", { class: name, d: drawing.course(chart, time, rpm) });
    if (gyroscope) svg.append(path("of-gyroscope", gyroscope));
    svg.append(path("of-turns", turns), path("to-come", soFar));
    this.past = svg.appendChild(path("so-far", soFar));
    this.cursor = svg.appendChild(drawing.node("path", { class: "cursor" }));
    svg.addEventListener("click", (event) => {
      const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
      this.play(false);
      const k = this.course.pictures.findIndex((time) => x(time) >= place.x);
      this.show(k < 0 ? this.course.pictures.length - 1 : k);
    });
    this.part("chart").replaceChildren(svg);
  }

  show(k) {
    const { pictures, so_far: soFar, gyroscope, rpm, sd } = this.course, now = pictures[k];
    this.part("picture").src = `clip/${this.clip.number}/${k}`;
    this.part("at").value = k;
    this.part("at").setAttribute("aria-valuetext", `${now.toFixed(2)} s`);
    this.cursor.setAttribute("d", `M${this.plot.x(now).toFixed(1)} 16V${drawing.HEIGHT - drawing.FOOT}`);
    const past = soFar.time_s.filter((time) => time <= now).length;
    this.past.setAttribute("d", drawing.course(this.plot, soFar.time_s.slice(0, past), soFar.rpm));
    const words = [`${now.toFixed(2)} s:`, past ? `${soFar.rpm[past - 1].toFixed(4)} rpm so far` : "no whole turn yet",
      `(${rpm.toFixed(4)} ± ${sd.toPrecision(2)} over the whole clip).`];
    if (gyroscope) {
      const i = gyroscope.time_s.findIndex((time) => time >= now);
      words.push(i < 0 ? "The log of the gyroscope ends before." : `The gyroscope, ${gyroscope.how}, reads ${gyroscope.rpm[i].toFixed(3)} rpm.`,
        gyroscope.one_clock ? "Both are on one clock." : "Clip and log each count from their own beginning.");
    }
    this.part("words").textContent = words.join(" ");
  }
}

const PLAYER = `<style>
.player img { width: 100%; height: auto; display: block; border-radius: .4rem; } .player .controls { display: flex; gap: .75rem; align-items: center; max-width: none; }
.player .controls button { margin: 0; min-width: 5rem; } .player .controls input { flex: 1; } .player select { max-width: 14rem; font: inherit; }
.player path { fill: none; stroke-width: 1.5; } .player .of-gyroscope { stroke: var(--run1); color: var(--run1); } .player .of-turns { stroke: var(--run2); color: var(--run2); }
.player .so-far { stroke: var(--run0); color: var(--run0); stroke-width: 2.5; } .player .to-come { stroke: var(--ghost); stroke-dasharray: 3 3; } .player .cursor { stroke: currentColor; }
.player svg { cursor: pointer; width: 100%; height: auto; display: block; } .player .legend li { font-weight: 600; }
</style><figcaption>The clip with what was measured, on one time axis with the gyroscope</figcaption>
<p><label>clip <select data-player-clip></select></label> <label>gyroscope in <select data-player-log></select></label></p>
<button type="button" data-player-show>Show the clip</button>
<div data-player-stage hidden>
<img data-player-picture alt="One frame of the clip with rim, spindle, mark, angle and rate drawn on it.">
<p class="controls"><button type="button" data-player-play>Play</button><input type="range" min="0" value="0" data-player-at aria-label="time in the clip"></p>
<div data-player-chart></div>
<ul class="legend"><li class="of-gyroscope">gyroscope</li><li class="of-turns">clip, turn by turn</li><li class="so-far">clip, so far</li></ul>
</div>
<p data-player-words></p>`;

// A player in the place of every setting whose clips are there.
async function showClips(placeOf) {
  const { clips } = await drawing.asked("clips", {});
  for (const setting of new Set(clips.map((clip) => clip.setting))) {
    const place = placeOf(setting);
    if (place) new ClipPlayer(place, clips.filter((clip) => clip.setting === setting));
  }
}
