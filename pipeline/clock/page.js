"use strict";
const RATE = $rate_rad_s, CHUNK_MS = 1000;
const canvas = document.getElementById("c"), pen = canvas.getContext("2d");
// Unequal wedges: [from, to, inner, outer, grey]; one broad hand that reaches the rim.
const WEDGES = [[.00, .30, .20, .92, 245], [.95, 1.25, .30, .60, 190], [1.9, 2.6, .62, .88, 60],
                [3.1, 3.3, .25, .80, 170], [3.9, 4.7, .40, .58, 50], [5.2, 5.5, .55, .90, 205]];
let half = 0, refreshes = [], posted = 0;

function fit() {
  canvas.width = innerWidth; canvas.height = innerHeight;
  half = .45 * Math.min(innerWidth, innerHeight);
}

function wedge(from, to, inner, outer, grey) {
  pen.fillStyle = "rgb(" + grey + "," + grey + "," + grey + ")";
  pen.beginPath();
  pen.arc(0, 0, outer * half, -to, -from);
  pen.arc(0, 0, inner * half, -from, -to, true);
  pen.fill();
}

// The hand at an angle, counter-clockwise from the right.
function draw(angle) {
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.fillStyle = "#202020";
  pen.fillRect(0, 0, canvas.width, canvas.height);
  // What stands still: by it a camera that sways is seen to sway.
  pen.fillStyle = "#c0c0c0";
  const side = half / 9, far = 1.5 * side;
  for (const [x, y, w, h] of [[far, far, 2, 1], [canvas.width - far, 1.6 * far, 1, 2],
                              [1.8 * far, canvas.height - far, 1, 1],
                              [canvas.width - far, canvas.height - far, 2, 2]])
    pen.fillRect(x - w * side / 2, y - h * side / 2, w * side, h * side);
  pen.translate(canvas.width / 2, canvas.height / 2);
  wedge(0, 2 * Math.PI, 0, 1, 115);
  pen.rotate(-angle);
  for (const part of WEDGES) wedge(...part);
}

async function post(list) {
  try {
    await fetch("refreshes", {method: "POST", body: JSON.stringify(
      {now: performance.now(), refreshes: list})});
  } catch (error) {
    document.getElementById("p").textContent = "The program has ended; this window can be closed.";
  }
}

function refresh(time) {
  draw((RATE * time / 1000) % (2 * Math.PI));
  refreshes.push(time);
  if (time - posted > CHUNK_MS) {
    post(refreshes);
    refreshes = []; posted = time;
  }
  requestAnimationFrame(refresh);
}

addEventListener("resize", fit);
fit();
requestAnimationFrame(refresh);
