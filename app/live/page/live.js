// The page of `ballservo live`. README.md beside it describes the messages.
import {calibrationAnswered, connectCalibration, drawCalibration, showCalibration} from './calibrate.js';
import {connectRoom, drop, showRoom} from './room.js';

export const at = (id) => document.getElementById(id);
const canvas = at('picture'), pen = canvas.getContext('2d');
let socket, state = null, bitmap = null, view = '', mark = null, drag = null, teaching = null, asked = null, countdown = null, controlled = false, recording = false, ended = false, unsaved = false;

// ---- messages

function connect() {
  socket = new WebSocket(new URL('socket', location).href.replace(/^http/, 'ws'));
  socket.binaryType = 'arraybuffer';
  socket.onopen = look;
  socket.onmessage = (message) => typeof message.data === 'string' ? answered(JSON.parse(message.data)) : arrived(message.data);
  socket.onclose = () => {
    complain(ended ? 'The program has ended, as you told it: this page can be closed.' : 'The program has ended, or cannot be reached.');
    if (!ended) setTimeout(connect, 2000);
  };
}

function send(what) {
  if (socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(what));
}

function look() { send({do: 'look', view: at('view').value || (teaching ? 'taught' : 'picture')}); }

async function arrived(data) {
  const length = new DataView(data).getUint32(0, true);
  const message = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
  const jpeg = new Uint8Array(data, 4 + length);
  const next = jpeg.length ? await createImageBitmap(new Blob([jpeg], {type: 'image/jpeg'})) : null;
  requestAnimationFrame(() => {
    if (drag) {  // the picture holds still under the hand
      next?.close();
    } else {
      ({state, view} = message);
      bitmap?.close();
      bitmap = next;
      paint();
      show(message);
    }
    send({do: 'painted', serial: message.state.serial});
  });
}

function answered(answer) {
  if (answer.answer === 'why') return explain(answer);
  if (answer.controls) return showControls(answer.controls);
  if (answer.answer.startsWith('calibrate') || answer.answer === 'save_camera' || answer.answer === 'diameter') {
    if (answer.answer === 'save_camera' && !answer.refused && !state.classes.length) setTeaching(true);
    return calibrationAnswered(answer);
  }
  if (answer.answer === 'teach') mark = null;
  if (answer.refused) return say(answer.refused, true);
  if (answer.answer === 'found') {
    const [u, v, r] = answer.circle_px;
    mark = {u, v, r, until: performance.now() + 10000};
    say('Learning from this circle ...');
    return paint();
  }
  if (['teach', 'rename', 'undo'].includes(answer.answer)) unsaved = true;
  if (['save', 'load'].includes(answer.answer)) unsaved = false;
  if (answer.answer === 'teach') {
    const [u, v, r] = answer.circle_px;
    mark = {u, v, r, until: performance.now() + 4000};
    say(`${answer.class} is learnt from the circle around (${u.toFixed(0)}, ${v.toFixed(0)}), radius ${r.toFixed(0)} px.`);
  } else if (answer.answer === 'rename') {
    say(`It is called ${answer.class} now.`);
  } else if (answer.answer === 'save') {
    if (answer.download) linkTo(answer).click();
    say(answer.download ? `Saved as ${answer.download}, where the browser puts downloads.` : `Saved as ${answer.saved}`);
  } else if (answer.answer === 'keep') {
    say(`${answer.pictures} pictures are kept in ${answer.folder}`);
  } else if (answer.answer === 'load') {
    say(`${answer.classes === 1 ? 'One class is' : `${answer.classes} classes are`} loaded.`);
  } else if (answer.answer === 'undo') {
    mark = null;
    say('Taken back.');
  }
}

export function linkTo({base64, download}) {
  const bytes = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  return element('a', download, {href: URL.createObjectURL(new Blob([bytes])), download});
}

// ---- the picture

