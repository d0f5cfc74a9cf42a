// The start of a case: the section through the middle of the wide face, to scale, with metal, mould,
// zones, water line and block with its bowl and holes, and the ramps of speed and water.
import {fitted} from './chart.js';
import {h} from './dom.js';
import {picture} from './drawn.js';

// Sizes of the drawing; the metal level is at `level`.
const width = 640, level = 40, lowest = 380;
const axis = 20, face = 290, mould = 26, names = 334;  // symmetry plane, mould wall, labels

const lengthText = metres => `${Number((1e3 * metres).toPrecision(4))} mm`;
const rect = (kind, x, y, wide, high) => h('rect', {class: kind, x, y, width: wide, height: high});
const line = (kind, x1, y1, x2, y2) => h('line', {class: kind, x1, y1, x2, y2});
const centred = (x, y, text) => h('text', {x, y, 'text-anchor': 'middle'}, text);

/**
 * Depth of a bowl below the lip [m], as in core/mesh/section_spec.hpp.
 * @param inward  distance from the edge of the block [m]
 */
function bowlDepth(bowl, inward) {
  if (!bowl) return 0;
  const share = Math.max(0, Math.min(1, (inward - bowl.lip_m) / bowl.wall_m));
  return 0.5 * bowl.depth_m * (1 - Math.cos(Math.PI * share));
}

/** Depths at the start, below the metal level [m], and the scale of the drawing. */
function startOf({section, cooling}) {
  const half = section.half_thickness_m?.value?.[0] ?? section.half_width_m;
  const water = cooling.water.from_m, bowl = cooling.bottom_block.bowl;
  const block = section.initial_depth_m ?? water - section.block_above_water_m;  // its lip
  const foot = Math.max(water, block + bowlDepth(bowl, half)) + 0.12;  // of what is shown of the block
  const scale = Math.min((face - axis) / half, (lowest - level) / foot);
  return {half, water, block, foot, bowl, scale, y: depth => level + scale * depth, x: face - scale * half};
}

/** The surface of the block as points of the drawing, from the plane of symmetry to the edge. */
function blockSurface({half, block, bowl, scale, y}) {
  const points = [], parts = bowl ? 60 : 1;
  for (let i = 0; i <= parts; i++) {
    const inward = half * (1 - i / parts);
    points.push([face - scale * inward, y(block + bowlDepth(bowl, inward))]);
  }
  return points;
}

/** The holes through the block, seen along the wide face; dashed: beside the section. */
function holesOf(start, holes) {
  const {half, block, bowl, scale, y} = start;
  return holes.map(({x_m: x, y_m: across, diameter_m: diameter}) => {
    const left = Math.max(0, across - diameter / 2), right = across + diameter / 2;
    const top = y(block + bowlDepth(bowl, half - across));
    const kind = x < diameter / 2 ? 'hole' : 'hole dashed';
    return rect(kind, start.x + scale * left, top, scale * (right - left), y(start.foot) - top);
  });
}

const corners = points => points.map(point => point.map(v => v.toFixed(1)).join()).join(' ');

/** Names beside the mould, from top to bottom without overlap. @param apart  least distance of two */
function labels(start, zones, holes, apart) {
  const {bowl} = start, widths = [...new Set(holes.map(hole => lengthText(hole.diameter_m)))];
  const wanted = [
    [level, 'metal level'],
    [start.y(start.water), `water line, ${lengthText(start.water)}`],
    [start.y(start.block), `block at the start, ${lengthText(start.block)}`],
    ...(bowl ? [[start.y(start.block + bowl.depth_m), `bowl, ${lengthText(bowl.depth_m)} deep`]] : []),
    ...(holes.length ? [[start.y(start.foot) - 8, `drain holes of ${widths.join(' and ')}`]] : []),
    ...zones.map(zone => [
      start.y((zone.from_m + zone.to_m) / 2),
      `${zone.name}, ${lengthText(zone.from_m)} to ${lengthText(zone.to_m)}`
    ]),
  ].sort((a, b) => a[0] - b[0]);

  let free = 0;
  return wanted.map(([y, text]) => {
    const at = Math.max(y, free);
    free = at + apart;
    return [line('zero', face + mould + 2, y, names - 4, at), h('text', {x: names, y: at + 4}, text)];
  });
}

/** @param isNarrow  the page is narrower than the drawing: its letters are larger, and take more room */
function sectionDrawing(given, isNarrow) {
  const start = startOf(given), {x, y} = start, zones = given.cooling.zone || [];
  const holes = given.cooling.bottom_block.drain_hole || [], surface = blockSurface(start);
  const blockTop = surface.map(([px, py]) => [Math.min(px, face - 3), py]);  // a gap to the mould
  const [foot, block, end] = [y(start.water), y(start.block), y(start.foot)];
  const middle = (x + face) / 2;
  const plane = given.section.kind === 'AXISYMMETRIC' ? 'axis' : 'symmetry plane';

  return h(
    'svg', {
      class: 'casting',
      viewBox: `0 0 ${isNarrow ? width + 60 : width} ${end + 36}`,
      role: 'img',
      'aria-label': 'Section through the start of the casting'
    },
    h('polyline', {class: 'metal', points: corners([[x, level], ...surface, [face, level]])}),
    h('polyline', {class: 'block', points: corners([[x, end], ...blockTop, [face - 3, end]])}),
    holesOf(start, holes),
    rect('mould', face, level - 25, mould, foot - level + 25),
    zones.map(zone => line('border', face, y(zone.to_m), face + mould, y(zone.to_m))),
    // The jet leaves the foot of the mould, and the film runs down face and block.
    line('water', face + mould, foot - 6, face, foot), line('water', face + 1, foot, face + 1, end),
    line('dashed zero', x, level - 30, x, end + 8), line('line-1', x, level, face, level),
    centred(middle, (level + block) / 2 + 4, 'metal'),
    centred(middle, (surface[0][1] + end) / 2 + 4, 'bottom block'),
    h('text', {x, y: end + 24}, `${lengthText(start.half)} to the ${plane}`),
    labels(start, zones, holes, isNarrow ? 24 : 17).flat());
}

/** @param case  a complete case (case.proto) @param charts  its speed and water (judgement.proto) */
export function castingDrawing({case: given, charts}) {
  return h(
    'div', {class: 'pair'}, fitted(across => sectionDrawing(given, across < width), width),
    h('div', {}, charts.map(chart => picture(chart, width))));
}
