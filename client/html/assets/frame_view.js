// How a frame is drawn: the eye, the shaders, the colour bar.
import {fitted, ticks} from './chart.js';
import {fixed, h} from './dom.js';

/**
 * Directions to the right, upwards and to the eye, turned around the vertical by `yaw` and tilted
 * by `pitch`.
 */
function axesOf({yaw, pitch}) {
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  return {right: [cy, sy, 0], up: [-sy * sp, cy * sp, cp], to: [sy * cp, -cy * cp, sp]};
}
/** Whether the eye looks at the cut across an axis: what lies beyond it, at higher places, is left out. */
export const seesCut = (eye, axis) => axesOf(eye).to[axis] > 0.05;
export const isBelow = eye => axesOf(eye).to[2] < -0.05;
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** Orthographic view, `size` metres high, as a matrix column by column. */
export function viewOf(eye, aspect) {
  const {right, up, to} = axesOf(eye), {size, centre} = eye;
  const [a, b, d] = [2 / (size * aspect), 2 / size, -0.5 / size];
  const column = c => [right[c] * a, up[c] * b, to[c] * d, 0];
  return new Float32Array([
    ...column(0), ...column(1), ...column(2), -dot(right, centre) * a, -dot(up, centre) * b,
    -dot(to, centre) * d, 1
  ]);
}

/**
 * Moves the eye so that a box of the slab fills the canvas, which becomes lower for a low box.
 * @param low, high  corners [m]
 */
export function fit(eye, low, high, canvas) {
  const {right, up} = axesOf(eye), margin = 1.08, lowest = 280, highest = 620;
  const extent = direction =>
    direction.reduce((sum, v, c) => sum + Math.abs(v) * (high[c] - low[c]), 0);
  const [width, height] = [extent(right), Math.max(extent(up), 1e-3)];

  const wanted = Math.round(canvas.width * height / Math.max(width, 1e-3));
  canvas.height = Math.max(lowest, Math.min(highest, wanted));
  eye.centre = low.map((v, c) => (v + high[c]) / 2);
  eye.size = margin * Math.max(height, width * canvas.height / canvas.width);
}

/** The bands of colour from low to high: cold blue over violet to hot yellow, in even lightness. */
export const colours = (() => {
  const stops = [
    [43, 58, 125], [73, 97, 184], [143, 92, 177], [214, 89, 120], [243, 142, 79], [252, 216, 106]
  ];
  const bands = 28, hex = v => Math.round(v).toString(16).padStart(2, '0');
  return Array.from({length: bands}, (_, band) => {
    const place = (band + 0.5) / bands * (stops.length - 1), from = Math.floor(place);
    const mixed = stops[from].map((v, c) => v + (place - from) * (stops[from + 1][c] - v));
    return `#${mixed.map(hex).join('')}`;
  });
})();

const quarter = Math.PI / 2;
/** Views by name; the wide face looks along y, the narrow one along x. */
export const views = {
  'From the corner': {yaw: 2.4, pitch: 0.5},
  'Wide face': {yaw: Math.PI, pitch: 0},
  'Narrow face': {yaw: quarter, pitch: 0},
  'Middle plane': {yaw: 0, pitch: 0},
  'From below': {yaw: 2.4, pitch: -0.6},
  'From above': {yaw: Math.PI, pitch: quarter},
  'Butt': {yaw: 0, pitch: -quarter},
};
/** The view that looks straight at a cut across an axis. */
export const viewOfCut =
  axis => [views['Narrow face'], views['Wide face'], views['From above']][axis];

// ---- WebGL

