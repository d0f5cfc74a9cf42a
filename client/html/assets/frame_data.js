// A stored frame: its arrays, its fields, and values between its nodes.
/** The arrays of a frame, as frame_bytes.cpp writes them. */
export function readFrame(buffer) {
  const [nodes, elements, perElement, triangles, edges, dimension] = new Int32Array(buffer, 0, 8);
  let at = 32;
  const floats = n => {
    const a = new Float32Array(buffer, at, n);
    at += 4 * n;
    return a;
  };
  const whole = n => {
    const a = new Uint32Array(buffer, at, n);
    at += 4 * n;
    return a;
  };
  const [time, length, liquidus, solidus] = floats(4);
  return {
    nodes,
    elements,
    perElement,
    dimension,
    time,
    length,
    liquidus,
    solidus,
    place: floats(3 * nodes),
    moved: floats(3 * nodes),
    warm: floats(nodes),
    element: whole(elements * perElement),
    triangle: whole(3 * triangles),
    edge: whole(2 * edges)
  };
}

// ---- Fields

// How fields of results.h5 are shown: title, unit of a plant, factor from SI, a fixed range.
const known = {
  temperature_c: ['Temperature', '°C', 1, frame => [20, frame.liquidus || 660]],
  solid_fraction: ['Solid fraction', '', 1, () => [0, 1]],
  von_mises_pa: ['Stress, von Mises', 'MPa', 1e-6],
  principal_stress_pa: ['Stress, largest principal', 'MPa', 1e-6],
  mean_stress_pa: ['Stress, mean', 'MPa', 1e-6],
  equivalent_viscoplastic_strain: ['Strain, viscoplastic', '%', 100],
  thermal_strain: ['Strain, free contraction', '%', 100],
  gap_m: ['Gap to the block', 'mm', 1e3],
  contact_pressure_pa: ['Pressure on the block', 'kPa', 1e-3],
  tear_rate_per_s: ['Hot tears, strain rate', '1/s', 1],
  tear_pressure_pa: ['Hot tears, pressure drop', 'kPa', 1e-3],
};
const order = Object.keys(known);
const plain = {
  degC: '°C',
  's-1': '1/s',
  1: ''
};

export const temperature = {
  name: 'temperature_c',
  on_nodes: true,
  unit: 'degC',
  meaning: ''
};

/**
 * Title, unit, factor from SI and range of a field; a field that is not known is shown in SI
 * units.
 */
export function shown(field) {
  const [title, unit, factor, range] =
    known[field.name] || [field.meaning || field.name, plain[field.unit] ?? field.unit, 1];
  return {title, unit, factor, range};
}

/** The fields that can be chosen, those that are known first. */
export function fieldsOf(listed) {
  const rank = field => (order.indexOf(field.name) + order.length + 1) % (order.length + 1);
  return [temperature, ...listed].sort((a, b) => rank(a) - rank(b));
}

/** Means of the elements around each node. */
function averaged(frame, ofElements) {
  const sum = new Float32Array(frame.nodes), count = new Float32Array(frame.nodes);
  frame.element.forEach((node, i) => {
    sum[node] += ofElements[Math.floor(i / frame.perElement)];
    count[node]++;
  });
  return sum.map((value, node) => value / count[node]);
}

/**
 * A field on the nodes of a frame, in its unit; NaN where it has no value. Fields are kept with
 * the frame.
 * @param read  called without arguments for the bytes of the field, 32-bit floats
 */
export async function fieldValues(frame, field, read) {
  frame.fields ||= new Map([[temperature.name, frame.warm]]);
  if (frame.fields.has(field.name)) return frame.fields.get(field.name);

  const given = new Float32Array(await read());
  const values =
    (field.on_nodes ? given : averaged(frame, given)).map(v => v * shown(field).factor);
  frame.fields.set(field.name, values);
  return values;
}

/**
 * Of a section the values of the bottom alone make a line: drawn as high as the lowest elements.
 */
export function spreadFromBottom(frame, values) {
  if (frame.dimension === 3 || values.every(Number.isFinite)) return values;
  const spread = values.slice();
  for (let e = 0; e < frame.element.length; e += frame.perElement) {
    const nodes = [...frame.element.subarray(e, e + frame.perElement)];
    const has = nodes.map(n => values[n]).filter(Number.isFinite);
    if (has.length === 0) continue;
    const mean = has.reduce((a, b) => a + b) / has.length;
    for (const n of nodes)
      if (!Number.isFinite(values[n])) spread[n] = mean;
  }
  return spread;
}

/**
 * A round magnification (1, 2, 5, 10, 20) of the displacements that makes the motion of the bottom
 * visible without distorting the rest: metal near the level may have moved much further.
 */
export function magnification({nodes, place, moved}) {
  let lowest = Infinity, extent = 0, largest = 0, shown = 0;
  for (let n = 0; n < nodes; n++) lowest = Math.min(lowest, place[3 * n + 2]);
  for (let n = 0; n < nodes; n++) {
    const length = Math.hypot(...moved.subarray(3 * n, 3 * n + 3));
    extent = Math.max(extent, place[3 * n]);
    largest = Math.max(largest, length);
    if (place[3 * n + 2] < lowest + 1e-6) shown = Math.max(shown, length);
  }
  if (largest === 0) return 1;
  const wanted = Math.min(extent / (15 * (shown || largest)), 0.25 * extent / largest);
  return [20, 10, 5, 2].find(scale => scale <= wanted) || 1;
}

