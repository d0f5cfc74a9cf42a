// The levers of the page what-if, and how a change of one reads.
// A factor is in %, everything else in its unit; 0 is the case as it is. `table`: the factor as a
// table in cast length, in place of that of the case.
export const levers = [
  {
    key: 'schedule.casting_speed.scale',
    name: 'Casting speed',
    unit: '%',
    low: -30,
    high: 30,
    step: 1
  },
  {key: 'schedule.water_flow.scale', name: 'Water', unit: '%', low: -40, high: 40, step: 1},
  {
    key: 'schedule.casting_temperature.offset',
    name: 'Metal temperature',
    unit: 'K',
    low: -15,
    high: 30,
    step: 1
  },
  {
    key: 'cooling.water.temperature.offset',
    name: 'Water temperature',
    unit: 'K',
    low: -10,
    high: 15,
    step: 1
  },
  {
    key: 'cooling.water.critical_heat_flux_factor',
    name: 'Critical heat flux until 100 mm (gas)',
    unit: '%',
    low: -75,
    high: 0,
    step: 5,
    table: factor => `[["0 mm", ${factor}], ["100 mm", ${factor}], ["150 mm", 1]]`
  },
  {
    key: 'cooling.bottom_block.temperature.offset',
    name: 'Block temperature',
    unit: 'K',
    low: -40,
    high: 100,
    step: 5
  },
  {key: 'schedule.filling.scale', name: 'Filling time', unit: '%', low: -40, high: 60, step: 5},
  {
    key: 'schedule.hold.scale',
    name: 'Hold before the start',
    unit: '%',
    low: -60,
    high: 100,
    step: 5
  },
];
export const changeText = ({key, unit, table}, value) => {
  if (unit !== '%') return `${key}=${value} ${unit}`;
  const factor = (1 + value / 100).toFixed(2);
  return `${key}=${table ? table(factor) : factor}`;
};

/**
 * "+5 %", beside it what the lever is then: "+5 %, 42 to 63 mm/min".
 * @param given  {values: [first, last], unit} in the case as it is; undefined: not known
 */
export function leverText({unit}, value, given) {
  const change = `${value > 0 ? '+' : ''}${value} ${unit}`;
  if (!given) return change;
  const moved = given.values.map(v => unit === '%' ? v * (1 + value / 100) : v + value)
                  .map(v => `${Number(v.toPrecision(3))}`);
  return `${change}, ${[...new Set(moved)].join(' to ')} ${given.unit}`;
}
