// Draws what a page has as data: charts, the slab, the start of a casting. Figures, tables and
// findings stand in the page as text.
import {castingDrawing} from './casting.js';
import {h, replace} from './dom.js';
import {picture} from './drawn.js';
import {shown} from './frame_data.js';
import {frameViewer} from './frame.js';
import {colourBar} from './frame_view.js';

const chartWidth = 640;  // of the drawing: cards of a report are narrower than those of the dashboard

/** Bytes that were packed by gzip and base64. */
function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
  const plain = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(plain).arrayBuffer();
}

/** The frames in the page, for the viewer. Only the last one has all fields. */
const framesIn = ({times, fields, frames, values, beyond_s: beyond}) => ({
  look: async () => ({times, fields, beyond}),
  frame: number => unpacked(frames[number - 1]),
  field: async (number, name) => {
    if (number < frames.length) throw new Error('The last frame alone has this field in a report.');
    return unpacked(values[name]);
  },
});

async function drawSlab(box, data) {
  const viewer = await frameViewer(box, new AbortController().signal, framesIn(data), document.title);
  if (!viewer.is3d) return;

  // Paper has no mouse: three views in place of the one that can be turned.
  const views = h('div', {class: 'views'});
  for (const name of ['From the corner', 'From below', 'Middle plane']) {
    const canvas = h('canvas');
    await viewer.copy(canvas, name);
    views.append(h('div', {}, h('h3', {}, name), canvas));
  }
  box.append(views);

  const map = document.querySelector('.gap-map'), gap = data.fields.find(f => f.name === 'gap_m');
  if (!map || !gap) return;
  const canvas = h('canvas', {role: 'img', 'aria-label': 'Gap under the butt, seen from below'});
  const range = await viewer.copy(canvas, 'Butt', gap), {title, unit} = shown(gap);
  replace(map, canvas, colourBar(title, unit, range));
}

const drawings = {
  chart: (box, data) => box.append(picture(data, chartWidth)),
  casting: (box, data) => box.append(castingDrawing(data)),
  slab: drawSlab,
};

for (const box of document.querySelectorAll('.drawn')) {
  try {
    await drawings[box.dataset.kind](box, JSON.parse(box.querySelector('script').textContent));
  } catch (fault) {
    box.append(h('p', {class: 'soft', role: 'alert'}, fault.message));
  }
}
document.body.classList.add('complete');
