// The steps of a run in the page: each once, also where a run is resumed.
import assert from 'node:assert/strict';
import test from 'node:test';

import {addStep, curlLines, judgedMonitor, lastMonitors, lengthsDiffer} from '../../../client/web/assets/history.js';

const step = (number, ...monitors) => ({step: number, time_s: 0.5 * number, monitors});
const corner = (curl, error) => ({
  name: 'corner', curl_m: curl, curl_lower_error_m: error, curl_upper_error_m: error && 2 * error
});

function historyOf(...numbers) {
  const steps = [];
  for (const number of numbers) addStep(steps, step(number, corner(1e-3 * number)));
  return steps;
}

test('a step reported again takes back itself and all later ones', () => {
  assert.deepEqual(historyOf(1, 2, 3, 4, 2, 3).map(({step: number}) => number), [1, 2, 3]);
  assert.deepEqual(historyOf(1, 2, 3, 1).map(({step: number}) => number), [1]);
});

test('curls are in millimetres, unknown where a monitor is not reported', () => {
  const steps = [step(1), ...historyOf(2, 3)];
  const [line] = curlLines(steps, ' changed');
  assert.equal(line.name, 'corner changed');
  assert.deepEqual(line.x, [0.5, 1, 1.5]);
  assert.deepEqual(line.y, [NaN, 2, 3]);
  assert.equal(line.low, undefined, 'no error is known');
});

test('a curl has its band where the errors are known', () => {
  const [line] = curlLines([step(1, corner(4e-3, 1e-3))]);
  assert.deepEqual([line.low, line.high], [[3], [6]]);
});

test('the last figures of every monitor', () => {
  const steps = [...historyOf(1), step(2, {name: 'centre', curl_m: 0})];
  assert.deepEqual(lastMonitors(steps), [{name: 'corner'}, {name: 'centre', curl_m: 0}]);
});

test('a run that failed or left validity has no curl as of a good one', () => {
  const judged = {name: 'corner', curl_m: 2e-3, judged: true};
  const job = {state: 'RUNNING', last_step: {monitors: [{name: 'centre'}, judged]}};
  assert.equal(judgedMonitor(job), judged);
  assert.equal(judgedMonitor({state: 'QUEUED'}), undefined);
  assert.equal(judgedMonitor({...job, state: 'FAILED'}), undefined);
  assert.equal(judgedMonitor({...job, state: 'SUCCEEDED', validity_loss: {}}), undefined);
});

test('histories of two speeds are drawn against the cast length', () => {
  const run = speed => [1, 2, 3].map(n => ({...step(n, corner(1e-3)), cast_length_m: speed * n}));
  assert.equal(lengthsDiffer(run(1e-3), run(1e-3)), false);
  assert.equal(lengthsDiffer(run(1e-3), run(1e-3).slice(0, 1)), false, 'while it is computed');
  assert.equal(lengthsDiffer(run(1e-3), run(0.7e-3)), true);
  assert.deepEqual(curlLines(run(1e-3), '', true)[0].x, [1, 2, 3]);
});
