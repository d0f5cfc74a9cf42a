// What the client wrote as HTML: tables, which are complete, and places where charts are drawn.
import {chart} from './chart.js';
import {h} from './dom.js';

const numbers = values => values && values.map(v => v ?? NaN);

/** @param width  of the drawing; smaller ones have larger letters */
export function picture({lines, wanted, beyond, ...labels}, width = 900) {
  const drawn = lines.map((line, i) => ({
    ...line, colour: i, y: numbers(line.y), low: numbers(line.low), high: numbers(line.high)
  }));
  return chart(drawn, {
    ...labels,
    wanted: wanted && {...wanted, low: wanted.low ?? -Infinity, high: wanted.high ?? Infinity},
    beyond: beyond ?? Infinity,
    width
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
