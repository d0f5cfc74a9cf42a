// Line charts in SVG: lines, bands around them, a wanted range, a value under the pointer.
import {fixed, h} from './dom.js';
import {canvasOfSvg, fileName, saveCsv, savePng, saveSvg} from './save.js';

const height = 320, left = 52, right = 12, top = 22, bottom = 40;

/** Round values that divide a range. */
export function ticks(low, high, about = 6) {
  const raw = (high - low) / about, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map(f => f * power).find(s => s >= raw) || power;
  const values = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) values.push(i * step);
  return {values, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
}

function range(values) {
  let low = Infinity, high = -Infinity;
  for (const v of values) if (Number.isFinite(v)) { low = Math.min(low, v); high = Math.max(high, v); }
  if (!(low <= high)) return [0, 1];
  return low === high ? [low - 0.5, high + 0.5] : [low, high];
}

const path = points => {
  let d = '', pen = 'M';
  for (const [x, y] of points) {
    if (!Number.isFinite(y)) { pen = 'M'; continue; }
    d += `${pen}${x.toFixed(1)} ${y.toFixed(1)}`;
    pen = 'L';
  }
  return d;
};

/** The range that is wanted, with dashed edges where it ends. */
function wantedRegion({low, high, name}, py, right) {
  const [foot, head] = [py(low), py(high)];
  const edges = [[low, foot], [high, head]].filter(([value]) => Number.isFinite(value));
  return [h('rect', {class: 'wanted', x: left, width: right - left, y: head, height: foot - head}),
    edges.map(([, y]) => h('line', {class: 'edge', x1: left, x2: right, y1: y, y2: y})),
    name ? h('text', {x: left + 6, y: head + 14}, name) : null].flat();
}

/** Where the model of a run is no longer valid. */
const beyondRegion = (from, right) => [
  h('rect', {class: 'beyond', x: from, width: right - from, y: top, height: height - bottom - top}),
  h('text', {x: right - 4, y: height - bottom - 6, 'text-anchor': 'end'}, 'beyond validity')];

/**
 * @param lines   [{name, x, y, low and high (its band), dashed, dots (a dot for each point, no line), colour (0 to 5)}]
 * @param options {title, xLabel, yLabel, unit of y, wanted: {low, high, name} as y, infinite where it has no end;
 *   beyond: x from which on the model is not valid; width: of the drawing}
 */
