// How a lever of the page what-if reads, and what it changes.
import assert from 'node:assert/strict';
import test from 'node:test';

import {changeText, levers, leverText} from '../../../client/web/assets/levers.js';

const [speed] = levers, metal = levers.find(lever => lever.unit === 'K');

test('a change has beside it what the lever is then', () => {
  const given = {values: [40, 60], unit: 'mm/min'};
  assert.equal(leverText(speed, 5, given), '+5 %, 42 to 63 mm/min');
  assert.equal(leverText(speed, 0, given), '0 %, 40 to 60 mm/min');
  assert.equal(leverText(speed, -10, {values: [40, 40], unit: 'mm/min'}), '-10 %, 36 mm/min');
  assert.equal(leverText(metal, 15, {values: [680, 680], unit: '°C'}), '+15 K, 695 °C');
  assert.equal(leverText(speed, 5), '+5 %', 'before the case is known');
});

test('a change is that of a case file', () => {
  assert.equal(changeText(speed, 5), 'schedule.casting_speed.scale=1.05');
  assert.equal(changeText(metal, -3), 'schedule.casting_temperature.offset=-3 K');
  const gas = levers.find(lever => lever.table);
  assert.equal(
    changeText(gas, -50),
    'cooling.water.critical_heat_flux_factor=[["0 mm", 0.50], ["100 mm", 0.50], ["150 mm", 1]]');
});
