// The room of a scenario from above, drawn in metres; what lies in it can be dragged.
const at = (id) => document.getElementById(id);
const canvas = at('room'), pen = canvas.getContext('2d');
const free = new OffscreenCanvas(1, 1);
const between_touches_ms = 80;
const view_m = 1.5;  // of the view's edges
let state = null, held = null, dropping = false, touched_ms = 0, touch = null;

export function connectRoom(send) { touch = (what) => send({do: 'touch', touch: what}); }

export function showRoom(now) {
  state = now;
  const [x0, y0, x1, y1] = state.room;
  Object.assign(canvas.dataset, {room: JSON.stringify(state.room), robot: JSON.stringify(state.robot),
    ball: JSON.stringify(state.balls.find((each) => each.target).center), step: state.step});
  canvas.style.aspectRatio = (x1 - x0) / (y1 - y0);
  const width = Math.round(canvas.clientWidth * devicePixelRatio), height = Math.round(width * (y1 - y0) / (x1 - x0));
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
  draw();
}

export function drop(on) {
  dropping = on;
  canvas.classList.toggle('dropping', on);
  at('drop').setAttribute('aria-pressed', on);
  at('drop').textContent = on ? 'Click on the floor' : 'Drop a box';
}

// ---- drawing

const scale = () => canvas.width / (state.room[2] - state.room[0]);
const hair = () => devicePixelRatio / scale();  // a screen's point, in metres

function path(points, closed = true) {
  pen.beginPath();
  for (const [x, y] of points) pen.lineTo(x, y);
  if (closed) pen.closePath();
}

function circle([x, y], radius) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
}

function line(color, points_wide, dash = []) {
  pen.strokeStyle = color;
  pen.lineWidth = points_wide * hair();
  pen.setLineDash(dash.map((length) => length * hair()));
  pen.stroke();
  pen.setLineDash([]);
}

function fill(color) {
  pen.fillStyle = color;
  pen.fill();
}

function drawFree({frame: [x, y, yaw], low_m: [left, low], cell_m, size, bits}) {
  if (free.width !== size) free.width = free.height = size;
  const bytes = atob(bits), ink = free.getContext('2d'), image = ink.createImageData(size, size);
  for (let k = 0; k < size * size; ++k) {
    if (bytes.charCodeAt(k >> 3) >> (k & 7) & 1) image.data.set([70, 170, 90, 80], 4 * k);
  }
  ink.putImageData(image, 0, 0);
  pen.save();
  pen.translate(x, y);
  pen.rotate(yaw);
  pen.imageSmoothingEnabled = false;
  pen.drawImage(free, left, low, size * cell_m, size * cell_m);
  pen.restore();
}

function drawBeams() {
  const half = state.beam_half_rad;
  for (const [x, y, heading, range, echo] of state.beams) {
    pen.beginPath();
    pen.moveTo(x, y);
    pen.arc(x, y, range, heading - half, heading + half);
    pen.closePath();
    fill('#2b6cb014');
    if (!echo) continue;
    pen.beginPath();
    pen.arc(x, y, range, heading - half, heading + half);
    line('#1d4f91', 2);
  }
}

/// How much larger than it is the ellipse is drawn, so that it can be seen.
function magnified(half_m) {
  for (const factor of [1, 2, 5, 10, 20, 50, 100, 200]) if (factor * half_m > 0.1) return factor;
  return 500;
}

function drawEllipse({center: [x, y], half_m: [a, b], yaw_rad}) {
  const factor = magnified(a);
  pen.beginPath();
  pen.ellipse(x, y, factor * a, factor * b, yaw_rad, 0, 2 * Math.PI);
  fill('#c026d31f');
  line('#c026d3', 1.5);
  at('ellipse').textContent = `where the robot holds the ball to be: 95 % within ${(1000 * a).toFixed(1)} x ${(1000 * b).toFixed(1)} mm, drawn ${factor} times as large`;
}

function drawView([x, y, heading, half]) {
  const edge = (side) => [x + view_m * Math.cos(heading + side * half), y + view_m * Math.sin(heading + side * half)];
  path([edge(1), [x, y], edge(-1)], false);
  line('#92700c', 1.5, [6, 4]);
}

function drawRobot([x, y, yaw]) {
  const [front, rear, half] = state.body_m;
  pen.save();
  pen.translate(x, y);
  pen.rotate(yaw);
  path([[front, half], [-rear, half], [-rear, -half], [front, -half]]);
  fill('#1f2937e6');
  path([[front * 0.8, 0], [0, half * 0.55], [0, -half * 0.55]]);
  fill('#f8fafc');
  pen.restore();
}

