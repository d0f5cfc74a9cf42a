// Pictures and data of a page as files.
import {h} from './dom.js';

/** Has the browser save a blob. */
export function saveBlob(name, blob) {
  const address = URL.createObjectURL(blob);
  h('a', {href: address, download: name}).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}

const quoted = value => (/[",\n]/.test(value) ? `"${value.replaceAll('"', '""')}"` : value);
const cell = value =>
  (typeof value === 'number' ? (Number.isFinite(value) ? String(value) : '') : quoted(value));

/** Saves rows as CSV. @param rows  [[number or text]], the first one with the headings */
export function saveCsv(name, rows) {
  saveBlob(
    name,
    new Blob([rows.map(row => row.map(cell).join(',')).join('\n'), '\n'], {type: 'text/csv'}));
}

export const savePng = (name, canvas) => canvas.toBlob(blob => saveBlob(name, blob), 'image/png');

export const fileName = text =>
  text.toLowerCase().replace(/[^\w.-]+/g, '-').replace(/^-|-$/g, '').slice(0, 80);

const drawn =
  ['fill', 'stroke', 'stroke-width', 'stroke-dasharray', 'opacity', 'font-size', 'font-family'];

/** An SVG of the page as a file of its own, with the colours that it has there. */
function textOfSvg(svg) {
  const copy = svg.cloneNode(true);
  const {width, height} = svg.viewBox.baseVal;
  // Outside of the page there is no style sheet: what it says becomes attributes.
  const originals = svg.querySelectorAll('*');
  copy.querySelectorAll('*').forEach((element, i) => {
    const style = getComputedStyle(originals[i]);
    for (const name of drawn) element.setAttribute(name, style.getPropertyValue(name));
  });
  copy.setAttribute('xmlns', 'http://www.w3.org/2000/svg');
  copy.setAttribute('width', width);
  copy.setAttribute('height', height);
  return new XMLSerializer().serializeToString(copy);
}

export const saveSvg = (name, svg) =>
  saveBlob(name, new Blob([textOfSvg(svg)], {type: 'image/svg+xml'}));

/** An SVG of the page as a canvas. */
export async function canvasOfSvg(svg) {
  const factor = 2, {width, height} = svg.viewBox.baseVal;
  const image = new Image();
  image.src = `data:image/svg+xml,${encodeURIComponent(textOfSvg(svg))}`;
  await image.decode();
  const canvas = h('canvas', {width: factor * width, height: factor * height}),
        context = canvas.getContext('2d');
  context.fillStyle = getComputedStyle(document.body).getPropertyValue('--card');
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.drawImage(image, 0, 0, canvas.width, canvas.height);
  return canvas;
}