const vertex =
  `attribute vec3 place, moved; attribute float value;
uniform mat4 view; uniform float scale, most; uniform vec4 keep;
varying float t; varying vec3 p; varying float side;
void main() {
  p = place + scale * moved; t = value; side = min(keep.w - dot(keep.xyz, place), most - t);
  gl_Position = view * vec4(p, 1.0);
}`;
// Bands of colour, grey without a value; light from the normal of the face, so that the form is
// seen.
const fragment = `#extension GL_OES_standard_derivatives : enable
precision highp float; varying float t; varying vec3 p; varying float side;
uniform vec2 front; uniform float flat_; uniform vec4 line; uniform vec2 contour; uniform sampler2D bands;
void main() {
  if (side < 0.) discard;
  if (line.a > 0.) { gl_FragColor = line; return; }
  vec3 c = texture2D(bands, vec2(clamp(t, 0., .9999), .5)).rgb;
  float w = fwidth(t);
  float from_line = abs(fract((t - contour.x) / contour.y + .5) - .5) * contour.y;
  if (from_line < .5 * w && t > .002) c = mix(c, vec3(1.), .45);
  if (abs(t - front.x) < w || abs(t - front.y) < w) c = vec3(1.);
  if (t < -10.) c = vec3(.72);
  float light = flat_ > .5 ? 1. : .8 + .2 * abs(normalize(cross(dFdx(p), dFdy(p))).z);
  gl_FragColor = vec4(c * light, 1.);
}`;
const without = -1e4;  // stands for a value that there is not

function programOf(gl) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
      throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  return program;
}

function setBands(gl) {
  const bytes =
    new Uint8Array(colours.flatMap(c => [1, 3, 5].map(i => parseInt(c.slice(i, i + 2), 16))));
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, colours.length, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, bytes);
  for (const name of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
    gl.texParameteri(gl.TEXTURE_2D, name, gl.NEAREST);
  for (const name of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
    gl.texParameteri(gl.TEXTURE_2D, name, gl.CLAMP_TO_EDGE);
}

/** Draws a frame, and a cut through it, on a canvas. Throws where the browser has no WebGL. */
export class Painter {
  constructor(canvas) {
    this.canvas = canvas;
    const gl = this.gl = canvas.getContext('webgl', {antialias: true, preserveDrawingBuffer: true});
    if (
      !gl || !gl.getExtension('OES_standard_derivatives') ||
      !gl.getExtension('OES_element_index_uint'))
      throw new Error('This browser has no WebGL.');
    setBands(gl);
    this.program = programOf(gl);
    this.buffers = {};
    this.capCount = 0;
  }

  release() { this.gl.getExtension('WEBGL_lose_context')?.loseContext(); }

  /** @param values  on the nodes @param range  of the colours, in the unit of the values */
  setFrame(frame, values, [low, high]) {
    const {gl} = this;
    for (const buffer of Object.values(this.buffers)) gl.deleteBuffer(buffer);
    const filled = (target, data) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(target, buffer);
      gl.bufferData(target, data, gl.STATIC_DRAW);
      return buffer;
    };

    this.frame = frame;
    this.scaled = values.map(v => (Number.isFinite(v) ? (v - low) / (high - low) : without));
    this.buffers = {
      place: filled(gl.ARRAY_BUFFER, frame.place),
      moved: filled(gl.ARRAY_BUFFER, frame.moved),
      value: filled(gl.ARRAY_BUFFER, this.scaled),
      triangle: filled(gl.ELEMENT_ARRAY_BUFFER, frame.triangle),
      edge: filled(gl.ELEMENT_ARRAY_BUFFER, frame.edge),
      cap: gl.createBuffer()
    };
  }

  /** @param cap  of cut(), with scaled values; empty for none */
  setCap(cap) {
    const {gl} = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers.cap);
    gl.bufferData(gl.ARRAY_BUFFER, cap, gl.DYNAMIC_DRAW);
    this.capCount = cap.length / 7;
  }

  /**
   * @param keep  [a, b, c, d]: the half space ax + by + cz <= d is shown @param most  the largest value
   *   that is shown, scaled @param fronts  values of white lines, scaled
   * @param contours  evenly spaced values of thin lines, two or more, scaled
   */
  draw({eye, scale, keep, most = Infinity, fronts, contours}) {
    const {gl, program, canvas, frame, buffers} = this;
    const uniform = name => gl.getUniformLocation(program, name);
    const attribute = (name, buffer, size, stride = 0, offset = 0) => {
      const where = gl.getAttribLocation(program, name);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.enableVertexAttribArray(where);
      gl.vertexAttribPointer(where, size, gl.FLOAT, false, stride, offset);
    };

    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(program);
    gl.uniformMatrix4fv(uniform('view'), false, viewOf(eye, canvas.width / canvas.height));
    gl.uniform1f(uniform('scale'), scale);
    gl.uniform2f(uniform('front'), ...fronts);
    gl.uniform2f(uniform('contour'), contours[0], contours[1] - contours[0]);
    gl.uniform4fv(uniform('keep'), keep);
    gl.uniform1f(uniform('most'), Math.min(most + 1e-3, 1e9));

    // The skin, then its edges in front of it.
    gl.uniform1f(uniform('flat_'), frame.dimension === 3 ? 0 : 1);
    gl.uniform4f(uniform('line'), 0, 0, 0, 0);
    attribute('place', buffers.place, 3);
    attribute('moved', buffers.moved, 3);
    attribute('value', buffers.value, 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers.triangle);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.polygonOffset(1, 1);
    gl.drawElements(gl.TRIANGLES, frame.triangle.length, gl.UNSIGNED_INT, 0);
    gl.uniform4f(uniform('line'), 0.05, 0.07, 0.1, 1);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers.edge);
    gl.drawElements(gl.LINES, frame.edge.length, gl.UNSIGNED_INT, 0);
    if (scale > 0) {  // as it was before it moved
      gl.uniform1f(uniform('scale'), 0);
      gl.uniform4f(uniform('line'), 0.55, 0.6, 0.66, 1);
      gl.drawElements(gl.LINES, frame.edge.length, gl.UNSIGNED_INT, 0);
      gl.uniform1f(uniform('scale'), scale);
    }

    if (this.capCount === 0) return;
    gl.uniform4f(uniform('line'), 0, 0, 0, 0);
    gl.uniform1f(uniform('flat_'), most < Infinity ? 0 : 1);  // a surface shows its form
    attribute('place', buffers.cap, 3, 28, 0);
    attribute('moved', buffers.cap, 3, 28, 12);
    attribute('value', buffers.cap, 1, 28, 24);
    gl.drawArrays(gl.TRIANGLES, 0, this.capCount);
  }
}

