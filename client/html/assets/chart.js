// Line charts in SVG: lines, bands around them, a wanted range, a value under the pointer.
import {fixed, h} from './dom.js';
import {canvasOfSvg, fileName, saveCsv, savePng, saveSvg} from './save.js';

const height = 320, left = 52, right = 12, top = 22, bottom = 40;

/**
 * Units across a drawing: on a page that is narrower, as on a phone, those of the page, so that
 * letters keep their size.
 */
const drawingWidth = (wanted = 900) =>
  Math.min(wanted, Math.max(300, (globalThis.innerWidth ?? wanted + 56) - 56));

/**
 * What is drawn, made anew when drawings get another width, as when a phone is turned.
 * @param draw  (width) of the drawing; gives one element
 */
export function fitted(draw, wanted) {
  const width = drawingWidth(wanted), drawn = draw(width);
  new ResizeObserver((_, observer) => {
    if (drawingWidth(wanted) === width || !drawn.isConnected) return;
    observer.disconnect();
    requestAnimationFrame(() => drawn.replaceWith(fitted(draw, wanted)));
  }).observe(drawn);
  return drawn;
}

/** Round values that divide a range. */
export function ticks(low, high, about = 6) {
  const raw = (high - low) / about, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map(f => f * power).find(s => s >= raw) || power;

  const values = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++)
    values.push(i * step);
  return {values, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
}

/** Least and greatest of the finite values; of a single one a range around it. */
function range(values) {
  let low = Infinity, high = -Infinity;
  for (const v of values) {
    if (!Number.isFinite(v)) continue;
    low = Math.min(low, v);
    high = Math.max(high, v);
  }
  if (!(low <= high)) return [0, 1];
  return low === high ? [low - 0.5, high + 0.5] : [low, high];
}

/** A path through points; it is broken where there is no figure. */
const path = points => {
  let d = '', pen = 'M';
  for (const [x, y] of points) {
    if (!Number.isFinite(y)) {
      pen = 'M';
      continue;
    }
    d += `${pen}${x.toFixed(1)} ${y.toFixed(1)}`;
    pen = 'L';
  }
  return d;
};

/** Ranges of the axes, and where a value lies in the drawing. `above`: figures exceed the axis. */
function placement(lines, wanted, width) {
  const [x0, x1] = range(lines.flatMap(line => line.x));
  const [y0, highest] = range([
    0,
    ...lines.flatMap(line => [...line.y, ...(line.low || []), ...(line.low ? line.high : [])]),
    ...(wanted ? [wanted.low, wanted.high] : [])
  ]);
  // A least value that is wanted can be told from zero, however large the figures are.
  const most = wanted?.low > 0 ? 10 * wanted.low : Infinity, y1 = Math.min(highest, most);
  const across = width - left - right, up = height - top - bottom;
  const px = x => left + (x - x0) / (x1 - x0) * across;
  const py = y => {
    const placed = height - bottom - (y - y0) / (y1 - y0) * up;
    return Math.max(top, Math.min(height - bottom, placed));  // an infinite end is that of the axis
  };
  const xAt = pixel => x0 + (pixel - left) / across * (x1 - x0);
  return {x0, x1, y0, y1, px, py, xAt, above: highest > y1};
}

/** The range that is wanted, with dashed edges where it ends. */
function wantedRegion({low, high, name}, py, end) {
  const [foot, head] = [py(low), py(high)];
  const edges = [[low, foot], [high, head]].filter(([value]) => Number.isFinite(value));
  return [
    h('rect', {class: 'wanted', x: left, width: end - left, y: head, height: foot - head}),
    edges.map(([, y]) => h('line', {class: 'edge', x1: left, x2: end, y1: y, y2: y})),
    name ? h('text', {x: left + 6, y: head + 14}, name) : null
  ].flat();
}

/** Where the model of a run is no longer valid. */
const beyondRegion = (from, end) => [
  h('rect', {class: 'beyond', x: from, width: end - from, y: top, height: height - bottom - top}),
  h('text', {x: end - 4, y: height - bottom - 6, 'text-anchor': 'end'}, 'beyond validity')
];

