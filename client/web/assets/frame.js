// A stored frame in WebGL: orbit, cut, deformation, time, and the values under the pointer. A section is drawn flat.
import {get, getBytes} from './api.js';
import {ticks} from './chart.js';
import {fixed, h, replace} from './dom.js';

/** The arrays of /frame, as dashboard.cpp writes them. */
export function readFrame(buffer) {
  const counts = new Int32Array(buffer, 0, 8), [nodes, elements, perElement, triangles, edges, dimension] = counts;
  let at = 32;
  const floats = n => { const a = new Float32Array(buffer, at, n); at += 4 * n; return a; };
  const whole = n => { const a = new Uint32Array(buffer, at, n); at += 4 * n; return a; };
  const [time, length, liquidus, solidus] = floats(4);
  return {nodes, elements, perElement, dimension, time, length, liquidus, solidus,
    place: floats(3 * nodes), moved: floats(3 * nodes), warm: floats(nodes),
    element: whole(elements * perElement), triangle: whole(3 * triangles), edge: whole(2 * edges)};
}

// A hexahedron in six tetrahedra around its diagonal from node 0 to node 6.
const parts = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]];

/** What a plane (axis, place in m) shows of the inside: triangles with place, displacement and temperature. */
export function cut(frame, axis, at) {
  const {place, moved, warm, element, perElement} = frame, out = [];
  const add = (a, b) => {
    const s = (at - place[3 * a + axis]) / (place[3 * b + axis] - place[3 * a + axis]);
    for (const field of [place, moved]) for (let c = 0; c < 3; c++) out.push(field[3 * a + c] + s * (field[3 * b + c] - field[3 * a + c]));
    out.push(warm[a] + s * (warm[b] - warm[a]));
  };
  const tetrahedron = (a, b, c, d) => {
    const below = [], above = [];
    for (const n of [a, b, c, d]) (place[3 * n + axis] < at ? below : above).push(n);
    if (below.length === 0 || above.length === 0) return;
    if (below.length === 2) {
      const [p, q] = below, [r, s] = above;
      add(p, r); add(p, s); add(q, s); add(p, r); add(q, s); add(q, r);
    } else {
      const [one] = below.length === 1 ? below : above;
      for (const other of below.length === 1 ? above : below) add(one, other);
    }
  };
  for (let e = 0; e < element.length; e += perElement) {
    const node = k => element[e + k];
    if (perElement === 4) tetrahedron(node(0), node(1), node(2), node(3));
    else if (perElement === 8) for (const [a, b, c, d] of parts) tetrahedron(node(a), node(b), node(c), node(d));
  }
  return new Float32Array(out);
}

const vertex = `attribute vec3 place, moved; attribute float warm; uniform mat4 view; uniform float scale; uniform vec4 keep;
varying float t; varying vec3 p; varying float side;
void main() { p = place + scale * moved; t = warm; side = keep.w - dot(keep.xyz, place); gl_Position = view * vec4(p, 1.0); }`;
// Bands of colour; light from the normal of the face, so that the form is seen.
const fragment = `#extension GL_OES_standard_derivatives : enable
precision mediump float; varying float t; varying vec3 p; varying float side; uniform vec2 range; uniform vec2 front; uniform float flat_; uniform vec4 line; uniform sampler2D bands;
void main() { if (side < 0.) discard; if (line.a > 0.) { gl_FragColor = line; return; }
  vec3 c = texture2D(bands, vec2((t - range.x) / (range.y - range.x), .5)).rgb;
  float w = fwidth(t); if (abs(t - front.x) < w || abs(t - front.y) < w) c = vec3(1.);
  float light = flat_ > .5 ? 1. : .8 + .2 * abs(normalize(cross(dFdx(p), dFdy(p))).z);
  gl_FragColor = vec4(c * light, 1.); }`;

function programOf(gl) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  return program;
}

/** The bands of colour of a report, cold to hot, as a texture. */
function bandTexture(gl, colours) {
  const bytes = new Uint8Array(colours.flatMap(c => [1, 3, 5].map(i => parseInt(c.slice(i, i + 2), 16))));
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, colours.length, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, bytes);
  for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.NEAREST], [gl.TEXTURE_MAG_FILTER, gl.NEAREST], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]])
    gl.texParameteri(gl.TEXTURE_2D, name, value);
}

/** Orthographic view: turned around the vertical by `yaw`, tilted by `pitch`, `size` metres high. Column by column. */
export function viewOf({yaw, pitch, size, centre}, aspect) {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  const right = [cy, sy, 0], up = [-sy * sp, cy * sp, cp], to = [sy * cp, -cy * cp, sp];
  const dot = v => v[0] * centre[0] + v[1] * centre[1] + v[2] * centre[2];
  const [a, b, d] = [2 / (size * aspect), 2 / size, -0.5 / size];
  return new Float32Array([right[0] * a, up[0] * b, to[0] * d, 0, right[1] * a, up[1] * b, to[1] * d, 0, right[2] * a, up[2] * b, to[2] * d, 0, -dot(right) * a, -dot(up) * b, -dot(to) * d, 1]);
}

