// The levers of the page what-if, and how a change of one reads.
// A factor is in %, everything else in its unit; 0 is the case as it is. `of` gives the table of a
// complete case, in `si`. `table`: the factor as a table in cast length, in place of that of the case.
export const levers = [
  {
    key: 'schedule.casting_speed.scale',
    name: 'Casting speed',
    unit: '%',
    low: -30,
    high: 30,
    step: 1,
    si: 'm/s',
    of: ({schedule}) => schedule.casting_speed_m_per_s
  },
  {
    key: 'schedule.water_flow.scale',
    name: 'Water',
    unit: '%',
    low: -40,
    high: 40,
    step: 1,
    si: 'm2/s',
    of: ({schedule}) => schedule.water_flow_m2_per_s
  },
  {
    key: 'schedule.casting_temperature.offset',
    name: 'Metal temperature',
    unit: 'K',
    low: -15,
    high: 30,
    step: 1,
    si: 'degC',
    of: ({schedule}) => schedule.casting_temperature_c
  },
  {
    key: 'cooling.water.temperature.offset',
    name: 'Water temperature',
    unit: 'K',
    low: -10,
    high: 15,
    step: 1,
    si: 'degC',
    of: ({cooling}) => cooling.water?.temperature_c
  },
  {
    key: 'cooling.water.critical_heat_flux_factor',
    name: 'Critical heat flux until 100 mm (gas)',
    unit: '%',
    low: -75,
    high: 0,
    step: 5,
    si: '',
    of: ({cooling}) => cooling.water?.critical_heat_flux_factor,
    table: factor => `[["0 mm", ${factor}], ["100 mm", ${factor}], ["150 mm", 1]]`
  },
  {
    key: 'cooling.bottom_block.temperature.offset',
    name: 'Block temperature',
    unit: 'K',
    low: -40,
    high: 100,
    step: 5,
    si: 'degC',
    of: ({cooling}) => cooling.bottom_block?.temperature_c
  },
  {
    key: 'schedule.filling.scale',
    name: 'Filling time',
    unit: '%',
    low: -40,
    high: 60,
    step: 5,
    si: 's',
    of: ({schedule}) => ({value: [schedule.filling_s]})
  },
  {
    key: 'schedule.hold.scale',
    name: 'Hold before the start',
    unit: '%',
    low: -60,
    high: 100,
    step: 5,
    si: 's',
    of: ({schedule}) => ({value: [schedule.hold_s]})
  },
];

/** What a lever is in a complete case: first and last value. @param plant  as of drawn.js */
export function givenOf({si, of}, complete, plant) {
  const {name, factor} = plant(si), values = of(complete)?.value ?? [];
  return values.length ? {values: [values[0], values.at(-1)].map(v => factor * v), unit: name} : null;
}

export const changeText = ({key, unit, table}, value) => {
  if (unit !== '%') return `${key}=${value} ${unit}`;
  const factor = (1 + value / 100).toFixed(2);
  return `${key}=${table ? table(factor) : factor}`;
};

/**
 * "+5 %", beside it what the lever is then: "+5 %, 42 to 63 mm/min".
 * @param given  {values: [first, last], unit} in the case as it is; null: not known
 */
export function leverText({unit}, value, given) {
  const change = `${value > 0 ? '+' : ''}${value} ${unit}`;
  if (!given) return change;
  const moved = given.values.map(v => unit === '%' ? v * (1 + value / 100) : v + value)
                  .map(v => `${Number(v.toPrecision(3))}`);
  return `${change}, ${[...new Set(moved)].join(' to ')} ${given.unit}`;
}