// As many points as the screen has, so that lines and words are sharp.
function paint() {
  if (!bitmap) return;
  const sharp = Math.min(4, Math.max(1, Math.round(canvas.clientWidth * devicePixelRatio / bitmap.width)));
  const width = sharp * bitmap.width, height = sharp * bitmap.height;
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, {width, height});
  pen.drawImage(bitmap, 0, 0, width, height);
  pen.font = `600 ${13 * pixel()}px system-ui, sans-serif`;
  if (state.kind === 'footage' && (view === 'picture' || view === 'taught')) state.balls.forEach(drawBall);
  if (state.kind === 'footage' && view === 'picture') drawCalibration(pen, state.width_px, state.height_px, {onCanvas, pixel, trace, write});
  if (countdown) drawSquare();
  for (const circle of [drag, mark && mark.until > performance.now() ? mark : null]) {
    if (circle) trace(Array.from({length: 49}, (_, k) => [circle.u + circle.r * Math.cos(k * Math.PI / 24), circle.v + circle.r * Math.sin(k * Math.PI / 24)]), '#fff');
  }
}

window.addEventListener('resize', paint);

const styles = {confirmed: ['#ff4dff', []], tentative: ['#ffd500', [6, 4]], coasting: ['#ddd', [2, 4]]};

// A point of the picture on the canvas, and a screen's point in the canvas's.
const onCanvas = ([u, v]) => [(u + 0.5) * canvas.width / state.width_px, (v + 0.5) * canvas.width / state.width_px];
const pixel = () => canvas.width / Math.min(canvas.clientWidth, canvas.clientHeight * canvas.width / canvas.height);

function trace(points, color, dash = []) {
  pen.beginPath();
  for (const point of points) pen.lineTo(...onCanvas(point));
  pen.closePath();
  for (const [width, ink, dashes] of [[4.5, '#000a', []], [2, color, dash]]) {
    pen.lineWidth = width * pixel();
    pen.strokeStyle = ink;
    pen.setLineDash(dashes.map((length) => length * pixel()));
    pen.stroke();
  }
  pen.setLineDash([]);
}

function drawSquare() {
  const half = state.height_px / 4, [u, v] = [(state.width_px - 1) / 2, (state.height_px - 1) / 2];
  trace([[u - half, v - half], [u + half, v - half], [u + half, v + half], [u - half, v + half]], '#fff');
  write(Math.max(1, Math.ceil((countdown - performance.now()) / 1000)).toString(), ...onCanvas([u, v - half * 0.7]));
}

function write(words, x, y) {
  pen.textAlign = 'center';
  pen.lineJoin = 'round';
  pen.lineWidth = 3 * pixel();
  pen.strokeStyle = '#000';
  pen.strokeText(words, x, y);
  pen.fillStyle = '#fff';
  pen.fillText(words, x, y);
}

function drawBall(ball) {
  trace(ball.rim_px, ...styles[ball.state]);
  const words = `${ball.class} ${ball.track_id}` + (ball.position ? ` \u00b7 ${ball.position.split(',')[0]}` : '');
  const [u, v, r] = ball.outline_px, half = pen.measureText(words).width / 2 + 6 * pixel(), gap = 7 * pixel();
  const [x, top] = onCanvas([u, v - r]), [, bottom] = onCanvas([u, v + r]);
  const y = top - 2 * gap > 0 ? top - gap : bottom + 2.5 * gap;
  const middle = Math.min(Math.max(x, half), canvas.width - half);
  write(words, middle, y);
}

// Where a pointer is, in the picture's own pixels; (0, 0) is the middle of the first.
function place(event) {
  const box = canvas.getBoundingClientRect();
  const shown = Math.min(box.width / canvas.width, box.height / canvas.height);
  const left = box.left + (box.width - canvas.width * shown) / 2, top = box.top + (box.height - canvas.height * shown) / 2;
  const scale = shown * canvas.width / state.width_px;
  return {u: (event.clientX - left) / scale - 0.5, v: (event.clientY - top) / scale - 0.5};
}

