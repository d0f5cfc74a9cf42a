// What the server concludes (judgement.proto): sentences, tables and charts, in the units of a plant.
import {chart} from './chart.js';
import {fixed, h, sheet} from './dom.js';

// Plant unit and factor from SI, as proto/values/plant_units.cpp has them.
const plantUnits = {
  1: ['%', 1e2],
  m: ['mm', 1e3],
  m2: ['dm²', 1e2],
  'm/s': ['mm/min', 60e3],
  'm2/s': ['l/min/m', 60e3],
  'm/s2': ['mm/min²', 3.6e6],
  'm2/s2': ['l/min²/m', 3.6e6],
  W: ['kW', 1e-3],
  'W/m': ['kW/m', 1e-3],
  J: ['MJ', 1e-6],
  'J/m': ['MJ/m', 1e-6],
  Pa: ['kPa', 1e-3],
  degC: ['°C', 1]
};
/** The plant unit of an SI unit, and the factor to it. */
export const plant = unit => plantUnits[unit] || [unit || '', 1];
const capital = text => text && text[0].toUpperCase() + text.slice(1);

function numberText(column, cell, value) {
  const factor = plant(column.unit || cell.unit)[1];
  const decimals = column.resolution > 0
    ? Math.max(0, Math.ceil(-Math.log10(factor * column.resolution) - 1e-9))
    : 0;
  return fixed(factor * value, decimals).replace(/^-(?=[0.]*$)/, '');
}

/** A value of a case without quotes, with six digits and speeds in mm/min. */
function shownValue(value) {
  const number = /\d+(?:\.\d+)?(?:e[-+]?\d+)?( m\/s(?!\w))?/g;
  return value.replaceAll('"', '').replace(number, (text, speed) => {
    const figure = Number((parseFloat(text) * (speed ? 60e3 : 1)).toPrecision(6));
    return `${figure}${speed ? ' mm/min' : ''}`;
  });
}

/** "12.3 ± 1.4", "35.5, -0.0 +3.9", a text, a code as words. */
export function cellText(column, cell = {}) {
  if (cell.text) return cell.text;
  if (cell.case_value) return shownValue(cell.case_value);
  const words = (cell.code || '').replaceAll('_', ' ');
  if (cell.value === undefined || cell.value === null) return words;

  const number = numberText(column, cell, cell.value);
  const unit = column.unit ? '' : plant(cell.unit)[0];
  const behind = unit && ` ${unit}`;
  if (cell.until !== undefined) return `${number} to ${numberText(column, cell, cell.until)}${behind}`;

  const sign = column.is_signed && !number.startsWith('-') ? '+' : '';
  const text = `${sign}${number}${behind}${words && ` ${words}`}`;
  if (cell.upper_error === undefined) return text;
  const lower = numberText(column, cell, cell.lower_error);
  const upper = numberText(column, cell, cell.upper_error);
  return lower === upper ? `${text} ± ${upper}` : `${text}, -${lower} +${upper}`;
}

const withUnit = (name, unit) => unit && plant(unit)[0] ? `${name}, ${plant(unit)[0]}` : name;

export function table({heading, note, columns, rows}) {
  const shown = columns.map((column, i) => ({column, i})).filter(({column}) => column.heading);
  const cellOf = ({cells}) => ({column, i}) => ({
    class: column.unit || column.resolution > 0 ? 'number' : null,
    content: cellText(column, cells[i])
  });

  const head = shown.map(({column}) => withUnit(column.heading, column.unit));
  const body = rows.map(row => shown.map(cellOf(row)));
  return [
    heading ? h('h3', {}, capital(heading)) : null,
    rows.length === 0 ? null : sheet(head, body),
    note ? h('p', {class: 'soft'}, note) : null
  ];
}

/** @param width  of the drawing; smaller ones have larger letters */
export function picture({heading, x, y, lines, region, beyond_x: beyond}, width = 900) {
  const fx = plant(x.unit)[1], fy = plant(y.unit)[1];
  const scaled = (values, factor) => values.map(v => (v === null ? NaN : factor * v));
  const bandOf = line => line.low.length ? {low: scaled(line.low, fy), high: scaled(line.high, fy)} : {};
  const drawn = lines.map((line, i) => ({
    name: line.name,
    x: scaled(line.x, fx),
    y: scaled(line.y, fy),
    colour: i,
    dots: line.is_dotted,
    ...bandOf(line)
  }));

  const wanted = region
    ? {low: fy * (region.low ?? -Infinity), high: fy * (region.high ?? Infinity), name: region.name}
    : null;
  return chart(drawn, {
    title: capital(heading),
    xLabel: withUnit(x.quantity, x.unit),
    yLabel: withUnit(y.quantity, y.unit),
    unit: plant(y.unit)[0],
    wanted,
    beyond: fx * (beyond ?? Infinity),
    width
  });
}

function shownPart({table: figures, chart: lines}) {
  if (figures) return table(figures);
  return [picture(lines), lines.note ? h('p', {class: 'soft'}, lines.note) : null];
}

/**
 * Sentences, then the parts that are worth their space on a page.
 * @param wanted  (part) whether it is shown here
 */
export function judgement({sentences, parts}, wanted = () => true) {
  const shown = parts.filter(part => part.place !== 'TERMINAL' && wanted(part));
  return [sentences.map(text => h('p', {class: 'answer'}, text)), shown.map(shownPart)].flat(2);
}
