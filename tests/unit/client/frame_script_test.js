// Runs the script that draws frames against a page of stubs. Argument: client/html/assets/frame_slider.js.
'use strict';
const assert = require('assert'), fs = require('fs');
const script = fs.readFileSync(process.argv[2], 'utf8');

const numbers = list => Buffer.from(Uint16Array.from(list).buffer).toString('base64');
const most = 65535;

// The page of some data, loaded; listeners are called by their names.
function load(data) {
  const element = () => ({innerHTML: '', textContent: '', style: {}, listeners: {},
    addEventListener(name, call) { this.listeners[name] = call; }});
  const range = element(), output = element(), box = element(), window = {};
  range.value = String(data.frames.length - 1);
  box.querySelector = name => (name === 'input' ? range : output);
  const groups = data.views.map(element), sides = [element()], when = [element()], beyond = [element()];
  const all = {'svg g.now': groups, 'svg g.sides': sides, '.when': when, '.beyond-now': beyond};
  const document = {querySelectorAll: name => all[name],
    querySelector: name => (name === '.slider' ? box : {textContent: JSON.stringify(data)})};
  new Function('addEventListener', 'document', 'atob', 'requestAnimationFrame', 'cancelAnimationFrame', script)(
    (name, call) => { window[name] = call; }, document, text => Buffer.from(text, 'base64').toString('latin1'),
    call => call(), () => {});
  window.DOMContentLoaded();
  const slide = to => { range.value = String(to); range.listeners.input(); };
  return {groups, sides, when, beyond, box, output, window, slide};
}

const polygons = svg => [...svg.matchAll(/<path fill='[^']*' stroke='[^']*' stroke-width='.8' d='([^']*)'/g)]
  .flatMap(found => found[1].split('z').filter(d => d).map(d => d.slice(1).split('L').map(p => p.split(' ').map(Number))));
const area = p => Math.abs(p.reduce((sum, a, i) => { const b = p[(i + 1) % p.length]; return sum + a[0] * b[1] - b[0] * a[1]; }, 0)) / 2;
const edges = (svg, kind) => (svg.match(new RegExp(`class='${kind}' d='([^']*)'`))[1].match(/M/g) || []).length;

// A square of 1 m, from 0 to 650 degrees left to right; the corner at the lower right has moved up by 0.2 m.
const square = (hottest, up) => ({when: `${hottest}`, beyond: hottest < 600, nodes: 4, own: '', all: false,
  moving: numbers([0, 0, 0, most, up * most, hottest / 650 * most, most, most, hottest / 650 * most, 0, most, 0]),
  edges: numbers([0, 1, 1, 2, 2, 3, 0, 3]), still: numbers([0, 0, most, 0, most, most, 0, most])});
const section = {dimension: 2, corners: 4, place: [0, 1], temperature: [0, 650], fronts: [620, 649],
  colours: ['#000', '#111', '#222'], faces: numbers([0, 1, 2, 3]),
  views: [{across: [100, 0, 0, 10], down: [0, -100, 0, 110], to: [0, 0, 0]}], frames: [square(300, 0), square(650, 0.2)]};

const page = load(section);
let svg = page.groups[0].innerHTML;
assert.strictEqual(page.when[0].textContent, '650', 'the last frame is drawn without a touch');
assert.strictEqual(page.box.hidden, false);
assert.ok(Math.abs(polygons(svg).reduce((sum, p) => sum + area(p), 0) - 9000) < 5, 'bands cover the deformed square once');
assert.strictEqual(edges(svg, 'deformed'), 4);
assert.strictEqual(edges(svg, 'undeformed'), 4);
assert.deepStrictEqual([...svg.matchAll(/<title>([^<]*)<\/title>/g)].map(t => t[1]),
  ['100 °C', '200 °C', '300 °C', '400 °C', '500 °C', '600 °C', 'solidus 620 °C', 'liquidus 649 °C']);
page.slide(0);
svg = page.groups[0].innerHTML;
assert.ok(Math.abs(polygons(svg).reduce((sum, p) => sum + area(p), 0) - 10000) < 5);
assert.ok(!svg.includes('solidus'), 'nothing is as hot');
assert.strictEqual(page.beyond[0].textContent, 'Beyond validity. ');
assert.strictEqual(page.sides[0].style.display, 'none');
page.window.beforeprint();
assert.strictEqual(page.output.textContent, '650', 'the last one is printed');
page.window.afterprint();
assert.strictEqual(page.output.textContent, '300');
assert.strictEqual(load({...section, frames: [square(650, 0)]}).box.hidden, true, 'no slider over one frame');

// Node numbers in two halves, as beyond 65535 nodes.
const halves = list => numbers(list.flatMap(n => [n, 0]));
const wide = {...section, wide: true, faces: halves([0, 1, 2, 3]),
  frames: [{...square(650, 0.2), edges: halves([0, 1, 1, 2, 2, 3, 0, 3])}]};
assert.strictEqual(load(wide).groups[0].innerHTML, load(section).groups[0].innerHTML);

// A cube of 1 m, seen along its diagonal: three faces, and of its twelve edges nine.
const corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
const cube = {dimension: 3, corners: 4, place: [0, 1], temperature: [0, 650], fronts: [620, 649], colours: ['#000', '#111'],
  faces: numbers([0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7]),
  views: [{across: [-50, 50, 0, 100], down: [30, 30, -60, 100], to: [0.577, 0.577, 0.577]}],
  frames: [{when: 'now', beyond: false, nodes: 8, own: '', all: false,
    moving: numbers(corners.flatMap(p => [...p.map(x => x * most), 0])), still: numbers(corners.flat().map(x => x * most)),
    edges: numbers([0, 1, 1, 2, 2, 3, 0, 3, 4, 5, 5, 6, 6, 7, 4, 7, 0, 4, 1, 5, 2, 6, 3, 7])}]};
svg = load(cube).groups[0].innerHTML;
assert.strictEqual(polygons(svg).length, 3);
assert.strictEqual(edges(svg, 'deformed'), 9);
assert.strictEqual(edges(svg, 'undeformed'), 12);
console.log('frames are drawn as expected');
