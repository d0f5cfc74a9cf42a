// Charts of the contract, and what the client wrote as HTML: tables, which are complete, and places
// where charts are drawn.
import {chart} from './chart.js';
import {h} from './dom.js';
import {plantUnits} from './plant_units.js';

/** The unit in which a plant reads figures: {name, factor}. @param si  their unit */
export const plant = si => plantUnits[si] ?? {name: si, factor: 1};

const label = ({quantity, unit}) => [quantity, plant(unit).name].filter((text, i) => !i || text).join(', ');
// JSON has no NaN: it is a text, or null.
const scaled = (values, factor) =>
  values?.length ? values.map(v => factor * (v ?? NaN)) : undefined;

/**
 * @param width  of the drawing; smaller ones have larger letters
 * @return a Chart of the contract, drawn in the units of a plant
 */
export function picture({heading, x, y, lines, region, beyond_x: beyond}, width = 900) {
  const across = plant(x.unit).factor, {factor, name: unit} = plant(y.unit);
  const drawn = lines.map((line, i) => ({
    name: line.name, colour: i, dots: line.is_dotted, x: scaled(line.x, across) ?? [],
    y: scaled(line.y, factor) ?? [], low: scaled(line.low, factor), high: scaled(line.high, factor)
  }));
  return chart(drawn, {
    title: heading.charAt(0).toUpperCase() + heading.slice(1), xLabel: label(x), yLabel: label(y),
    unit, width, beyond: across * (beyond ?? Infinity),
    wanted: region && {
      name: region.name, low: factor * (region.low ?? -Infinity),
      high: factor * (region.high ?? Infinity)
    }
  });
}

/**
 * Sentences, then the parts of a judgement as a report has them.
 * @param wanted  (key) whether the part is shown here
 */
export function judgement({sentences, parts}, wanted = () => true) {
  const box = h('div');
  box.innerHTML = parts.filter(({key}) => wanted(key)).map(({html}) => html).join('');
  for (const place of box.querySelectorAll('.drawn'))
    place.replaceChildren(picture(JSON.parse(place.textContent)));
  return [...sentences.map(text => h('p', {class: 'answer'}, text)), ...box.children];
}
