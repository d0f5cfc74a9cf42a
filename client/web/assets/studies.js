// Studies, and of a sweep the response surface: a slider for each key.
import {call, callDrawn, repeat} from './api.js';
import {beginStudy, caseNames, readCase} from './cases.js';
import {chart} from './chart.js';
import {ago, curlText, h, replace, sheet, shortId, stateText} from './dom.js';
import {judgement} from './drawn.js';

const kinds = {
  sweep: 'sweep', refinement: 'refinement', mould: 'mould design', recipe: 'recipe', remedy: 'remedy'
};
const purposes = {UNCERTAINTY: 'uncertainty', SENSITIVITY: 'sensitivity', CALIBRATION: 'calibration'};
export const kindOf = study => purposes[study.sweep?.purpose]
  || kinds[Object.keys(kinds).find(kind => study[kind])] || 'study';
export const nameOf = study => study.title || `${kindOf(study)} ${shortId(study.id)}`;

/** "9 of 10 runs succeeded": a study whose runs have ended has answered, although some failed. */
export function answerState(study) {
  const ended = study.state !== 'STUDY_RUNNING', succeeded = study.succeeded || 0;
  const runs = `${succeeded} of ${study.runs} runs succeeded`;
  if (!ended) return `running, ${runs}`;
  if (study.state === 'STUDY_CANCELLED') return `cancelled, ${runs}`;
  return succeeded > 0 ? `answered, ${runs}` : `no answer, ${runs}`;
}

/** Axes of a grid. @param text  "KEY = VALUE, VALUE", one a line */
function axesOf(text) {
  return text.split('\n').filter(line => line.trim()).map(line => {
    const [key, values] = line.split('=').map(part => part.trim());
    if (!key || !values) throw new Error(`${line}: write KEY = VALUE, VALUE`);
    return {key, values: values.split(',').map(value => value.trim())};
  });
}
const plans = {
  sweep: text => ({design: 'GRID', axes: axesOf(text)}),
  uncertainty: () => ({design: 'LATIN_HYPERCUBE', purpose: 'UNCERTAINTY', runs: 64}),
  sensitivity: () => ({design: 'ENDS', purpose: 'SENSITIVITY'}),
};

/** A form that begins a study. */
function studyForm() {
  const base = h('select', {id: 'study-case'}), fault = h('p', {class: 'bad lines', role: 'alert'});
  const axes = h('textarea', {id: 'axes', rows: 3, placeholder: 'KEY = VALUE, VALUE'});
  const label = h('label', {for: 'axes'}, 'Keys and their values, one key a line', axes);
  const kind = h('select', {
    id: 'kind', onchange: () => { label.hidden = kind.value !== 'sweep'; }
  }, Object.keys(plans).map(name => h('option', {}, name)));
  const begin = async () => {
    try {
      replace(fault);
      const sweep = plans[kind.value](axes.value);
      const {id} = await beginStudy(await readCase(base.value), {sweep});
      location.hash = `#/study/${id}`;
    } catch ({message}) { replace(fault, message); }
  };
  caseNames().then(
    names => replace(base, names.map(name => h('option', {}, name))), ({message}) => replace(fault, message));
  return h('details', {class: 'card levers submitter'}, h('summary', {}, 'Begin a study'),
    h('label', {for: 'study-case'}, 'Case ', base), h('label', {for: 'kind'}, 'Study ', kind), label,
    h('div', {class: 'bar'}, h('button', {type: 'button', onclick: begin}, 'Begin')), fault);
}

export function studiesPage(element, signal) {
  const list = h('div');
  const heads = ['Study', 'Id', 'Kind', 'State', 'Begun'];
  const rowOf = study => [
    h('a', {href: `#/study/${study.id}`}, nameOf(study)), shortId(study.id), kindOf(study),
    answerState(study), ago(study.create_time)
  ];

  replace(element, h('h1', {}, 'Studies'), studyForm(), list);
  repeat(3000, signal, async () => {
    const {studies} = await call('ListStudies', {page_size: 200});
    if (signal.aborted) return;
    replace(list, studies.length === 0
      ? h('p', {class: 'soft'}, 'No studies yet.')
      : sheet(heads, studies.map(rowOf)));
  });
}

/** A choice among the values of an axis. */
function choice(axis, id, changed) {
  const options = [...new Set(axis.values)].map(value => h('option', {}, value));
  const select = h('select', {id, onchange: changed}, options);
  return {key: axis.key, value: () => select.value, element: h('label', {for: id}, axis.key, select)};
}

/** A slider between the ends of an axis. */
function slider(axis, id, changed) {
  // The text of an end carries the unit: "40 mm/min".
  const [, , unit] = /^\s*([-+.\deE]+)\s*(.*)$/.exec(axis.values[0]) || [0, 0, ''];
  const ends = axis.values.map(parseFloat), low = Math.min(...ends), high = Math.max(...ends);

  const output = h('output', {for: id});
  const value = () => `${Number(input.value).toPrecision(5)}${unit ? ` ${unit}` : ''}`;
  const show = () => { output.textContent = value(); };
  const oninput = () => {
    show();
    changed();
  };
  const input = h('input', {
    type: 'range', id, min: low, max: high, step: (high - low) / 100, value: (low + high) / 2, oninput
  });
  show();
  return {key: axis.key, value, element: h('label', {for: id}, axis.key, output, input)};
}