// ---- Inside the elements

// A hexahedron in six tetrahedra around its diagonal from node 0 to node 6.
const hexahedron =
  [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];
const simplices = {
  2: {3: [[0, 1, 2]], 4: [[0, 1, 2], [0, 2, 3]]},
  3: {4: [[0, 1, 2, 3]], 8: hexahedron},
};

/** In place of an axis: the surface on which a field has a value. */
export const byValue = 3;

/**
 * What a plane, or a surface of one value, shows of the inside: triangles with place, displacement and value.
 * @param axis  0 to 2, or byValue @param at  its place [m], or the value
 */
export function cut(frame, values, axis, at) {
  const {place, moved, element, perElement} = frame, out = [];
  const along = axis === byValue ? n => values[n] : n => place[3 * n + axis];
  const add = (a, b) => {
    const s = (at - along(a)) / (along(b) - along(a));
    for (const field of [place, moved])
      for (let c = 0; c < 3; c++)
        out.push(field[3 * a + c] + s * (field[3 * b + c] - field[3 * a + c]));
    out.push(values[a] + s * (values[b] - values[a]));
  };

  const tetrahedron = (...corners) => {
    const below = [], above = [];
    for (const n of corners) (along(n) < at ? below : above).push(n);
    if (below.length === 0 || above.length === 0) return;
    if (below.length === 2) {
      const [p, q] = below, [r, s] = above;
      add(p, r);
      add(p, s);
      add(q, s);
      add(p, r);
      add(q, s);
      add(q, r);
    } else {
      const [one] = below.length === 1 ? below : above;
      for (const other of below.length === 1 ? above : below) add(one, other);
    }
  };

  const parts = simplices[3][perElement] || [];
  for (let e = 0; e < element.length; e += perElement) {
    let below = 0;
    for (let k = e; k < e + perElement; k++)
      if (along(element[k]) < at) below++;
    if (below === 0 || below === perElement) continue;
    for (const part of parts) tetrahedron(...part.map(k => element[e + k]));
  }
  return new Float32Array(out);
}

/** Least and greatest coordinates of each element, (element, 6). */
function boxesOf(frame) {
  if (frame.boxes) return frame.boxes;
  const boxes = new Float32Array(6 * frame.elements);
  for (let e = 0; e < frame.elements; e++)
    for (let c = 0; c < 3; c++) {
      let low = Infinity, high = -Infinity;
      for (let k = 0; k < frame.perElement; k++) {
        const v = frame.place[3 * frame.element[e * frame.perElement + k] + c];
        low = Math.min(low, v);
        high = Math.max(high, v);
      }
      boxes[6 * e + c] = low;
      boxes[6 * e + 3 + c] = high;
    }
  frame.boxes = boxes;
  return boxes;
}

/**
 * Barycentric weights of a point, by solving for its place between the corners; null if they span
 * nothing.
 */
function weightsIn(frame, corners, point, coordinates) {
  const size = coordinates.length;
  const place = (node, c) => frame.place[3 * node + c];
  const rows = coordinates.map(
    c =>
      [...corners.slice(1).map(n => place(n, c) - place(corners[0], c)),
       point[c] - place(corners[0], c)]);

  // Gauss with pivots; of two or three unknowns.
  for (let i = 0; i < size; i++) {
    const pivot = rows.slice(i).reduce(
      (most, row, k) => (Math.abs(row[i]) > Math.abs(rows[most][i]) ? i + k : most), i);
    [rows[i], rows[pivot]] = [rows[pivot], rows[i]];
    if (Math.abs(rows[i][i]) < 1e-14) return null;
    for (let k = 0; k < size; k++) {
      if (k === i) continue;
      const factor = rows[k][i] / rows[i][i];
      for (let j = i; j <= size; j++) rows[k][j] -= factor * rows[i][j];
    }
  }
  const rest = rows.map((row, i) => row[size] / row[i]);
  return [1 - rest.reduce((a, b) => a + b), ...rest];
}

/**
 * Where a point of the undeformed slab is in its mesh.
 * @param point  [x, y, z] in m; of a section y is 0
 * @return {nodes, weights}; null where there is no metal
 */
export function locate(frame, point) {
  const coordinates = frame.dimension === 3 ? [0, 1, 2] : [0, 2];
  const parts = simplices[frame.dimension][frame.perElement] || [], boxes = boxesOf(frame);
  const near = 1e-6;  // [m] on the surface is inside
  for (let e = 0; e < frame.elements; e++) {
    if (coordinates.some(
          c => point[c] < boxes[6 * e + c] - near || point[c] > boxes[6 * e + 3 + c] + near))
      continue;
    for (const part of parts) {
      const nodes = part.map(k => frame.element[e * frame.perElement + k]);
      const weights = weightsIn(frame, nodes, point, coordinates);
      if (weights && weights.every(w => w > -1e-4)) return {nodes, weights};
    }
  }
  return null;
}

/** Values of a field at a place of locate(); NaN where there is none. */
export const valueAtPlace = (place, values, components = 1, component = 0) =>
  (place ? place.nodes.reduce(
             (sum, node, i) => sum + place.weights[i] * values[components * node + component], 0)
         : NaN);
