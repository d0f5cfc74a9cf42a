// The start of a case: the section through the middle of the wide face, to scale, with metal, mould,
// zones, water line and block, and the ramps of speed and water.
import {chart} from './chart.js';
import {h} from './dom.js';

// Sizes of the drawing; the metal level is at `level`.
const width = 640, level = 40, lowest = 380;
const axis = 20, face = 290, mould = 26, names = 334;  // symmetry plane, mould wall, labels

const lengthText = metres => `${Number((1e3 * metres).toPrecision(4))} mm`;
const rect = (kind, x, y, wide, high) => h('rect', {class: kind, x, y, width: wide, height: high});
const line = (kind, x1, y1, x2, y2) => h('line', {class: kind, x1, y1, x2, y2});
const centred = (x, y, text) => h('text', {x, y, 'text-anchor': 'middle'}, text);

/** Depths at the start, below the metal level [m], and the scale of the drawing. */
function startOf({section, cooling}) {
  const half = section.half_thickness_m?.value?.[0] ?? section.half_width_m;
  const water = cooling.water.from_m;
  const block = section.initial_depth_m ?? water - section.block_above_water_m;
  const foot = Math.max(water, block) + 0.12;  // of what is shown of the block
  const scale = Math.min((face - axis) / half, (lowest - level) / foot);
  return {half, water, block, foot, y: depth => level + scale * depth, x: face - scale * half};
}

/** Names beside the mould, from top to bottom without overlap. */
function labels(start, zones) {
  const wanted = [
    [level, 'metal level'],
    [start.y(start.water), `water line, ${lengthText(start.water)}`],
    [start.y(start.block), `block at the start, ${lengthText(start.block)}`],
    ...zones.map(zone => [
      start.y((zone.from_m + zone.to_m) / 2),
      `${zone.name}, ${lengthText(zone.from_m)} to ${lengthText(zone.to_m)}`
    ]),
  ].sort((a, b) => a[0] - b[0]);

  let free = 0;
  return wanted.map(([y, text]) => {
    const at = Math.max(y, free);
    free = at + 17;
    return [line('zero', face + mould + 2, y, names - 4, at), h('text', {x: names, y: at + 4}, text)];
  });
}

function sectionDrawing(given) {
  const start = startOf(given), {x, y} = start, zones = given.cooling.zone || [];
  const [foot, block, end] = [y(start.water), y(start.block), y(start.foot)];
  const middle = (x + face) / 2;
  const plane = given.section.kind === 'AXISYMMETRIC' ? 'axis' : 'symmetry plane';

  return h(
    'svg', {
      class: 'casting',
      viewBox: `0 0 ${width} ${end + 36}`,
      role: 'img',
      'aria-label': 'Section through the start of the casting'
    },
    rect('metal', x, level, face - x, block - level), rect('block', x, block, face - x - 3, end - block),
    rect('mould', face, level - 25, mould, foot - level + 25),
    zones.map(zone => line('border', face, y(zone.to_m), face + mould, y(zone.to_m))),
    // The jet leaves the foot of the mould, and the film runs down face and block.
    line('water', face + mould, foot - 6, face, foot), line('water', face + 1, foot, face + 1, end),
    line('dashed zero', x, level - 30, x, end + 8), line('line-1', x, level, face, level),
    centred(middle, (level + block) / 2 + 4, 'metal'), centred(middle, (block + end) / 2 + 4, 'bottom block'),
    centred(middle, end + 24, `${lengthText(start.half)} to the ${plane}`), labels(start, zones).flat());
}

/** A table of the schedule over the start. @param from, end  times at which it takes effect and ends [s] */
function ramp(name, unit, table, from, end) {
  if (!table?.value?.length) return null;
  const byLength = table.abscissa === 'CAST_LENGTH', at = table.at || [], values = table.value;
  const first = byLength ? 0 : from, x = [first, ...at.filter(v => v > first)];
  if (!byLength) x.push(Math.max(end, x.at(-1)));
  const valueOf = v => {
    const next = at.findIndex(a => a >= v);
    if (next <= 0) return next === 0 ? values[0] : values.at(-1);
    const share = (v - at[next - 1]) / (at[next] - at[next - 1]);
    return values[next - 1] + share * (values[next] - values[next - 1]);
  };
  const drawn = [{name, x: x.map(v => (byLength ? 1e3 * v : v)), y: x.map(v => 60e3 * valueOf(v))}];
  const xLabel = byLength ? 'cast length, mm' : 'time, s';
  return chart(drawn, {title: `${name}, ${unit}`, xLabel, yLabel: unit, unit, width});
}

/** @param given  a complete case (case.proto) */
export function castingDrawing(given) {
  const {schedule, cooling, time} = given;
  return h(
    'div', {class: 'pair'}, sectionDrawing(given),
    h('div', {}, ramp('casting speed', 'mm/min', schedule.casting_speed_m_per_s, 0, time.end_s),
      ramp('water', 'l/min/m', schedule.water_flow_m2_per_s, cooling.water.start_s, time.end_s)));
}
