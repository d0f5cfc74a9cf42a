// Figures behind the charts of the page, and where they are drawn.
import assert from 'node:assert/strict';
import test from 'node:test';

import {chart, ticks, valueAt, wantedBand} from '../../../client/html/assets/chart.js';

/** As much of a document as a chart needs. */
class Element {
  constructor(tag) {
    this.tag = tag;
    this.attributes = {};
    this.children = [];
  }
  setAttribute(name, value) {
    this.attributes[name] = value;
  }
  addEventListener() {}
  append(...children) {
    this.children.push(...children);
  }
  all() {
    return [this, ...this.children.flatMap(child => (child instanceof Element ? child.all() : []))];
  }
  querySelectorAll(tag) {
    return this.all().filter(element => element.tag === tag);
  }
}
globalThis.document = {
  createElement: tag => new Element(tag),
  createElementNS: (_, tag) => new Element(tag)
};

globalThis.ResizeObserver = class {
  observe() {}
};

/** What a chart draws with a class. */
function drawn(lines, name, options = {}) {
  const figure = chart(lines, {title: 'Curl', xLabel: 'time, s', yLabel: 'curl, mm', ...options});
  return figure.all().filter(element => (element.attributes.class ?? '').split(' ').includes(name));
}
const line = {name: 'corner', x: [0, 10, 20, 30], y: [0, 4, 2, 8]};

test('ticks are round, divide the range, and have the decimals of their step', () => {
  assert.deepEqual(ticks(0, 30).values.map(v => v + 0), [0, 5, 10, 15, 20, 25, 30]);
  assert.equal(ticks(0, 30).digits, 0);
  assert.deepEqual(ticks(-0.21, 0.39, 5).values.map(v => Number(v.toFixed(6))), [-0.2, 0, 0.2]);
  assert.equal(ticks(0, 0.05).digits, 2);

  for (const [low, high] of [[0, 1e-4], [3, 1700], [-7, -2], [0.1, 0.3]]) {
    const {values} = ticks(low, high), step = values[1] - values[0];
    assert.ok(values[0] >= low - 1e-9 * step && values.at(-1) <= high + 1e-9 * step);
    assert.ok(values.length >= 2 && values.length <= 7, `${values}`);
    const leading = step / 10 ** Math.floor(Math.log10(step) + 1e-9);
    assert.ok([1, 2, 5].some(f => Math.abs(leading - f) < 1e-6), `${step}`);
  }
});

test('between the points of a line its value is linear, outside there is none', () => {
  assert.equal(valueAt(line, 5), 2);
  assert.equal(valueAt(line, 10), 4);
  assert.equal(valueAt(line, 30), 8);
  assert.equal(valueAt(line, -0.1), NaN);
  assert.equal(valueAt(line, 30.1), NaN);
  assert.equal(valueAt({x: [], y: []}, 1), NaN);
  assert.equal(valueAt({x: [0, 1, 2], y: [3, NaN, 5]}, 1.5), NaN, 'a figure that is missing');
  assert.equal(valueAt({x: [0, 1, 1], y: [2, 4, 6]}, 1), 4, 'of a jump the first');
});

test('a wanted range may have one end, or none', () => {
  assert.deepEqual(wantedBand({least_curl_m: 0.035, greatest_curl_m: 0.045}), {low: 35, high: 45});
  assert.deepEqual(wantedBand({greatest_curl_m: 0.045}), {low: -Infinity, high: 45});
  assert.deepEqual(wantedBand({least_curl_m: 0.035}), {low: 35, high: Infinity});
  assert.equal(wantedBand({}), null);
  assert.equal(wantedBand(undefined), null);
});

test('a line is broken where a figure is missing', () => {
  const pens = y => drawn([{...line, y}], 'line')[0].attributes.d.replace(/[^ML]/g, '');
  assert.equal(pens([0, 4, 2, 8]), 'MLLL');
  assert.equal(pens([0, NaN, 2, 8]), 'MML');
  assert.equal(pens([NaN, NaN, NaN, NaN]), '');
});

test('a line goes from one side of the drawing to the other, its greatest figure highest', () => {
  const points = drawn([line], 'line')[0].attributes.d.split(/[ML]/).slice(1).map(
    point => point.split(' ').map(Number));
  assert.deepEqual([points[0][0], points[3][0]], [52, 888]);
  const heights = points.map(([, y]) => y);
  assert.equal(Math.min(...heights), heights[3]);
  assert.equal(Math.max(...heights), heights[0]);
  assert.equal((heights[0] - heights[1]).toFixed(1), ((heights[0] - heights[3]) / 2).toFixed(1));
});

test('a range without an end reaches to the end of the axis', () => {
  const [closed] = drawn([line], 'wanted', {wanted: {low: 2, high: 6, name: 'plant'}});
  const [open] = drawn([line], 'wanted', {wanted: {low: 2, high: Infinity, name: 'plant'}});
  const foot = ({y, height}) => y + height;
  assert.ok(open.attributes.y < closed.attributes.y);
  assert.ok(Math.abs(foot(open.attributes) - foot(closed.attributes)) < 1e-9);
  assert.equal(drawn([line], 'edge', {wanted: {low: 2, high: Infinity}}).length, 1);
  assert.equal(drawn([line], 'edge', {wanted: {low: 2, high: 6}}).length, 2);
});

test('what is beyond validity is marked to the end', () => {
  assert.equal(drawn([line], 'beyond').length, 0);
  const [region] = drawn([line], 'beyond', {beyond: 15});
  assert.deepEqual([region.attributes.x, region.attributes.width], [470, 418]);
});

test('a band follows the points that have one', () => {
  const banded = {...line, low: [0, 3, NaN, 7], high: [1, 5, NaN, 9]};
  const [band] = drawn([banded], 'band');
  assert.equal(band.attributes.d.replace(/[^MLz]/g, ''), 'MLLLLLz', 'three above, three below');
  assert.equal(drawn([line], 'band').length, 0);
});

test('dots are drawn for the figures that are there, and no line', () => {
  const dotted = {...line, y: [0, NaN, 2, 8], dots: true};
  assert.equal(drawn([dotted], 'dot')[0].children.filter(child => child?.tag === 'circle').length, 3);
  assert.equal(drawn([dotted], 'line').length, 0);
});

test('a small limit can be seen below large figures', () => {
  const shell = {name: 'side', x: [0, 10, 20], y: [300, 4, 60]}, wanted = {low: 5, high: Infinity};
  const [edge] = drawn([shell], 'edge', {wanted}), foot = 280;
  assert.ok(foot - edge.attributes.y1 > 20, 'the limit is a tenth of the axis');
  assert.equal(drawn([line], 'above', {wanted: {low: 3, high: 4}}).length, 0);
  assert.equal(drawn([shell], 'above', {wanted}).length, 1, 'and says that figures lie above');
});

test('on a phone the drawing is as wide as the page, so that letters keep their size', () => {
  const boxOf = () => chart([line], {title: 'Curl', xLabel: 'time, s', yLabel: 'mm'})
    .all().find(element => element.tag === 'svg').attributes.viewBox;
  assert.equal(boxOf(), '0 0 900 320');
  globalThis.innerWidth = 360;
  assert.equal(boxOf(), '0 0 304 320');
  delete globalThis.innerWidth;
});