/** A slider where all values of the runs are numbers, else a choice. */
function control(axis, numbers, changed) {
  const isRange = numbers.length > 0 && numbers.every(Number.isFinite);
  return (isRange ? slider : choice)(axis, `axis-${axis.key}`, changed);
}

/** The curves of a response surface, in mm, each within twice the error of the surface. */
function surfaceLines(curves) {
  const inMm = (values, factor) => values.map(v => (v === null ? NaN : factor * v));
  return curves.map(curve => {
    const y = inMm(curve.curl_m, 1e3), off = inMm(curve.uncertainty_m, 2e3);
    const low = y.map((v, i) => v - off[i]), high = y.map((v, i) => v + off[i]);
    return {name: curve.monitor, x: curve.time_s, y, low, high};
  });
}

/** What the response surface predicts, drawn and in words. */
function prediction({curves, end_lower_error_m: lower, end_upper_error_m: upper, runs}) {
  const ends = curves.map(({monitor, curl_m: curl}, i) =>
    `${monitor} ${curlText(curl.at(-1) ?? NaN, lower[i], upper[i])}`);
  const title = 'Curl by the response surface; the band is twice its own standard error';
  return [
    chart(surfaceLines(curves), {title, xLabel: 'time, s', yLabel: 'mm'}),
    h('p', {}, `${ends.join(', ')}${upper.length ? ' (with mesh and time steps)' : ''}; from ${runs} runs.`)
  ];
}

/** The curl at the end of a run, with its error where that is known. */
function endCurl(run, k) {
  const end = run.end_curl_m[k];
  if (end === null || end === undefined) return '–';
  return curlText(end, run.end_lower_error_m[k], run.end_upper_error_m[k]).replace(' mm', '');
}

/** The runs of a study with what differs between them. */
function runTable({study, runs, monitors}) {
  const axes = study.sweep?.axes || [], levers = study.remedy ? ['Change'] : [];
  const heads = ['Run', ...levers, ...axes.map(axis => axis.key), ...monitors.map(m => `${m} mm`), 'State'];
  const rowOf = (run, i) => [
    run.job ? h('a', {href: `#/job/${run.job}`}, `${i + 1}`) : `${i + 1}`,
    ...levers.map(() => run.lever_step?.words || 'the case itself'),
    ...axes.map((axis, k) => run.values[k] || ''),
    ...monitors.map((monitor, k) => ({class: 'number', content: endCurl(run, k)})),
    stateText(run.state)
  ];
  return sheet(heads, runs.map(rowOf));
}

export async function studyPage(element, signal, id) {
  const heading = h('h1', {}, 'Study'), state = h('p', {role: 'status'}), table = h('div');
  const answer = h('div', {id: 'answer', class: 'card'});
  const surface = h('div', {class: 'card'}), picture = h('div');
  replace(element, heading, state, answer, surface, table);
  surface.hidden = answer.hidden = true;

  // What the server concludes, asked for when runs have ended since: that of a sweep can take a second.
  let judged = '';
  async function judge(study) {
    const now = `${study.state} ${study.succeeded} ${study.failed} ${study.cancelled}`;
    if (now === judged) return;
    judged = now;
    const found = (await callDrawn('JudgeStudy', {id})).judgement;
    if (signal.aborted) return;

    // The table of runs below has links to their jobs.
    const shown = judgement(found, key => key !== 'runs');
    answer.hidden = shown.length === 0;
    replace(answer, h('h2', {}, found.heading), shown);
  }

  function showFault(fault) {
    judged = '';
    answer.hidden = false;
    replace(answer, h('p', {class: 'soft'}, fault.message));
  }

  // Of several predictions under way only the last one is shown.
  let controls = null, asked = 0;
  async function predict() {
    const mine = ++asked;
    try {
      const values = controls.map(each => ({key: each.key, value: each.value()}));
      const found = await call('PredictStudy', {id, values});
      if (mine === asked && !signal.aborted) replace(picture, ...prediction(found));
    } catch (fault) {
      replace(picture, h('p', {class: 'soft'}, fault.message));
    }
  }

  function addControls(axes, runs) {
    const numbersOf = k => runs.map(run => run.numbers[k] ?? NaN);
    controls = axes.map((axis, k) => control(axis, numbersOf(k), predict));
    surface.hidden = false;
    replace(surface, h('h2', {}, 'Response surface'),
      h('div', {class: 'levers'}, controls.map(each => each.element)), picture);
  }

  repeat(3000, signal, async () => {
    const result = await call('EvaluateStudy', {id});
    if (signal.aborted) return;

    const {study} = result, axes = study.sweep?.axes || [];
    judge(study).catch(showFault);
    heading.textContent = nameOf(study);
    state.textContent = `${kindOf(study)} ${shortId(id)}, ${answerState(study)}`;
    replace(table, runTable(result));
    if (!controls && axes.length && study.sweep.design !== 'ENDS') addControls(axes, result.runs);
    if (controls) predict();
  });
}