/** Fills `box` with a viewer of the frames of a job. */
export async function frameViewer(box, signal, id) {
  const times = await get(`/frames/${id}`);
  if (times.length === 0) throw new Error('No frame is stored.');
  const canvas = h('canvas', {width: 900, height: 620, tabindex: 0, role: 'img'});
  const gl = canvas.getContext('webgl', {antialias: true, preserveDrawingBuffer: true});
  if (!gl || !gl.getExtension('OES_standard_derivatives') || !gl.getExtension('OES_element_index_uint')) throw new Error('This browser has no WebGL.');
  bandTexture(gl, await get('/colours/'));
  const program = programOf(gl), place = name => gl.getUniformLocation(program, name);
  const probe = h('p', {role: 'status', class: 'soft'}, 'Drag to turn, wheel or + and - to zoom, click for a value.');
  const slider = (name, attributes, act) => {
    const input = h('input', {type: 'range', oninput: () => act(Number(input.value)), ...attributes}), output = h('output');
    return {input, output, label: h('label', {}, name, output, input)};
  };
  const frames = new Map();
  const eye = {yaw: 2.4, pitch: 0.5, size: 1, centre: [0, 0, 0]};
  let frame = null, scale = 1, axis = -1, at = 1, buffers = null, capCount = 0, asked = 0;

  const buffer = (target, data) => { const b = gl.createBuffer(); gl.bindBuffer(target, b); gl.bufferData(target, data, gl.STATIC_DRAW); return b; };
  function upload() {
    for (const b of Object.values(buffers || {})) gl.deleteBuffer(b);
    buffers = {place: buffer(gl.ARRAY_BUFFER, frame.place), moved: buffer(gl.ARRAY_BUFFER, frame.moved), warm: buffer(gl.ARRAY_BUFFER, frame.warm),
      triangle: buffer(gl.ELEMENT_ARRAY_BUFFER, frame.triangle), edge: buffer(gl.ELEMENT_ARRAY_BUFFER, frame.edge), cap: gl.createBuffer()};
    cutNow();
  }
  function bounds() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    frame.place.forEach((v, i) => { low[i % 3] = Math.min(low[i % 3], v); high[i % 3] = Math.max(high[i % 3], v); });
    return {low, high};
  }
  const plane = () => { const {low, high} = bounds(); return low[axis] + at * (high[axis] - low[axis]); };
  function cutNow() {
    capCount = 0;
    if (axis < 0 || frame.dimension !== 3) return;
    const cap = cut(frame, axis, plane());
    gl.bindBuffer(gl.ARRAY_BUFFER, buffers.cap);
    gl.bufferData(gl.ARRAY_BUFFER, cap, gl.DYNAMIC_DRAW);
    capCount = cap.length / 7;
  }
  function attribute(name, b, size, stride = 0, offset = 0) {
    const where = gl.getAttribLocation(program, name);
    gl.bindBuffer(gl.ARRAY_BUFFER, b);
    gl.enableVertexAttribArray(where);
    gl.vertexAttribPointer(where, size, gl.FLOAT, false, stride, offset);
  }
  function draw() {
    asked = 0;
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(program);
    gl.uniformMatrix4fv(place('view'), false, viewOf(eye, canvas.width / canvas.height));
    gl.uniform1f(place('scale'), scale);
    gl.uniform2f(place('range'), 20, frame.liquidus || 660);
    gl.uniform2f(place('front'), frame.solidus, frame.liquidus);
    gl.uniform1f(place('flat_'), frame.dimension === 3 ? 0 : 1);
    const keep = [0, 0, 0, 1];
    if (axis >= 0 && frame.dimension === 3) { keep[axis] = 1; keep[3] = plane() + 1e-6; }
    gl.uniform4fv(place('keep'), keep);
    gl.uniform4f(place('line'), 0, 0, 0, 0);
    attribute('place', buffers.place, 3); attribute('moved', buffers.moved, 3); attribute('warm', buffers.warm, 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers.triangle);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    gl.drawElements(gl.TRIANGLES, frame.triangle.length, gl.UNSIGNED_INT, 0);
    gl.uniform4f(place('line'), 0.05, 0.07, 0.1, 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers.edge);
    gl.drawElements(gl.LINES, frame.edge.length, gl.UNSIGNED_INT, 0);
    if (capCount === 0) return;
    gl.uniform4f(place('line'), 0, 0, 0, 0);
    gl.uniform1f(place('flat_'), 1);
    attribute('place', buffers.cap, 3, 28, 0); attribute('moved', buffers.cap, 3, 28, 12); attribute('warm', buffers.cap, 1, 28, 24);
    gl.drawArrays(gl.TRIANGLES, 0, capCount);
  }
  const redraw = () => { if (!asked && frame) asked = requestAnimationFrame(draw); };

  async function show(number) {
    time.output.textContent = `${fixed(times[number - 1], 1)} s`;
    if (!frames.has(number)) frames.set(number, readFrame(await getBytes(`/frame/${id}?number=${number}`)));
    if (signal.aborted || Number(time.input.value) !== number) return;
    frame = frames.get(number);
    upload();
    canvas.setAttribute('aria-label', `Temperature of the slab at ${fixed(frame.time, 1)} s, ${fixed(1e3 * frame.length, 0)} mm cast`);
    redraw();
  }
  function wholeSlab() {
    const {low, high} = bounds();
    eye.centre = low.map((v, c) => (v + high[c]) / 2);
    eye.size = 1.25 * Math.max(high[2] - low[2], Math.hypot(high[0] - low[0], high[1] - low[1]) * (frame.dimension === 3 ? 0.9 : 0.72));
    if (frame.dimension !== 3) { eye.yaw = 0; eye.pitch = 0; }
  }

  /** The skin's node nearest to the pointer, of those on the near side. */
  function values(event) {
    const box = canvas.getBoundingClientRect(), m = viewOf(eye, canvas.width / canvas.height);
    const x = (event.clientX - box.left) / box.width * 2 - 1, y = 1 - (event.clientY - box.top) / box.height * 2;
    let best = -1, least = Infinity;
    for (const n of frame.triangle) {
      const p = [0, 1, 2].map(c => frame.place[3 * n + c] + scale * frame.moved[3 * n + c]);
      const at = r => m[r] * p[0] + m[r + 4] * p[1] + m[r + 8] * p[2] + m[r + 12];
      const off = Math.hypot(at(0) - x, at(1) - y) + 0.02 * at(2);
      if (off < least) { least = off; best = n; }
    }
    const of = field => [0, 1, 2].slice(0, 3).filter(c => frame.dimension === 3 || c !== 1).map(c => fixed(1e3 * field[3 * best + c], 1)).join(', ');
    probe.textContent = `At ${of(frame.place)} mm: ${fixed(frame.warm[best], 0)} °C, moved ${of(frame.moved)} mm`;
  }

  let from = null, dragged = false;
  canvas.addEventListener('pointerdown', event => { from = [event.clientX, event.clientY]; dragged = false; canvas.setPointerCapture(event.pointerId); });
  canvas.addEventListener('pointermove', event => {
    if (!from) return;
    const [dx, dy] = [event.clientX - from[0], event.clientY - from[1]];
    if (Math.hypot(dx, dy) < 3 && !dragged) return;
    dragged = true;
    turn(-0.008 * dx, 0.008 * dy);
    from = [event.clientX, event.clientY];
  });
  canvas.addEventListener('pointerup', event => { if (from && !dragged) values(event); from = null; });
  canvas.addEventListener('wheel', event => { event.preventDefault(); zoom(Math.exp(0.001 * event.deltaY)); }, {passive: false});
  canvas.addEventListener('keydown', event => {
    const keys = {ArrowLeft: () => turn(0.1, 0), ArrowRight: () => turn(-0.1, 0), ArrowUp: () => turn(0, -0.1), ArrowDown: () => turn(0, 0.1), '+': () => zoom(0.9), '-': () => zoom(1.1)};
    if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
  });
  function turn(yaw, pitch) {
    if (frame.dimension !== 3) return;
    eye.yaw += yaw;
    eye.pitch = Math.max(-1.5, Math.min(1.5, eye.pitch + pitch));
    redraw();
  }
  function zoom(factor) { eye.size *= factor; redraw(); }

  const time = slider('Time', {min: 1, max: times.length, step: 1, value: times.length}, number => show(number).catch(fault => { probe.textContent = fault.message; }));
  const bent = slider('Deformation', {min: 0, max: 20, step: 1, value: 1}, value => { scale = value; bent.output.textContent = `× ${value}`; redraw(); });
  bent.output.textContent = '× 1';
  const depth = slider('Cut', {min: 0, max: 1, step: 0.01, value: 1, disabled: true}, value => { at = value; depth.output.textContent = `${fixed(1e3 * plane(), 0)} mm`; cutNow(); redraw(); });
  const across = h('select', {'aria-label': 'Cut plane', onchange: () => { axis = Number(across.value); depth.input.disabled = axis < 0; at = axis < 0 ? 1 : 0.5; depth.input.value = at; cutNow(); redraw(); }},
    [['-1', 'whole'], ['0', 'across the width'], ['1', 'across the thickness'], ['2', 'at a height']].map(([value, text]) => h('option', {value}, text)));
  const bar = h('p', {class: 'soft'});
  replace(box, h('h2', {}, 'Slab'), canvas, h('div', {class: 'levers row'}, time.label, bent.label, h('div', {class: 'cuts'}, across, depth.label)), probe, bar);
  await show(times.length);
  if (signal.aborted) return;
  wholeSlab();
  bar.textContent = `Colours from 20 to ${fixed(frame.liquidus, 0)} °C (${ticks(20, frame.liquidus, 28).values.length} round values between); white lines: solidus ${fixed(frame.solidus, 0)} and liquidus ${fixed(frame.liquidus, 0)} °C.`;
  box.querySelector('.cuts').hidden = frame.dimension !== 3;
  redraw();
}
