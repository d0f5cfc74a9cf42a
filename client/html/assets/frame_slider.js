// Draws a frame into the pictures before it, the last one to begin with, then the one chosen by the
// slider: colour bands cut out of triangles, fronts, outlines. Reads the JSON of frame_slider.cpp.
addEventListener('DOMContentLoaded', () => {  // the caption stands below this script
const box = document.querySelector('.slider'), data = JSON.parse(document.querySelector('.frames').textContent);
const range = box.querySelector('input'), output = box.querySelector('output');
const groups = [...document.querySelectorAll('svg g.now')].slice(0, data.views.length);
const whens = [...document.querySelectorAll('.when')], beyond = [...document.querySelectorAll('.beyond-now')];
const sides = [...document.querySelectorAll('svg g.sides')], last = data.frames.length - 1;
const dim = data.dimension, bands = data.colours.length, [cold, hot] = data.temperature, [from, to] = data.place;
const numbers = text => { const b = atob(text), n = new Uint16Array(b.length / 2);
  for (let i = 0; i < n.length; i++) n[i] = b.charCodeAt(2 * i) | b.charCodeAt(2 * i + 1) << 8; return n; };
const indices = text => { const n = numbers(text);
  return data.wide ? Array.from({length: n.length / 2}, (_, i) => n[2 * i] + 65536 * n[2 * i + 1]) : n; };
const grouped = (flat, size) => { const all = []; for (let i = 0; i < flat.length; i += size) all.push([...flat.slice(i, i + size)]); return all; };
const inOrder = groups => [...new Set(groups.flat())].sort((a, b) => a - b);
const metres = n => from + (to - from) * n / 65535;
const shared = grouped(indices(data.faces), data.corners);
const text = p => p[0].toFixed(1) + ' ' + p[1].toFixed(1);
const band = t => Math.min(bands - 1, Math.max(0, Math.floor(bands * (t - cold) / (hot - cold))));

function read(frame) {
  const faces = (frame.all ? [] : shared.filter(f => Math.max(...f) < frame.nodes)).concat(grouped(indices(frame.own), data.corners));
  const moving = numbers(frame.moving), place = new Map(), warm = new Map();
  inOrder(faces).forEach((node, i) => {
    place.set(node, Array.from({length: dim}, (_, c) => metres(moving[i * (dim + 1) + c])));
    warm.set(node, cold + (hot - cold) * moving[i * (dim + 1) + dim] / 65535); });
  const edges = grouped(indices(frame.edges), 2), still = numbers(frame.still), before = new Map();
  inOrder(edges).forEach((node, i) => before.set(node, Array.from({length: dim}, (_, c) => metres(still[i * dim + c]))));
  return {faces, place, warm, edges, before};
}
const onto = view => p => [view.across, view.down].map(a => p.reduce((sum, x, c) => sum + a[c] * x, a[3]));
// The part of a polygon of [x, y, value] above (sign 1) or below (sign -1) a level.
function cut(polygon, level, sign) {
  const kept = [];
  polygon.forEach((a, i) => { const b = polygon[(i + 1) % polygon.length], u = sign * (a[2] - level), v = sign * (b[2] - level);
    if (u >= 0) kept.push(a);
    if (u > 0 && v < 0 || u < 0 && v > 0) { const s = u / (u - v); kept.push([a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1]), level]); } });
  return kept;
}
function addFace(corners, paths) {
  const values = corners.map(c => c[2]), add = (b, polygon) => { paths[b] += 'M' + polygon.map(text).join('L') + 'z'; };
  if (band(Math.min(...values)) === band(Math.max(...values))) return add(band(values[0]), corners);
  for (let i = 1; i + 1 < corners.length; i++) {
    const triangle = [corners[0], corners[i], corners[i + 1]], v = triangle.map(c => c[2]);
    const first = band(Math.min(...v)), end = band(Math.max(...v)), level = b => cold + b * (hot - cold) / bands;
    for (let b = first; b <= end; b++) {
      let part = triangle;
      if (b > first) part = cut(part, level(b), 1);
      if (b < end) part = cut(part, level(b + 1), -1);
      if (part.length > 2) add(b, part);
    } }
}
const painted = faces => { const paths = Array(bands).fill('');
  faces.forEach(f => addFace(f, paths));
  return paths.map((d, b) => d && `<path fill='${data.colours[b]}' stroke='${data.colours[b]}' stroke-width='.8' d='${d}'/>`).join(''); };