canvas.addEventListener('pointerdown', (event) => {
  if (state?.kind !== 'footage') return;
  drag = {...place(event), r: 0, serial: state.serial, x: event.clientX, y: event.clientY};
  try { canvas.setPointerCapture(event.pointerId); } catch { /* a pointer that is gone */ }
});
canvas.addEventListener('pointermove', (event) => {
  if (!drag || !teaching) return;
  const far = Math.hypot(event.clientX - drag.x, event.clientY - drag.y) > 5;
  const to = place(event);
  drag.r = far ? Math.hypot(to.u - drag.u, to.v - drag.v) : 0;
  paint();
});
canvas.addEventListener('pointercancel', () => { drag = null; });
canvas.addEventListener('pointerup', () => {
  if (!drag) return;
  const spot = {serial: drag.serial, u_px: drag.u, v_px: drag.v};
  if (teaching) teach({...spot, radius_px: drag.r});
  else ask(spot);
  mark = {u: drag.u, v: drag.v, r: drag.r || 4 * state.width_px / canvas.clientWidth, until: performance.now() + 2000};
  drag = null;
  paint();
});

// ---- what is asked

function teach(spot) {
  say('Learning ...');
  send({do: 'teach', ...spot, name: at('name').value.trim()});
}

function ask(spot) {
  asked = spot;
  send({do: 'why', ...spot});
}

function explain(answer) {
  const lines = answer.refused ? [['bad', answer.refused]]
    : [[answer.ball ? '' : 'bad', answer.text], ['note', answer.figures], ['', answer.remedy && `What helps: ${answer.remedy}${answer.remedy.endsWith('.') ? '' : '.'}`]];
  at('why').replaceChildren(...lines.filter(([, text]) => text).map(([className, text]) => element('p', text, {className})));
  if (answer.ball || !asked) return;
  at('why').append(element('button', 'It is a ball: teach it', {onclick: () => teach({...asked, radius_px: 0})}));
}

// Whoever holds the ball has no hand for the mouse.
at('shot').onclick = () => {
  countdown = performance.now() + 3000;
  setTimeout(() => {
    countdown = null;
    teach({serial: state.serial, u_px: (state.width_px - 1) / 2, v_px: (state.height_px - 1) / 2, radius_px: 0});
  }, 3000);
};

connectRoom(send);
connectCalibration((what) => {
  if (what.do === 'calibrate' && teaching) setTeaching(false);
  send(what);
});
for (const id of ['keep', 'hold', 'reset', 'undo', 'save', 'pause', 'step', 'record']) at(id).onclick = () => send({do: id});
at('end').onclick = () => {
  if (unsaved && state.classes.length) {
    unsaved = false;
    return say('The colours are not saved. Save keeps them; End, pressed again, ends without them.', true);
  }
  ended = true;
  send({do: 'end'});
};
at('teach').onclick = () => setTeaching(!teaching);
at('view').onchange = look;
const reader = new FileReader();
reader.onload = () => send({do: 'load', base64: reader.result.split(',')[1]});
at('load').onchange = ({target}) => {
  if (target.files.length) reader.readAsDataURL(target.files[0]);
  target.value = '';
};

function setTeaching(on) {
  teaching = on;
  at('teach').setAttribute('aria-pressed', on);
  at('hint').textContent = on
    ? 'Click on a ball, or press on its middle and draw to its rim. What has its colour shines.'
    : 'A click asks why something is no ball.';
  if (!asked) at('why').textContent = on ? 'Switch Teach off, and click on anything in the picture.' : 'Click on anything in the picture.';
  look();
}

// ---- what is shown

export function element(tag, textContent, more = {}) {
  return Object.assign(document.createElement(tag), {textContent, ...more});
}

function say(text, bad = false) {
  at('said').textContent = text;
  at('said').classList.toggle('bad', bad);
}

function complain(text) {
  at('fault').textContent = text;
  at('fault').hidden = !text;
}

// Builds a part of the page anew only where what it shows has changed, so that nothing loses its focus.
const built = {};
export function build(id, what, make) {
  const now = JSON.stringify(what);
  if (built[id] === now) return;
  built[id] = now;
  at(id).replaceChildren(...make(what));
}

function showControls(all) {
  at('controls').replaceChildren(...all.map((one) => {
    const label = element('label', `${one.name.replaceAll('_', ' ')} `);
    const input = element('input', '', {type: 'number', min: one.minimum, max: one.maximum, step: one.step, value: one.value});
    input.onchange = () => send({do: 'camera', name: one.name, value: Number(input.value)});
    label.append(input);
    return label;
  }));
}

