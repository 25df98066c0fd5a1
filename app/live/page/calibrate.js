// The camera is calibrated: a board is held before it, and the page says where to hold it next.
import {at, build, element, linkTo} from './live.js';

const good_mm = 1, bad_mm = 10; // of the map's colours
let state = null, ask = null, proposed = false, counted = 0;

export function connectCalibration(send) {
  ask = send;
  at('search').onclick = () => {
    say('');
    if (state?.on) ask({do: 'calibrate_stop'});
    else if (canGoOn()) ask({do: 'calibrate_go_on'});
    else begin();
  };
  at('anew').onclick = begin;
  at('diameter').onchange = () => ask({do: 'diameter', diameter_m: Number(at('diameter').value) / 1000});
  at('back').onclick = () => ask({do: 'calibrate_undo'});
  at('save_camera').onclick = () => {
    say('Saving ...');
    ask({do: 'save_camera'});
  };
}

function begin() {
  if (!(Number(at('square').value) > 0)) {
    at('square').focus();
    return say('Enter the side of the square first, as measured on the paper.', true);
  }
  say('');
  ask({do: 'calibrate', board: at('board').value.trim(), square_m: Number(at('square').value) / 1000});
}

// With the pictures that were taken, of the same board.
function canGoOn() {
  return state?.taken > 0 && at('board').value.trim() === state.board && Math.abs(Number(at('square').value) - 1000 * state.square_m) < 1e-6;
}

function say(text, bad = false) {
  at('calibrated').textContent = text;
  at('calibrated').classList.toggle('bad', bad);
}

export function calibrationAnswered(answer) {
  if (answer.refused) return say(answer.refused, true);
  if (answer.answer === 'calibrate' || answer.answer === 'calibrate_go_on') return say('');
  if (answer.answer === 'diameter') return say(`Distances are of balls ${at('diameter').value} mm across.`);
  if (answer.answer === 'calibrate_undo') return say('Taken back.');
  if (answer.answer !== 'save_camera') return;
  answer.files?.forEach((file) => linkTo(file).click());
  const good = state.fit?.enough;
  say('');
  const words = answer.saved ? [answer.saved] : answer.files.flatMap((file, place) => [place ? ' and ' : '', linkTo(file)]);
  at('calibrated').append('Saved as ', ...words, answer.saved ? '' : ', where the browser puts downloads. They belong side by side; click on one that it kept back',
    `. From now on the balls are placed with this camera. Next: click on a ball${at('diameter').value || at('diameter').placeholder ? '' : ', and enter its diameter'}.`);
  if (good) return;
  at('calibrated').append(element('span', ' It is not known well enough yet: where it is known least, a ball at 1 m is uncertain by ' +
    `${millimetres(state.fit?.ball_sigma_mm ?? null)}. Go on takes more pictures.`, {className: 'bad'}));
}

const millimetres = (value) => value === null ? 'unknown' : `${value.toFixed(value < 10 ? 1 : 0)} mm`;

function fitWords(fit) {
  if (!fit) return '';
  if (fit.refused) return `No camera yet: ${fit.refused}`;
  if (fit.ball_sigma_mm === null) return `${fit.boards} boards give a camera (${fit.model}): residual ${fit.rms_px.toFixed(3)} px. How well it places a ball they do not tell yet.`;
  return `${fit.boards} boards give a camera (${fit.model}): residual ${fit.rms_px.toFixed(3)} px. It places a 70 mm ball at 1 m to ` +
    `${millimetres(fit.covered_ball_sigma_mm)} (1 sigma) typically where boards were, ${millimetres(fit.ball_sigma_mm)} at worst.`;
}

