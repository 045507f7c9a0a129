// The sphere of poses: rotated by mouse, finger or arrow keys, coloured by the signed residual.
const SVG = document.querySelector("svg").namespaceURI;
const RADIUS = 100;
const APART = 0.09;          // rad between poses of several runs in one attitude
const STEP = Math.PI / 18;   // rad of an arrow key
const GREAT_CIRCLES = [[[1, 0, 0], [0, 1, 0]], [[0, 1, 0], [0, 0, 1]], [[0, 0, 1], [1, 0, 0]]];
const FIRST_SIGHT = [0.75, 0.45, 0.5];  // from where the sphere is seen at first, z upwards

const element = (name, attributes = {}, text = "") => {
  const node = document.createElementNS(SVG, name);
  Object.entries(attributes).forEach(([key, value]) => node.setAttribute(key, value));
  if (text) node.textContent = text;
  return node;
};
const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
const norm = (a) => Math.sqrt(dot(a, a));
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unitVector = (a) => a.map((value) => value / norm(a));

class Sphere {
  // ``root`` holds the stage; ``pick(k)`` is called with the pose that is touched.
  constructor(root, poses, pick) {
    this.root = root;
    this.poses = poses;
    this.pick = pick;
    const toward = unitVector(FIRST_SIGHT), right = unitVector(cross([0, 0, 1], toward));
    this.view = [right, cross(toward, right), toward];  // right, up and towards the reader
    this.run = "";
    this.at = spread(poses);
    this.svg = element("svg", { viewBox: "-132 -122 264 244", class: "ball" });
    this.back = this.svg.appendChild(element("g"));
    this.svg.appendChild(element("circle", { r: RADIUS, class: "globe" }));
    this.front = this.svg.appendChild(element("g"));
    this.marks = poses.up.map((_, k) => {
      const mark = element("g", { "data-i": k, class: "pose" });
      mark.append(element("title"), element("circle", { r: 11, class: "reach" }), element("path"));
      return mark;
    });
    this.hollow = poses.excluded.filter((each) => each.up).map(({ shown, run, up, in_sd: inSd }) => {
      const mark = element("g", { class: "pose excluded" });
      mark.append(element("title", {}, `${shown}: excluded; ${short(inSd)} sd by the fit without it`),
        element("path", { d: OUTLINES.excluded }));
      return { mark, run, up };
    });
    root.querySelector("[data-stage]").append(this.svg);
    this.listen(root.querySelector("[data-stage]"));
  }