/** Says that lines at the upper edge lie above it. */
const aboveNote = end =>
  h('text', {class: 'above', x: end - 4, y: top - 8, 'text-anchor': 'end'}, 'more lies above');

/** Grid, figures at the axes, and what the axes are. */
function axes({x0, x1, y0, y1, px, py}, end, {xLabel, yLabel}) {
  const across = ticks(x0, x1, end < 500 ? 4 : 6), up = ticks(y0, y1, 5);
  const grid = v =>
    h('line', {class: v === 0 ? 'zero' : 'grid', x1: left, x2: end, y1: py(v), y2: py(v)});
  const atLeft = v => h('text', {x: left - 6, y: py(v) + 4, 'text-anchor': 'end'}, fixed(v, up.digits));
  const below = v => {
    const anchor = px(v) > end - 16 ? 'end' : 'middle';  // the last text is not cut
    return h('text', {x: px(v), y: height - bottom + 16, 'text-anchor': anchor}, fixed(v, across.digits));
  };

  return [
    up.values.flatMap(v => [grid(v), atLeft(v)]),
    across.values.map(below),
    h('text', {x: (left + end) / 2, y: height - 6, 'text-anchor': 'middle'}, xLabel),
    h('text', {x: 12, y: top - 8, 'text-anchor': 'start', class: 'unit'}, yLabel)
  ].flat();
}

const colourOf = (line, i) => `line-${(line.colour ?? i) % 6}`;

/** The band of a line, or nothing. */
function band(line, i, {px, py}) {
  if (!line.low) return null;
  const edge = values => line.x.map((x, k) => [px(x), py(values[k])]).filter(([, y]) => Number.isFinite(y));
  const around = [...edge(line.high), ...edge(line.low).reverse()];
  return h('path', {class: `band ${colourOf(line, i)}`, d: `${path(around)}z`});
}

/** A line, or a dot for each of its points. */
function curve(line, i, {px, py}) {
  if (!line.dots)
    return h('path', {
      class: `line ${colourOf(line, i)}${line.dashed ? ' dashed' : ''}`,
      d: path(line.x.map((x, k) => [px(x), py(line.y[k])]))
    });

  const dot = (x, k) =>
    Number.isFinite(line.y[k]) ? h('circle', {cx: px(x), cy: py(line.y[k]), r: 3}) : null;
  return h('g', {class: `dot ${colourOf(line, i)}`}, line.x.map(dot));
}

function legendOf(lines) {
  const swatch = (line, i) =>
    h('span', {class: `swatch ${colourOf(line, i)}${line.dashed ? ' dashed' : ''}`});
  return h('ul', {class: 'legend', 'aria-hidden': 'true'},
    lines.map((line, i) => h('li', {}, swatch(line, i), line.name, h('output', {}, ''))));
}

/** Shows in the legend what the lines are where the pointer is. */
function followPointer(svg, cursor, legend, lines, {x0, x1, px, xAt}, width) {
  const values = legend.querySelectorAll('output');
  const moveCursor = pixel => {
    cursor.setAttribute('x1', pixel);
    cursor.setAttribute('x2', pixel);
  };

  svg.addEventListener('pointermove', event => {
    const box = svg.getBoundingClientRect();
    const x = xAt((event.clientX - box.left) / box.width * width);
    const text = line => x < x0 || x > x1 ? '' : ` ${fixed(valueAt(line, x), 2)} at ${fixed(x, 0)}`;
    moveCursor(px(x));
    lines.forEach((line, i) => { values[i].textContent = text(line); });
  });
  svg.addEventListener('pointerleave', () => {
    moveCursor(-9);
    values.forEach(value => { value.textContent = ''; });
  });
}

/**
 * @param lines    [{name, x, y, low and high: its band, dashed, dots: one for each point and no line,
 *   colour: 0 to 5}]
 * @param options  {title, xLabel, yLabel, unit of y,
 *   wanted: {low, high, name} as y, infinite where it has no end,
 *   beyond: x from which on the model is not valid, width: of the drawing}
 */