const lines = (edges, at, kind) => `<path class='${kind}' d='${edges.map(e => 'M' + text(at(e[0])) + 'L' + text(at(e[1]))).join('')}'/>`;
function front(corners, level, kind, label) {
  let d = '', leftmost = null;
  for (const face of corners) for (let i = 1; i + 1 < face.length; i++) {
    const t = [face[0], face[i], face[i + 1]], ends = [];
    t.forEach((a, k) => { const b = t[(k + 1) % 3]; if ((a[2] < level) !== (b[2] < level)) {
      const s = (level - a[2]) / (b[2] - a[2]); ends.push([a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]); } });
    if (ends.length === 2) { d += 'M' + text(ends[0]) + 'L' + text(ends[1]);
      for (const p of ends) if (!leftmost || p[0] < leftmost[0]) leftmost = p; } }
  if (!d) return '';
  const name = label ? '' : kind.slice(6) + ' ';
  return `<path class='${kind}' d='${d}'><title>${name}${level.toFixed(0)} °C</title></path>` + (label ? `<text class='isotherm-label' x='${leftmost[0] + 3}' y='${leftmost[1] - 3}'>${level}</text>` : '');
}
function section(frame, view) {
  const at = onto(view), corners = frame.faces.map(f => f.map(n => [...at(frame.place.get(n)), frame.warm.get(n)]));
  return painted(corners) + lines(frame.edges, n => at(frame.before.get(n)), 'undeformed') + lines(frame.edges, n => at(frame.place.get(n)), 'deformed')
    + [100, 200, 300, 400, 500, 600].map(t => front(corners, t, 'isotherm', true)).join('')
    + front(corners, data.fronts[0], 'front solidus') + front(corners, data.fronts[1], 'front liquidus');
}
// Faces from back to front, in some layers: in one of them none hides another for the eye.
function slab(frame, view) {
  const at = onto(view), depth = n => frame.place.get(n).reduce((sum, x, c) => sum + view.to[c] * x, 0), seen = [], edges = new Set();
  for (const face of frame.faces) {
    const corners = face.map(n => [...at(frame.place.get(n)), frame.warm.get(n)]);
    const area = corners.reduce((sum, a, i) => { const b = corners[(i + 1) % corners.length]; return sum + a[0] * b[1] - b[0] * a[1]; }, 0);
    if (area >= 0) continue;
    seen.push([face.reduce((sum, n) => sum + depth(n), 0), corners]);
    face.forEach((n, i) => { const m = face[(i + 1) % face.length]; edges.add(Math.min(n, m) * 2 ** 24 + Math.max(n, m)); });
  }
  seen.sort((a, b) => a[0] - b[0]);
  let svg = ''; const layer = Math.ceil(seen.length / 8);
  for (let i = 0; i < seen.length; i += layer) svg += painted(seen.slice(i, i + layer).map(s => s[1]));
  return svg + lines(frame.edges, n => at(frame.before.get(n)), 'undeformed')
    + lines(frame.edges.filter(e => edges.has(Math.min(...e) * 2 ** 24 + Math.max(...e))), n => at(frame.place.get(n)), 'deformed');
}
function show(number) {
  const stored = data.frames[number], frame = read(stored);
  groups.forEach((g, i) => { g.innerHTML = (dim === 2 ? section : slab)(frame, data.views[i]); });
  sides.forEach(g => { g.style.display = number === last ? '' : 'none'; });  // they have the places of the last frame
  whens.forEach(w => { w.textContent = stored.when; });
  beyond.forEach(b => { b.textContent = stored.beyond ? 'Beyond validity. ' : ''; });
  output.textContent = stored.when;
}
let asked = 0;
range.addEventListener('input', () => { cancelAnimationFrame(asked); asked = requestAnimationFrame(() => show(+range.value)); });
addEventListener('beforeprint', () => show(last));
addEventListener('afterprint', () => show(+range.value));
box.hidden = last === 0;
show(+range.value);  // a browser may keep the place of the slider over a reload
});