  listen(stage) {
    let from = null, moved = 0;
    stage.addEventListener("pointerdown", (event) => {
      from = [event.clientX, event.clientY];
      moved = 0;
      if (event.target.closest("svg")) stage.setPointerCapture(event.pointerId);
      this.under = event.target.closest("[data-i]");
    });
    stage.addEventListener("pointermove", (event) => {
      if (!from) return;
      const dx = event.clientX - from[0], dy = event.clientY - from[1];
      moved += Math.abs(dx) + Math.abs(dy);
      from = [event.clientX, event.clientY];
      const scale = 264 / this.svg.getBoundingClientRect().width / RADIUS;
      this.rotate(dx * scale, dy * scale);
    });
    stage.addEventListener("pointerup", () => {
      if (from && moved < 5 && this.under) this.pick(Number(this.under.dataset.i));
      from = null;
    });
    stage.addEventListener("pointercancel", () => { from = null; });
    stage.addEventListener("keydown", (event) => {
      const by = { ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP],
        ArrowDown: [0, STEP] }[event.key];
      if (by) this.rotate(...by);
      else if (event.key === "Enter" || event.key === " ") this.pickNearest();
      else return;
      event.preventDefault();
    });
  }

  // Right about the vertical of the screen, down about its horizontal.
  rotate(right, down) {
    const [cr, sr, cd, sd] = [Math.cos(right), Math.sin(right), Math.cos(down), Math.sin(down)];
    const [x, y, z] = this.view;
    const turned = [x.map((v, i) => cr * v + sr * z[i]), y, x.map((v, i) => cr * z[i] - sr * v)];
    this.view = [
      turned[0],
      turned[1].map((v, i) => cd * v - sd * turned[2][i]),
      turned[1].map((v, i) => sd * v + cd * turned[2][i]),
    ].map(unitVector);
    this.draw();
  }

  // The pose in the middle of the view.
  pickNearest() {
    let best = -1, depth = -2;
    this.at.forEach((up, k) => {
      if (up && this.shown(k) && dot(up, this.view[2]) > depth) {
        best = k;
        depth = dot(up, this.view[2]);
      }
    });
    if (best >= 0) this.pick(best);
  }

  // Turn the pose to the front.
  face(k) {
    const up = this.at[k];
    if (!up || dot(up, this.view[2]) > 0.5) return;
    const aside = cross(up, this.view[0]);
    const y = unitVector(norm(aside) > 0.2 ? aside : cross(up, this.view[1]));
    this.view = [cross(y, up), y, up];
    this.draw();
  }

  shown(k) { return this.run === "" || this.poses.runs[k] === this.run; }

  show(run) { this.run = run; this.draw(); }

  // ``value`` and ``text`` of every pose; ``limit`` is the end of the colour scale, in sds.
  colour(value, text, kind, limit, out) {
    this.marks.forEach((mark, k) => {
      const share = Math.min(Math.abs(value[k]) / limit, 1);
      mark.setAttribute("class", `pose ${kind[k]}${out.has(k) ? " left-out" : ""}`
        + `${mark.classList.contains("picked") ? " picked" : ""}`);
      mark.style.setProperty("--share", `${(25 + 75 * share).toFixed(0)}%`);
      mark.querySelector("path").setAttribute("d", OUTLINES[kind[k]]);
      mark.dataset.size = (0.75 + 0.75 * Math.sqrt(share)).toFixed(2);
      mark.querySelector("title").textContent = text[k];
    });
    this.draw();
  }

  project(up) { return this.view.map((row) => dot(row, up)); }

  draw() {
    const back = [], front = [];
    for (const [a, b] of GREAT_CIRCLES) {
      const [near, far] = this.circle(a, b);
      back.push(element("path", { class: "meridian far", d: far }));
      front.push(element("path", { class: "meridian", d: near }));
    }
    this.poses.expected.forEach(({ up, covered }) => {
      const [x, y, z] = this.project(up);
      const corner = up.filter((v) => Math.abs(v) > 0.3).length === 3;
      const ring = element("path", {
        class: `natural${corner ? " corner" : ""}${covered ? "" : " missing"}${z < 0 ? " far" : ""}`,
        d: covered || corner ? "M-12 0a12 12 0 1 0 24 0a12 12 0 1 0-24 0z" : "M-7-7L7 7M7-7L-7 7",
        transform: `translate(${(RADIUS * x).toFixed(1)} ${(-RADIUS * y).toFixed(1)})`,
      });
      (z < 0 ? back : front).push(ring);
    });
    const marks = this.at.flatMap((up, k) => (up && this.shown(k) ? [[this.project(up), k]] : []));
    for (const [[x, y, z], k] of marks.sort((a, b) => a[0][2] - b[0][2])) {
      const size = Number(this.marks[k].dataset.size || 1) * (0.85 + 0.15 * z);
      this.marks[k].classList.toggle("far", z < 0);
      this.marks[k].setAttribute("transform",
        `translate(${(RADIUS * x).toFixed(1)} ${(-RADIUS * y).toFixed(1)}) scale(${size.toFixed(2)})`);
      (z < 0 ? back : front).push(this.marks[k]);
    }
    for (const { mark, run, up } of this.hollow) {
      if (this.run !== "" && run !== this.run) continue;
      const [x, y, z] = this.project(up);
      mark.classList.toggle("far", z < 0);
      mark.setAttribute("transform", `translate(${(RADIUS * x).toFixed(1)} ${(-RADIUS * y).toFixed(1)})`);
      (z < 0 ? back : front).push(mark);
    }
    for (const [axis, name] of [[0, "x"], [1, "y"], [2, "z"]]) for (const sign of [1, -1]) {
      const up = [0, 0, 0];
      up[axis] = sign;
      const [x, y, z] = this.project(up);
      (z < 0 ? back : front).push(element("text", {
        class: `axis-letter${z < 0 ? " far" : ""}`, "text-anchor": "middle", dy: 4,
        x: (1.17 * RADIUS * x).toFixed(1), y: (-1.17 * RADIUS * y).toFixed(1),
      }, `${sign > 0 ? "+" : "−"}${name}`));
    }
    this.back.replaceChildren(...back);
    this.front.replaceChildren(...front);
  }

  // A great circle in the plane of a and b: what of it is near, and what is far.
  circle(a, b) {
    const paths = ["", ""], before = [false, false];
    for (let i = 0; i <= 72; i++) {
      const [c, s] = [Math.cos(i * Math.PI / 36), Math.sin(i * Math.PI / 36)];
      const [x, y, z] = this.project(a.map((v, j) => c * v + s * b[j]));
      const side = z >= 0 ? 0 : 1;
      paths[side] += `${before[side] ? "L" : "M"}${(RADIUS * x).toFixed(1)} ${(-RADIUS * y).toFixed(1)}`;
      before[side] = true;
      before[1 - side] = false;
    }
    return paths;
  }
}

// Outlines by the sign: longer than the reference, shorter, within the noise, at rest.
const OUTLINES = {
  above: "M0-7L6.4 4.4H-6.4z", below: "M0 7L6.4-4.4H-6.4z",
  excluded: "M-7 0a7 7 0 1 0 14 0a7 7 0 1 0-14 0z", noise: "M-5 0a5 5 0 1 0 10 0a5 5 0 1 0-10 0z", rest: "M0-6.5L6.5 0L0 6.5L-6.5 0z",
};

// Poses of several runs stand in the same attitudes: each run a little aside, in another direction.
function spread({ up, runs }) {
  const names = [...new Set(runs)];
  if (names.length === 1) return up;
  return up.map((direction, k) => {
    if (!direction) return null;
    const helper = Math.abs(direction[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
    const a = unitVector(cross(direction, helper)), b = cross(direction, a);
    const angle = 2 * Math.PI * names.indexOf(runs[k]) / names.length;
    const [c, s] = [APART * Math.cos(angle), APART * Math.sin(angle)];
    return unitVector(direction.map((value, j) => value + c * a[j] + s * b[j]));
  });
}