export function chart(lines, {title, xLabel, yLabel, wanted = null, beyond = Infinity, unit = 'mm', width = 900}) {
  const colour = (line, i) => `line-${(line.colour ?? i) % 6}`;
  const bands = lines.map(line => (line.low ? [line.low, line.high] : null));
  const [x0, x1] = range(lines.flatMap(line => line.x));
  const [y0, y1] = range([0, ...lines.flatMap(line => line.y), ...bands.flatMap(b => (b ? b.flat() : [])), ...(wanted ? [wanted.low, wanted.high] : [])]);
  const px = x => left + (x - x0) / (x1 - x0) * (width - left - right);
  const placed = y => height - bottom - (y - y0) / (y1 - y0) * (height - top - bottom);
  const py = y => Math.max(top, Math.min(height - bottom, placed(y)));  // an infinite end is that of the axis
  const parts = [];
  if (beyond < x1) parts.push(...beyondRegion(px(Math.max(beyond, x0)), width - right));
  if (wanted) parts.push(...wantedRegion(wanted, py, width - right));
  const across = ticks(x0, x1), up = ticks(y0, y1, 5);
  for (const v of up.values)
    parts.push(h('line', {class: v === 0 ? 'zero' : 'grid', x1: left, x2: width - right, y1: py(v), y2: py(v)}),
      h('text', {x: left - 6, y: py(v) + 4, 'text-anchor': 'end'}, fixed(v, up.digits)));
  for (const v of across.values)
    parts.push(h('text', {x: px(v), y: height - bottom + 16, 'text-anchor': 'middle'}, fixed(v, across.digits)));
  parts.push(h('text', {x: (left + width - right) / 2, y: height - 6, 'text-anchor': 'middle'}, xLabel),
    h('text', {x: 12, y: top - 8, 'text-anchor': 'start', class: 'unit'}, yLabel));
  lines.forEach((line, i) => {
    const band = bands[i];
    if (band) {
      const upper = line.x.map((x, k) => [px(x), py(band[1][k])]).filter(p => Number.isFinite(p[1]));
      const lower = line.x.map((x, k) => [px(x), py(band[0][k])]).filter(p => Number.isFinite(p[1])).reverse();
      parts.push(h('path', {class: `band ${colour(line, i)}`, d: `${path([...upper, ...lower])}z`}));
    }
  });
  lines.forEach((line, i) => parts.push(line.dots
    ? h('g', {class: `dot ${colour(line, i)}`}, line.x.map((x, k) => (Number.isFinite(line.y[k]) ? h('circle', {cx: px(x), cy: py(line.y[k]), r: 3}) : null)))
    : h('path', {class: `line ${colour(line, i)}${line.dashed ? ' dashed' : ''}`, d: path(line.x.map((x, k) => [px(x), py(line.y[k])]))})));
  const summary = lines.map(line => `${line.name} ends at ${fixed(line.y.at(-1), 1)} ${unit}`).join(', ');
  const cursor = h('line', {class: 'cursor', y1: top, y2: height - bottom, x1: -9, x2: -9});
  const svg = h('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `${title}: ${summary}`}, parts, cursor);
  const legend = h('ul', {class: 'legend', 'aria-hidden': 'true'}, lines.map((line, i) =>
    h('li', {}, h('span', {class: `swatch ${colour(line, i)}${line.dashed ? ' dashed' : ''}`}), line.name, h('output', {}, ''))));
  const values = legend.querySelectorAll('output');
  const show = event => {
    const box = svg.getBoundingClientRect();
    const x = x0 + ((event.clientX - box.left) / box.width * width - left) / (width - left - right) * (x1 - x0);
    cursor.setAttribute('x1', px(x)); cursor.setAttribute('x2', px(x));
    lines.forEach((line, i) => { values[i].textContent = x < x0 || x > x1 ? '' : ` ${fixed(valueAt(line, x), 2)} at ${fixed(x, 0)}`; });
  };
  svg.addEventListener('pointermove', show);
  svg.addEventListener('pointerleave', () => { cursor.setAttribute('x1', -9); cursor.setAttribute('x2', -9); values.forEach(v => { v.textContent = ''; }); });
  return h('figure', {}, svg, legend, h('figcaption', {}, h('span', {class: 'title'}, title), savers(svg, lines, {title, xLabel, yLabel})));
}

/** Lines as CSV: side by side where all have the same points, else one below the other. */
function csvRows(lines, {xLabel, yLabel}) {
  const [first] = lines, same = lines.every(line => line.x.length === first.x.length && line.x.every((x, i) => x === first.x[i]));
  if (same) return [[xLabel, ...lines.map(line => `${line.name}, ${yLabel}`)], ...first.x.map((x, i) => [x, ...lines.map(line => line.y[i])])];
  return [['line', xLabel, yLabel], ...lines.flatMap(line => line.x.map((x, i) => [line.name, x, line.y[i]]))];
}

/** Buttons that save a chart as a picture and its lines as data. */
function savers(svg, lines, labels) {
  const name = fileName(labels.title);
  const button = (text, act) => h('button', {type: 'button', onclick: act, 'aria-label': `${text} of ${labels.title}`}, text);
  return h('span', {class: 'savers'}, button('PNG', async () => savePng(`${name}.png`, await canvasOfSvg(svg))),
    button('SVG', () => saveSvg(`${name}.svg`, svg)),
    button('CSV', () => saveCsv(`${name}.csv`, csvRows(lines, labels))));
}

/** Linear between the points of a line; NaN outside. */
export function valueAt({x, y}, at) {
  for (let i = 1; i < x.length; i++)
    if (at >= x[i - 1] && at <= x[i]) return y[i - 1] + (y[i] - y[i - 1]) * (x[i] === x[i - 1] ? 1 : (at - x[i - 1]) / (x[i] - x[i - 1]));
  return NaN;
}

/** What a history has of a monitor, by instant. */
export const curlFigures = ['curl_m', 'lower_error_m', 'upper_error_m'];

/** The monitor of a history with this name, which is added without its first figures if there is none. */
export function monitorOf(history, name, missing) {
  let monitor = history.monitors.find(m => m.name === name);
  if (!monitor) {
    monitor = {name};
    for (const figure of curlFigures) monitor[figure] = new Array(missing).fill(null);
    history.monitors.push(monitor);
  }
  return monitor;
}

/** The curls of a history with their bands, in mm. */
export const curlLines = (history, suffix = '') => history.monitors.map(monitor => {
  const y = monitor.curl_m.map(v => (v === null ? NaN : 1e3 * v));
  const line = {name: monitor.name + suffix, x: history.time_s, y};
  if (!Number.isFinite(monitor.upper_error_m.at(-1))) return line;
  return {
    ...line,
    low: y.map((v, i) => v - 1e3 * monitor.lower_error_m[i]),
    high: y.map((v, i) => v + 1e3 * monitor.upper_error_m[i])
  };
});

/** The range of curl that a case accepts, in mm; null where it accepts every one. */
export function wantedBand(wanted) {
  const {least_m: least, greatest_m: greatest} = wanted || {};
  if ((least ?? greatest ?? null) === null) return null;
  return {low: least === null ? -Infinity : 1e3 * least, high: greatest === null ? Infinity : 1e3 * greatest};
}

/** A small line without axes. */
export function spark(x, y) {
  const [x0, x1] = range(x), [y0, y1] = range([0, ...y]);
  return h('svg', {viewBox: '0 0 100 24', class: 'spark', 'aria-hidden': 'true', preserveAspectRatio: 'none'},
    h('path', {class: 'line line-0', d: path(x.map((v, i) => [(v - x0) / (x1 - x0) * 100, 22 - (y[i] - y0) / (y1 - y0) * 20]))}));
}