export function showCalibration(now) {
  state = now;
  if (!proposed) {
    proposed = true;
    at('board').value = state.board ?? state.proposed.board;
    at('square').value = 1000 * (state.square_m ?? state.proposed.square_m) || '';
    const diameter_mm = 1000 * Number(state.diameter);
    if (diameter_mm) at('diameter').value = Number(diameter_mm.toFixed(3));
    else at('diameter').placeholder = state.diameter;  // of several classes, or with its sigma
  }
  const {on, fit, taken = 0} = state;
  if (taken > counted) say('');
  counted = taken;
  at('search').textContent = on ? 'Stop' : canGoOn() ? 'Go on' : 'Start';
  at('anew').hidden = on || !canGoOn();
  at('search').setAttribute('aria-pressed', on);
  at('search').title = on || canGoOn() ? 'What was taken stays' : 'The board is looked for';
  for (const id of ['board', 'square']) at(id).disabled = on;
  at('back').disabled = !taken;
  at('save_camera').disabled = state.fitting || !fit?.model;
  at('save_camera').title = state.output ? `Into ${state.output}` : 'As a download';
  at('count').textContent = taken || on ? `${taken} ${taken === 1 ? 'picture' : 'pictures'} taken` + (state.fitting ? ', fitting ...' : '') : '';
  const least = taken < state.needed ? ` ${state.needed} pictures at least are needed.` : '';
  at('next').textContent = on && !fit?.enough ? (state.next?.words ?? '') + least : '';
  at('enough').hidden = !fit?.enough;
  at('seen').textContent = state.said ?? '';
  at('seen').classList.toggle('bad', Boolean(on && state.said && !state.seen));
  at('fitted').textContent = fitWords(fit);
  at('fitted').classList.toggle('bad', Boolean(fit?.refused));
  at('legend').hidden = !(on && fit?.map);
  at('better').hidden = !fit?.lacks?.length;
  at('better').textContent = fit?.enough ? 'Better still:' : 'What it lacks:';
  build('lacking', [...fit?.lacks ?? [], ...fit?.warnings ?? []], (lines) => lines.map((line) => element('li', line[0].toUpperCase() + line.slice(1))));
}

// ---- over the picture

// From green at what is good to red at what is not.
function ink(sigma_mm) {
  const part = Math.min(1, Math.max(0, Math.log(sigma_mm / good_mm) / Math.log(bad_mm / good_mm)));
  return `hsl(${120 * (1 - part)} 90% 45% / 0.3)`;
}

// `tools`: onCanvas, pixel, trace and write of live.js.
export function drawCalibration(pen, width_px, height_px, tools) {
  if (!state?.on) return;
  const {map} = state.fit ?? {}, {next} = state;
  const step = map && [(width_px - 1) / (map.columns - 1), (height_px - 1) / (map.rows - 1)];
  map?.sigma_mm.forEach((sigma, place) => {
    if (sigma === null) return;
    const u = (place % map.columns - 0.5) * step[0], v = (Math.floor(place / map.columns) - 0.5) * step[1];
    const [left, top] = tools.onCanvas([u, v]), [right, bottom] = tools.onCanvas([u + step[0], v + step[1]]);
    pen.fillStyle = ink(sigma);
    pen.fillRect(left, top, right - left, bottom - top);
  });
  if (next && !state.fit?.enough) {
    const outline = next.outline_px;
    tools.trace(outline, '#fff', [6, 4]);
    const middle = (axis) => outline.reduce((sum, corner) => sum + corner[axis], 0) / outline.length;
    const [x, y] = tools.onCanvas(outline.length ? [middle(0), middle(1)] : next.place_px);
    const words = pen.measureText('board here').width / 2 + 4 * tools.pixel();
    tools.write('board here', Math.min(Math.max(x, words), pen.canvas.width - words), y + 4 * tools.pixel());
  }
  drawCorners(pen, tools);
  const font = pen.font;
  pen.font = `600 ${20 * tools.pixel()}px system-ui, sans-serif`;  // is read from where the board is held
  tools.write(state.said.split(/[:.]/)[0], pen.canvas.width / 2, 26 * tools.pixel());
  pen.font = font;
}

function drawCorners(pen, tools) {
  const points = state.corners_px.map(tools.onCanvas);
  pen.beginPath();
  for (const [x, y] of points) pen.lineTo(x, y);
  pen.lineWidth = 1 * tools.pixel();
  pen.strokeStyle = '#00d0ff';
  pen.stroke();
  points.forEach(([x, y], place) => {
    pen.beginPath();
    pen.arc(x, y, (place ? 2.5 : 5) * tools.pixel(), 0, 2 * Math.PI);
    pen.fillStyle = place ? '#00ff5e' : '#ffd500';
    pen.fill();
  });
}