function classItem(one) {
  const item = document.createElement('li');
  const swatch = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  swatch.setAttribute('viewBox', '0 0 2 2');
  const disc = document.createElementNS('http://www.w3.org/2000/svg', 'circle');
  for (const [key, value] of Object.entries({cx: 1, cy: 1, r: 1, fill: one.color})) disc.setAttribute(key, value);
  swatch.append(disc);
  const name = element('input', '', {value: one.name, title: 'Rename'});
  name.setAttribute('aria-label', `Name of class ${one.name}`);
  name.onchange = () => send({do: 'rename', class: one.name, name: name.value.trim()});
  const percent = (fraction) => `${(100 * fraction).toFixed(1)} %`;
  const overlap = Object.entries(one.overlap).map(([other, part]) => `, ${percent(part)} taken by ${other}`).join('');
  const text = `Learnt from ${one.samples} pixels; ${percent(one.kept_fraction)} of them are found again${overlap}. ${percent(one.background_fraction)} of all else has this colour. ` +
    `It bears light from ${one.level_low.toPrecision(2)} to ${one.level_high.toPrecision(2)} times as strong, ${Math.round(one.warmest_k / 100) * 100} to ${Math.round(one.coolest_k / 100) * 100} K.`;
  item.append(swatch, name, element('small', text));
  return [item];
}

function show(message) {
  if (document.body.className !== state.kind) begin(state.kind);
  complain(state.message || message.fault);
  Object.assign(canvas.dataset, {size: JSON.stringify([state.width_px, state.height_px]), frame: state.frame - 1});
  at('source').textContent = state.source.split('/').pop();
  at('source').title = state.source;
  at('pause').textContent = state.paused ? 'Go on' : 'Pause';
  at('pause').setAttribute('aria-pressed', state.paused);
  (state.kind === 'footage' ? showFootage : showScenario)(message);
  plot(message);
}

// The parts that a kind of session has are chosen by the body's class.
function begin(kind) {
  document.body.className = kind;
  at('quantity').replaceChildren(...Object.keys(quantities[kind]).map((name) => element('option', name)));
  if (kind === 'scenario') {
    at('bar').append(at('pace'), at('reset'), at('drop'), at('save'), at('touches'));
    at('world').append(at('bar'), at('said'));
    at('right').prepend(at('scene'));
    at('step').title = 'The next control step, and pause';
    at('save').title = 'What was done to this run: ballservo servo SCENARIO --touches does it again';
    at('save').disabled = false;
    at('record').disabled = true;
    at('record').title = 'With --record DIR each run is kept when it ends';
  } else {
    at('quantity').value = state.calibration.diameter ? 'distance (m)' : 'radius (px)';
  }
}