export const chart = (lines, options) => fitted(width => figure(lines, options, width), options.width);

function figure(lines, options, width) {
  const {title, xLabel, yLabel, wanted = null, beyond = Infinity, unit = 'mm'} = options;
  const place = placement(lines, wanted, width), end = width - right;

  const parts = [
    beyond < place.x1 ? beyondRegion(place.px(Math.max(beyond, place.x0)), end) : [],
    wanted ? wantedRegion(wanted, place.py, end) : [],
    place.above ? aboveNote(end) : [],
    axes(place, end, {xLabel, yLabel}),
    lines.map((line, i) => band(line, i, place)),
    lines.map((line, i) => curve(line, i, place))
  ].flat();

  const summary = lines.map(line => `${line.name} ends at ${fixed(line.y.at(-1), 1)} ${unit}`).join(', ');
  const cursor = h('line', {class: 'cursor', y1: top, y2: height - bottom, x1: -9, x2: -9});
  const svg = h('svg', {
    viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `${title}: ${summary}`
  }, parts, cursor);
  const legend = legendOf(lines);
  followPointer(svg, cursor, legend, lines, place, width);

  const caption = h('figcaption', {},
    h('span', {class: 'title'}, title), savers(svg, lines, {title, xLabel, yLabel}));
  return h('figure', {}, svg, legend, caption);
}

/** Lines as CSV: side by side where all have the same points, else one below the other. */
function csvRows(lines, {xLabel, yLabel}) {
  const [first] = lines;
  const isLike = line => line.x.length === first.x.length && line.x.every((x, i) => x === first.x[i]);
  if (lines.every(isLike))
    return [
      [xLabel, ...lines.map(line => `${line.name}, ${yLabel}`)],
      ...first.x.map((x, i) => [x, ...lines.map(line => line.y[i])])
    ];
  return [
    ['line', xLabel, yLabel],
    ...lines.flatMap(line => line.x.map((x, i) => [line.name, x, line.y[i]]))
  ];
}

/** Buttons that save a chart as a picture and its lines as data. */
function savers(svg, lines, labels) {
  const name = fileName(labels.title);
  const button = (text, act) =>
    h('button', {type: 'button', onclick: act, 'aria-label': `${text} of ${labels.title}`}, text);
  return h('span', {class: 'savers'},
    button('PNG', async () => savePng(`${name}.png`, await canvasOfSvg(svg))),
    button('SVG', () => saveSvg(`${name}.svg`, svg)),
    button('CSV', () => saveCsv(`${name}.csv`, csvRows(lines, labels))));
}

/** Linear between the points of a line; NaN outside. */
export function valueAt({x, y}, at) {
  for (let i = 1; i < x.length; i++) {
    if (!(at >= x[i - 1] && at <= x[i])) continue;
    const share = x[i] === x[i - 1] ? 1 : (at - x[i - 1]) / (x[i] - x[i - 1]);
    return y[i - 1] + (y[i] - y[i - 1]) * share;
  }
  return NaN;
}

/**
 * The range of curl that a case accepts, in mm; null where it accepts every one.
 * @param wanted  `plausibility` of the case
 */
export function wantedBand(wanted) {
  const {least_curl_m: least, greatest_curl_m: greatest} = wanted || {};
  if ((least ?? greatest) === undefined) return null;
  return {low: 1e3 * (least ?? -Infinity), high: 1e3 * (greatest ?? Infinity)};
}

/** A small line without axes. */
export function spark(x, y) {
  const [x0, x1] = range(x), [y0, y1] = range([0, ...y]);
  const points = x.map((v, i) => [(v - x0) / (x1 - x0) * 100, 22 - (y[i] - y0) / (y1 - y0) * 20]);
  const frame = {viewBox: '0 0 100 24', class: 'spark', 'aria-hidden': 'true', preserveAspectRatio: 'none'};
  return h('svg', frame, h('path', {class: 'line line-0', d: path(points)}));
}
