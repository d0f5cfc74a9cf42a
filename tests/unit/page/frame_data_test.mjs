// Frames as the page reads and cuts them. Meshes are distorted, fields are linear: what the page
// interpolates must meet them everywhere.
import assert from 'node:assert/strict';
import test from 'node:test';

import {
  byValue, cut, fieldsOf, fieldValues, locate, magnification, readFrame, shown, spreadFromBottom, temperature,
  valueAtPlace
} from '../../../client/html/assets/frame_data.js';

const single = 1e-6;  // coordinates are 32-bit floats

function assertNear(found, exact, tolerance, message) {
  assert.ok(Math.abs(found - exact) <= tolerance, `${message ?? ''} ${found} is not ${exact}`);
}

/** The bytes of a frame, as client/html/frame_bytes.cpp writes them. */
function bytesOf({place, moved, warm, element, perElement, triangle = [], edge = [], dimension}) {
  const nodes = place.length / 3, elements = element.length / perElement;
  const header =
    [nodes, elements, perElement, triangle.length / 3, edge.length / 2, dimension, 0, 0];
  return new Uint8Array([
    new Int32Array(header), new Float32Array([12, 0.5, 650, 630]), new Float32Array(place),
    new Float32Array(moved ?? place.map(() => 0)), new Float32Array(warm ?? Array(nodes).fill(20)),
    new Uint32Array(element), new Uint32Array(triangle), new Uint32Array(edge)
  ].flatMap(part => [...new Uint8Array(part.buffer)])).buffer;
}
const frameOf = parts => readFrame(bytesOf(parts));

const field = (x, y, z) => 3 + 2 * x - y + 5 * z;
const valuesOn = frame => Float32Array.from(
  {length: frame.nodes}, (_, n) => field(...frame.place.subarray(3 * n, 3 * n + 3)));

/** Two cells of a section whose nodes in the middle are moved, or four triangles. */
function section(triangles) {
  const place = [0, 0, 0, 0.4, 0, 0.1, 1, 0, 0, 0, 0, 1, 0.6, 0, 0.9, 1, 0, 1];
  const element = triangles ? [0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4] : [0, 1, 4, 3, 1, 2, 5, 4];
  return frameOf({place, element, perElement: triangles ? 3 : 4, dimension: 2});
}

/** A unit cube of eight hexahedra or 48 tetrahedra; the node in its middle is moved. */
function cube(tetrahedra) {
  const place = [], element = [];
  const node = (i, j, k) => 9 * k + 3 * j + i;
  for (let k = 0; k < 3; k++)
    for (let j = 0; j < 3; j++)
      for (let i = 0; i < 3; i++) place.push(i / 2, j / 2, k / 2);
  [0.06, -0.04, 0.05].forEach((shift, c) => { place[3 * node(1, 1, 1) + c] += shift; });

  const parts =
    [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
  for (let k = 0; k < 2; k++)
    for (let j = 0; j < 2; j++)
      for (let i = 0; i < 2; i++) {
        const cell = [
          node(i, j, k), node(i + 1, j, k), node(i + 1, j + 1, k), node(i, j + 1, k),
          node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)
        ];
        element.push(...(tetrahedra ? parts.flat().map(corner => cell[corner]) : cell));
      }
  return frameOf({
    place, element, perElement: tetrahedra ? 4 : 8, dimension: 3,
    moved: place.map((x, i) => (i % 3 === 2 ? 0.01 * x : 0))
  });
}

/** Area of triangles of seven figures for each corner: place, displacement, value. */
function areaOf(corners) {
  let area = 0;
  for (let t = 0; t < corners.length; t += 21) {
    const [a, b, c] = [0, 7, 14].map(k => corners.subarray(t + k, t + k + 3));
    const [u, v] = [b, c].map(p => [0, 1, 2].map(i => p[i] - a[i]));
    area += Math.hypot(
      u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]) / 2;
  }
  return area;
}

// ---- Reading

test('a frame is read as it was written', () => {
  const parts = {
    place: [0, 0, 0, 1, 0, 0, 0, 0, 1], moved: [0, 0, 0, 0, 0, 0, 0, 0, 0.25], warm: [600, 610, 620],
    element: [0, 1, 2], perElement: 3, triangle: [2, 1, 0], edge: [0, 1, 1, 2], dimension: 2
  };
  const frame = frameOf(parts);
  assert.deepEqual([frame.nodes, frame.elements, frame.perElement, frame.dimension], [3, 1, 3, 2]);
  assert.deepEqual([frame.time, frame.length, frame.liquidus, frame.solidus], [12, 0.5, 650, 630]);
  for (const name of ['place', 'moved', 'warm', 'element', 'triangle', 'edge'])
    assert.deepEqual([...frame[name]], parts[name], name);
});

test('known fields come first, in the units of a plant; others keep theirs', () => {
  const names = fieldsOf([{name: 'b'}, {name: 'gap_m'}, {name: 'solid_fraction'}]).map(f => f.name);
  assert.deepEqual(names, ['temperature_c', 'solid_fraction', 'gap_m', 'b']);
  assert.deepEqual([shown({name: 'gap_m'}).unit, shown({name: 'gap_m'}).factor], ['mm', 1e3]);
  assert.deepEqual(shown(temperature).range({liquidus: 650}), [20, 650]);

  const other = shown({name: 'rate', meaning: 'A rate', unit: 's-1'});
  assert.deepEqual([other.title, other.unit, other.factor], ['A rate', '1/s', 1]);
  assert.equal(shown({name: 'rate', unit: 'kg'}).title, 'rate');
});

