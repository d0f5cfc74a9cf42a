// Curls as the page writes them, by the examples that text and Python keep to, too.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import test from 'node:test';

import {curlParts, curlText, findingText, fixed} from '../../../client/html/assets/dom.js';

test('curls are rounded as in the examples of all renderers', () => {
  const {curls} = JSON.parse(readFileSync(new URL('../../support/figures.json', import.meta.url)));
  assert.ok(curls.length > 10);
  for (const {curl_m: curl, lower_m: lower, upper_m: upper, text} of curls)
    assert.equal(curlText(curl, lower, upper), text);
});

test('large letters show the error apart from the curl', () => {
  assert.deepEqual(curlParts(52.97e-3, 2.1e-3, 4.2e-3), {curl: '53.0', error: '-2.1 +4.2'});
  assert.deepEqual(curlParts(5.25e-3, 0.21e-3, 0.21e-3), {curl: '5.25', error: '± 0.21'});
  assert.deepEqual(curlParts(2e-3, NaN, NaN), {curl: '2.00', error: ''});
});

test('zero has no sign', () => {
  assert.equal(fixed(-0.04, 1), '0.0');
  assert.equal(fixed(-0.06, 1), '-0.1');
});

test('a finding that became worse begins with the worst', () => {
  const raised = {message: 'The shell is thin.', time_s: 15, value: 0.0044, unit: 'm'};
  assert.equal(findingText(raised), 'The shell is thin.');
  assert.equal(findingText({...raised, worst: {time_s: 15, value: 0.0044}}), 'The shell is thin.');
  assert.equal(findingText({...raised, worst: {time_s: 190}}),
    'At worst 0 mm, at 190.00 s. The shell is thin.', 'zero is not written');
  assert.equal(findingText({code: 'sump_too_deep'}), 'sump_too_deep');
});