function showFootage(message) {
  if (teaching === null) setTeaching(state.classes.length === 0);
  at('status').textContent = (state.paused ? 'paused; ' : `${state.rate_hz.toFixed(1)} pictures/s, ${state.work_ms.toFixed(1)} ms each; `) +
    `seen to painted ${message.painted_p95_ms.toFixed(0)} ms (95 %)` + (state.learning ? '; learning' : '');
  at('device').hidden = !state.camera;
  if (state.camera && !controlled) send({do: 'camera'});
  controlled = state.camera;
  at('ignored').textContent = state.ignored && `The camera does not obey: ${state.ignored}.`;
  at('undo').disabled = !state.undo;
  at('save').disabled = !state.classes.length;
  at('save').title = state.colors_output ? `Into ${state.colors_output}` : 'As a download';
  const record = state.recording, count = record && `${record.kept}` + (record.lost ? `, ${record.lost} lost` : '');
  if (recording && record && !record.on) say(`Recorded: ${count} pictures in ${record.folder}`);
  recording = record?.on;
  at('record').setAttribute('aria-pressed', Boolean(recording));
  at('record').textContent = recording ? `Recording: ${count}` : 'Record';
  at('record').title = record ? record.fault || `In ${record.folder}` : 'Start the program with --record DIR';
  at('record').disabled = !state.can_record;
  at('keep').hidden = state.recent_s === null;
  at('keep').textContent = `Keep the last ${Math.round(state.recent_s)} s`;
  build('view', state.views.map((view) => view.name), (names) => ['', ...names].map((name) =>
    element('option', name || 'automatic', {value: name})));
  at('remedy').textContent = state.views.find((view) => view.name === message.view)?.remedy ?? '';
  build('candidates', state.candidates ?? [], (all) => all.map((one) => element('li',
    `${one.class} at (${one.outline_px[0].toFixed(0)}, ${one.outline_px[1].toFixed(0)}), radius ${one.outline_px[2].toFixed(0)} px: ` +
    (one.accepted ? 'a ball' : one.reason + (one.remedy && ` (${one.remedy})`)))));
  build('classes', state.classes, (all) => all.flatMap(classItem));
  build('names', state.classes.map((one) => one.name), (names) => names.map((value) => element('option', '', {value})));
  showCalibration(state.calibration);
  build('warnings', state.warnings, (all) => all.map((text) => element('li', text)));
  showBalls();
}

// In place, so that a figure can be selected.
function showBalls() {
  const rows = at('balls').rows;
  while (rows.length > state.balls.length) at('balls').deleteRow(-1);
  state.balls.forEach((ball, place) => {
    const row = rows[place] ?? at('balls').insertRow();
    [ball.track_id, ball.class, ball.state, ball.quality.toFixed(2), ball.outline_px.map((x) => x.toFixed(1)).join(', '),
      ball.position ?? 'needs a camera and the diameter', millimetresOf(ball)].forEach((text, column) => {
      const cell = row.cells[column] ?? row.insertCell();
      if (cell.textContent !== String(text)) cell.textContent = text;
    });
  });
}

// As many digits as mean something.
function millimetresOf(ball) {
  if (!ball.position) return '';
  return ball.p_m.map((metres, axis) => (1000 * metres).toFixed(ball.covariance_m2[axis][axis] < 0.005 ** 2 ? 1 : 0)).join(', ');
}

// ---- a scenario

const knobs = {gain: ['gain', 'per_s', 'gain_per_s', '1/s'], latency: ['latency', 'latency_s', 'latency_s', 's'],
  noise: ['noise', 'factor', 'noise', 'times'], light: ['light', 'factor', 'light', 'times']};
const touched = (what) => send({do: 'touch', touch: what});
for (const [id, [verb, key, , unit]] of Object.entries(knobs)) {
  at(id).oninput = () => { at(id).nextElementSibling.textContent = `${at(id).value} ${unit}`; };
  at(id).onchange = () => touched({do: verb, [key]: Number(at(id).value)});
}
at('law').onchange = () => touched({do: 'law', name: at('law').value});
at('avoidance').onchange = () => touched({do: 'avoidance', type: at('avoidance').value});
at('pace').onchange = () => send({do: 'speed', factor: Number(at('pace').value)});
at('drop').onclick = () => drop(at('drop').getAttribute('aria-pressed') !== 'true');

function choose(id, names, value) {
  build(id, names, () => names.map((name) => element('option', name)));
  if (document.activeElement !== at(id)) at(id).value = value;
}