// ---- Colour bar

/**
 * A number for people: as many digits as tell the ticks apart, exponents where it is tiny or huge.
 */
export function numberText(value, span) {
  if (!Number.isFinite(value)) return '–';
  if (value !== 0 && (span < 1e-3 || span >= 1e6)) return value.toExponential(1);
  return fixed(value, Math.max(0, Math.min(6, Math.ceil(1 - Math.log10(span || 1)))));
}

/** Length of a bar for scale, up to a third of what is seen. @param across  width of the canvas [m] */
export const rulerLength = across => ticks(0, across / 3, 2).values.at(-1);

/** The colours from low to high with round values below, as SVG. */
export const colourBar = (title, unit, range) => fitted(width => drawnBar(title, unit, range, width));

function drawnBar(title, unit, [low, high], width) {
  const left = 10, inner = width - 2 * left, span = high - low;
  const at = value => left + (value - low) / span * inner;
  const step = inner / colours.length;
  const label = unit ? `${title}, ${unit}` : title;

  const band = (fill, i) =>
    h('rect', {x: left + i * step, y: 24, width: step + 0.5, height: 16, fill});
  // The outermost texts stay inside the picture.
  const anchor = value => {
    if (value < low + 0.03 * span) return 'start';
    return value > high - 0.03 * span ? 'end' : 'middle';
  };
  const tick = value => [
    h('line', {class: 'zero', x1: at(value), x2: at(value), y1: 40, y2: 46}),
    h('text', {x: at(value), y: 66, 'text-anchor': anchor(value)}, numberText(value, span)),
  ];

  const text = `${label}: colours from ${numberText(low, span)} to ${numberText(high, span)}`;
  return h(
    'svg', {class: 'colours', viewBox: `0 0 ${width} 72`, role: 'img', 'aria-label': text},
    h('text', {x: left, y: 18, class: 'name'}, label), colours.map(band),
    ticks(low, high, width < 500 ? 4 : 6).values.flatMap(tick));
}