test('a field of elements becomes the mean around each node, and is read once', async () => {
  const frame = section(false);
  let reads = 0;
  const read = async () => {
    reads++;
    return new Float32Array([2e6, 4e6]).buffer;
  };
  const stress = {name: 'von_mises_pa', on_nodes: false};
  const values = await fieldValues(frame, stress, read);
  assert.deepEqual([...values].map(v => Number(v.toFixed(6))), [2, 3, 4, 2, 3, 4]);
  assert.equal(await fieldValues(frame, stress, read), values);
  assert.equal(reads, 1);

  const nodal = await fieldValues(
    frame, {name: 'gap_m', on_nodes: true}, async () => new Float32Array(6).fill(0.002).buffer);
  assertNear(nodal[5], 2, single);
  assert.equal(await fieldValues(frame, temperature, assert.fail), frame.warm);
});

test('of a section the values of the bottom fill the lowest elements', () => {
  const bottom = [1, 3, 5, NaN, NaN, NaN];
  const spread = spreadFromBottom(section(false), bottom);
  assert.deepEqual([...spread.slice(0, 4), spread[5]], [1, 3, 5, 2, 4]);
  assert.ok(spread[4] >= 2 && spread[4] <= 4, 'a node of both elements');
  assert.deepEqual(bottom.slice(3), [NaN, NaN, NaN], 'what was given stays');

  const solid = {...section(false), dimension: 3};
  assert.equal(spreadFromBottom(solid, bottom), bottom);
});

test('displacements are magnified by a round figure that shows the bottom', () => {
  const place = [0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 1];
  const of = (bottom, top) =>
    magnification({nodes: 4, place, moved: new Float32Array([0, 0, 0, 0, 0, bottom, 0, 0, 0, 0, 0, top])});
  assert.equal(of(0, 0), 1, 'nothing moves');
  assert.equal(of(0.1, 0), 1);
  assert.equal(of(0.01, 0), 5, 'a fifteenth of the width over 10 mm');
  assert.equal(of(0.001, 0), 20, 'no more than this');
  assert.equal(of(0.001, 0.1), 2, 'the top must not leave the picture');
});

// ---- Inside the elements

for (const tetrahedra of [false, true]) {
  const kind = tetrahedra ? 'tetrahedra' : 'hexahedra';

  test(`a plane through ${kind} is covered once, by a linear field`, () => {
    const frame = cube(tetrahedra), values = valuesOn(frame);
    for (const [axis, at] of [[0, 0.3], [1, 0.71], [2, 0.52]]) {
      const corners = cut(frame, values, axis, at);
      assertNear(areaOf(corners), 1, 10 * single, `axis ${axis}`);
      for (let c = 0; c < corners.length; c += 7) {
        const [x, y, z, , , up, value] = corners.subarray(c, c + 7);
        assertNear([x, y, z][axis], at, single);
        assertNear(value, field(x, y, z), 10 * single);
        assertNear(up, 0.01 * z, single, 'displacement');
      }
    }
  });

  test(`on a surface through ${kind} a field has one value`, () => {
    const frame = cube(tetrahedra), corners = cut(frame, valuesOn(frame), byValue, 6.2);
    assert.ok(corners.length > 0);
    for (let c = 0; c < corners.length; c += 7) {
      assertNear(field(...corners.subarray(c, c + 3)), 6.2, 10 * single);
      assertNear(corners[c + 6], 6.2, 10 * single);
    }
  });

  test(`beside ${kind} there is nothing to cut`, () => {
    const frame = cube(tetrahedra);
    for (const at of [-0.1, 1.1]) assert.equal(cut(frame, valuesOn(frame), 2, at).length, 0);
  });

  test(`a linear field is met at any point of ${kind}`, () => {
    const frame = cube(tetrahedra), values = valuesOn(frame);
    for (let n = 0; n < 200; n++) {
      const point = [0.618, 0.414, 0.732].map(step => (n * step) % 1);
      assertNear(valueAtPlace(locate(frame, point), values), field(...point), 20 * single, point);
    }
    for (const corner of [[0, 0, 0], [1, 1, 1], [1, 0, 0.5]])
      assertNear(valueAtPlace(locate(frame, corner), values), field(...corner), 20 * single, corner);
  });

  test(`no point outside is in ${kind}`, () => {
    for (const point of [[1.01, 0.5, 0.5], [0.5, -0.01, 0.5], [0.5, 0.5, 1.01]])
      assert.equal(locate(cube(tetrahedra), point), null);
  });
}

for (const triangles of [false, true])
  test(`a linear field is met in a section of ${triangles ? 'triangles' : 'quadrilaterals'}`, () => {
    const frame = section(triangles), values = valuesOn(frame);
    for (let n = 0; n < 100; n++) {
      const point = [(n * 0.618) % 1, 0, 0.12 + 0.75 * ((n * 0.414) % 1)];
      const place = locate(frame, point);
      assertNear(valueAtPlace(place, values), field(...point), 20 * single, point);
      assertNear(place.weights.reduce((a, b) => a + b), 1, single);
    }
    assert.equal(locate(frame, [0.5, 0, 0.05]), null, 'under the bottom, which bends upwards');
    assert.equal(locate(frame, [1.1, 0, 0.5]), null);
  });

test('of a vector one component is asked for; where there is no metal there is no value', () => {
  const place = {nodes: [0, 1], weights: [0.25, 0.75]};
  assert.equal(valueAtPlace(place, [1, 10, 3, 30], 2, 1), 25);
  assert.equal(valueAtPlace(null, [1, 2]), NaN);
});