function draw() {
  const [x0, y0, x1, y1] = state.room, ball = state.balls.find((each) => each.target);
  pen.setTransform(scale(), 0, 0, -scale(), -x0 * scale(), y1 * scale());
  pen.fillStyle = '#f6f3ec';
  pen.fillRect(x0, y0, x1 - x0, y1 - y0);
  if (state.free) drawFree(state.free);
  for (let x = Math.ceil(x0); x < x1; ++x) { path([[x, y0], [x, y1]], false); line('#0001', 1); }
  for (let y = Math.ceil(y0); y < y1; ++y) { path([[x0, y], [x1, y]], false); line('#0001', 1); }
  drawBeams();
  for (const {points, radius_m} of state.obstacles) {
    radius_m > 0 ? circle(points[0], radius_m) : path(points);
    fill('#8a7a66');
    line('#4a4034', 1);
  }
  path(state.trail, false);
  line('#64748b', 2);
  circle(ball.center, state.goal_m);
  line('#c026d3', 1, [5, 5]);
  for (const {center, radius_m, color} of state.balls) {
    circle(center, Math.max(radius_m, 4 * hair()));
    fill(color);
    line('#0008', 1);
  }
  if (state.ellipse) drawEllipse(state.ellipse);
  drawView(state.view);
  drawRobot(state.robot);
  path(state.intended, false);
  line('#ea7317', 4);
  path(state.passed, false);
  line('#15803d', 2.5);
  path([[x0 + 0.2, y0 + 0.2], [x0 + 1.2, y0 + 0.2]], false);
  line('#000a', 2);
  if (held) {
    circle(held.to, 10 * hair());
    line('#0b62c4', 2, [3, 3]);
  }
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.fillStyle = '#000a';
  pen.font = `${12 * devicePixelRatio}px system-ui, sans-serif`;
  pen.fillText('1 m', 0.2 * scale(), canvas.height - 0.2 * scale() - 5 * devicePixelRatio);
}

// ---- touching

function place(event) {
  const box = canvas.getBoundingClientRect(), [x0, , x1, y1] = state.room, metres = (x1 - x0) / box.width;
  return [x0 + (event.clientX - box.left) * metres, y1 - (event.clientY - box.top) * metres];
}

/// What the hand is on: the ball, an obstacle or the robot, within a finger's width.
function find(point, finger_m) {
  const far = ([x, y]) => Math.hypot(x - point[0], y - point[1]);
  const ball = state.balls.find((each) => each.target);
  if (far(ball.center) < Math.max(ball.radius_m, finger_m)) return {do: 'ball', from: ball.center};
  const robot = state.robot;
  if (far(robot) < Math.max(state.body_m[2], finger_m)) return {do: 'robot', from: robot, yaw_rad: robot[2]};
  for (const each of state.obstacles) {
    const radius = each.radius_m > 0 ? each.radius_m : Math.max(...each.points.map(([x, y]) => Math.hypot(x - each.center[0], y - each.center[1])));
    if (far(each.center) < Math.max(radius, finger_m)) return {do: 'obstacle', name: each.name, from: each.center};
  }
  return null;
}

function put(last) {
  if (!last && performance.now() - touched_ms < between_touches_ms) return;
  touched_ms = performance.now();
  const [x0, y0, x1, y1] = state.room, [x, y] = held.to;
  const {from, ...what} = held.what;
  touch({...what, x_m: Math.min(Math.max(x, x0), x1), y_m: Math.min(Math.max(y, y0), y1)});
}

canvas.addEventListener('pointerdown', (event) => {
  if (!state) return;
  const point = place(event);
  if (dropping) {
    touch({do: 'box', x_m: point[0], y_m: point[1]});
    return drop(false);
  }
  const what = find(point, 16 * hair());
  if (!what) return;
  held = {what, grip: [what.from[0] - point[0], what.from[1] - point[1]], to: what.from};
  try { canvas.setPointerCapture(event.pointerId); } catch { /* a pointer that is gone */ }
});
canvas.addEventListener('pointermove', (event) => {
  if (!held) {
    if (state) canvas.classList.toggle('grip', Boolean(find(place(event), 0.1)));
    return;
  }
  const point = place(event);
  held.to = [point[0] + held.grip[0], point[1] + held.grip[1]];
  put(false);
  draw();
});
for (const end of ['pointerup', 'pointercancel']) {
  canvas.addEventListener(end, () => {
    if (!held) return;
    if (held.to !== held.what.from) put(true);
    held = null;
  });
}