function showScenario(message) {
  showRoom(state);
  choose('law', state.laws, state.law);
  choose('avoidance', state.avoidances, state.avoidance);
  for (const [id, [, , key]] of Object.entries(knobs)) {
    if (document.activeElement === at(id) && at(id).matches(':active')) continue;
    at(id).value = state[key];
    at(id).oninput();
  }
  at('status').textContent = `${state.time_s.toFixed(2)} s, step ${state.step}, seed ${state.seed}, ${state.perception}; painted ${message.painted_p95_ms.toFixed(0)} ms after it was seen (95 %)`;
  at('touches').textContent = state.touches === 1 ? '1 touch' : `${state.touches} touches`;
  at('shield').textContent = state.avoidance === 'none' ? 'There is no shield' : `The shield: ${state.shield || 'the command passes'}`;
  at('outcome').textContent = state.outcome && `${state.outcome}: ${state.outcome_text}. Reset begins anew.`;
  at('outcome').hidden = !state.outcome;
  const values = {'is doing': state.state, 'because': state.reason, 'distance to the goal': `${(1000 * state.range_error_m).toFixed(1)} mm`,
    'bearing': `${(state.bearing_rad * 180 / Math.PI).toFixed(2)}\u00b0`, 'speed': `${state.v_mps.toFixed(3)} m/s, ${state.w_radps.toFixed(3)} rad/s`,
    'nearest thing': `${(100 * state.clearance_m).toFixed(0)} cm`, 'the ball is': state.track};
  at('readings').replaceChildren(...Object.entries(values).flatMap(([name, value]) => [element('dt', name), element('dd', value)]));
}

// ---- the chart

const norm = (p) => p && Math.hypot(...p);
const ofBalls = (of) => () => state.balls.map((ball) => [`${ball.class} ${ball.track_id}`, of(ball)]);
const ofAll = (of) => (message) => [['', of(message)]];
const painted = ofAll((message) => message.painted_p95_ms);
const quantities = {
  footage: {
    'distance (m)': ofBalls((ball) => norm(ball.p_m)),
    'radius (px)': ofBalls((ball) => ball.outline_px[2]),
    'quality': ofBalls((ball) => ball.quality),
    'x (m)': ofBalls((ball) => ball.p_m?.[0]),
    'y (m)': ofBalls((ball) => ball.p_m?.[1]),
    'z (m)': ofBalls((ball) => ball.p_m?.[2]),
    'pictures per second': ofAll(() => state.rate_hz),
    'work per picture (ms)': ofAll(() => state.work_ms),
    'seen to painted (ms, 95 %)': painted,
  },
  scenario: {
    'distance to the goal (m)': ofAll(() => state.range_error_m),
    'bearing (degrees)': ofAll(() => state.bearing_rad * 180 / Math.PI),
    'speed (m/s)': ofAll(() => state.v_mps),
    'turning (rad/s)': ofAll(() => state.w_radps),
    'nearest thing (m)': ofAll(() => state.clearance_m),
    'seen to painted (ms, 95 %)': painted,
  },
};
const lines = ['#0b62c4', '#c4510b', '#2e8b3a', '#8b2e8b', '#7a6a00', '#00797a'];
const seconds_kept = 20;
let chart = null, drawn = 0;
const opened = performance.now();
at('quantity').onchange = () => { if (chart) chart.data.datasets = []; };

function plot(message) {
  if (!window.Chart) return;
  Chart.defaults.color = getComputedStyle(document.body).color;
  Chart.defaults.borderColor = '#8884';
  chart ??= new Chart(at('chart'), {
    type: 'line',
    data: {datasets: []},
    options: {animation: false, parsing: false, maintainAspectRatio: false, elements: {point: {radius: 0}, line: {borderWidth: 1.5}},
      scales: {x: {type: 'linear', min: -seconds_kept, max: 0, title: {display: true, text: 'seconds ago'}, ticks: {callback: (age) => -age}}}, plugins: {legend: {labels: {boxWidth: 12}}}},
  });
  const now = (performance.now() - opened) / 1000, name = at('quantity').value;
  const values = quantities[state.kind][name](message).map(([label, value]) => [label || name, value]);
  const sets = chart.data.datasets;
  for (const [label, value] of values) {
    if (value === undefined || value === null) continue;
    let set = sets.find((each) => each.label === label);
    if (!set) sets.push(set = {label, data: [], borderColor: lines[sets.length % lines.length]});
    (set.seen ??= []).push([now, value]);
  }
  for (const set of sets) while (set.seen.length && set.seen[0][0] < now - seconds_kept) set.seen.shift();
  chart.data.datasets = sets.filter((set) => set.seen.length);
  if (now - drawn < 0.2) return;
  drawn = now;
  for (const set of chart.data.datasets) set.data = set.seen.map(([time, y]) => ({x: time - now, y}));
  chart.update();
}

connect();
