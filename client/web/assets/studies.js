// Studies, and of a sweep the response surface: a slider for each key.
import {call, callDrawn, put, repeat} from './api.js';
import {beginStudy, caseNames, goOnWithJob, readCase} from './cases.js';
import {chart} from './chart.js';
import {ago, attempts, button, curlText, field, h, replace, sheet, shortId, stateText} from './dom.js';
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
/** What of the entries is given, each as `made` makes it. */
const given = (entries, made = text => text) => Object.fromEntries(
  Object.entries(entries).filter(([, text]) => text !== '').map(([key, text]) => [key, made(text)]));

async function calibration({measured, runs}, {complete}) {
  if (!measured) throw new Error('Choose the file with what was measured.');
  const monitors = new URLSearchParams((complete.monitor || []).map(({name}) => ['monitor', name]));
  const curves = await put(`/measured/${encodeURIComponent(measured.name)}?${monitors}`, measured);
  return {sweep: {...hypercube(runs), purpose: 'CALIBRATION', measured: curves}};
}

const hypercube = runs => ({design: 'LATIN_HYPERCUBE', runs: Number(runs)});
const runs = ['Runs', '64'];
/**
 * What begins here. `asks`: by key [name, what is usual, example]; `plan`: of the entries and the case
 * that was read, as in CreateStudyRequest. Quantities have their units.
 */
const plans = {
  sweep: {
    asks: {axes: ['Keys and their values, one key a line', '', 'KEY = VALUE, VALUE']},
    plan: ({axes}) => ({sweep: {design: 'GRID', axes: axesOf(axes)}})
  },
  uncertainty: {
    asks: {runs}, plan: entries => ({sweep: {...hypercube(entries.runs), purpose: 'UNCERTAINTY'}})
  },
  sensitivity: {asks: {}, plan: () => ({sweep: {design: 'ENDS', purpose: 'SENSITIVITY'}})},
  recipe: {
    asks: {
      band: ['Curls that the plant accepts; empty: those of the case', '', '35..45 mm'],
      speed: ['Limits of the casting speed', '', '20..120 mm/min'],
      water: ['Limits of the water', '', '30..400 l/min/m'],
      hold: ['Limits of the hold', '', '10..300 s'],
      filling: ['Limits of the filling', '', '5..200 s'],
      drafts: ['Drafts over recipe and data', '128'],
      castings: ['Drafts over the data at each recipe, twice', '12'],
      candidates: ['Recipes of the front', '4']
    },
    plan: ({drafts, castings, candidates, ...limits}) =>
      ({limits: given(limits), recipe: given({drafts, castings, candidates}, Number)})
  },
  'mould design': {
    asks: {
      tolerance: ['Largest deviation of the cold half-thickness, mm', '0.5'],
      wanted: ['Its half-thickness, mm; empty: that of the mould at its narrow face', ''],
      most: ['Largest number of runs', '12']
    },
    plan: ({tolerance, wanted, most}) => ({mould: {
      tolerance_m: 1e-3 * tolerance, wanted_half_thickness_m: 1e-3 * wanted, maximum_runs: Number(most)
    }})
  },
  calibration: {asks: {measured: ['Measured curls or temperatures, CSV'], runs}, plan: calibration},
};

/** An entry of a plan. @return {element, value: its text or file} */
function entryOf(key, [name, usual, example]) {
  const given = {id: `study-${key}`, value: usual, placeholder: example};
  const box = key === 'axes' ? h('textarea', {...given, rows: 3})
    : h('input', {...given, type: usual === undefined ? 'file' : 'text'});
  return {element: field(name, box), value: () => usual === undefined ? box.files[0] : box.value.trim()};
}

/** A form that begins a study. @param wanted  name of its case; undefined: the first one */
function studyForm(wanted) {
  const {fault, attempt} = attempts();
  const base = h('select', {id: 'study-case'}), asked = h('div', {class: 'levers row'});
  let entries = {};
  const ask = () => {
    const {asks} = plans[kind.value];
    entries = Object.fromEntries(Object.entries(asks).map(([key, ask]) => [key, entryOf(key, ask)]));
    replace(asked, Object.values(entries).map(({element}) => element));
  };
  const kind = h('select', {id: 'kind', onchange: ask},
    Object.keys(plans).map(name => h('option', {}, name)));
  const begin = async () => {
    const texts = Object.fromEntries(Object.entries(entries).map(([key, {value}]) => [key, value()]));
    const made = await readCase(base.value);
    const {id} = await beginStudy(made, await plans[kind.value].plan(texts, made));
    location.hash = `#/study/${id}`;
  };
  attempt(async () => replace(
    base, (await caseNames()).map(name => h('option', {selected: name === wanted}, name))));
  ask();
  return h('details', {class: 'card levers submitter', open: Boolean(wanted)},
    h('summary', {}, 'Begin a study'), field('Case', base), field('Study', kind), asked,
    h('div', {class: 'bar'}, button('Begin', () => attempt(begin))), fault);
}

export function studiesPage(element, signal, wanted) {
  const list = h('div');
  const heads = ['Study', 'Id', 'Kind', 'State', 'Begun'];
  const rowOf = study => [
    h('a', {href: `#/study/${study.id}`}, nameOf(study)), shortId(study.id), kindOf(study),
    answerState(study), ago(study.create_time)
  ];

  replace(element, h('h1', {}, 'Studies'), studyForm(wanted), list);
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

const soundly = '*';  // no name of a line

export async function studyPage(element, signal, id) {
  const heading = h('h1', {}, 'Study'), state = h('p', {role: 'status'}), table = h('div');
  const answer = h('div', {id: 'answer', class: 'card'});
  const surface = h('div', {class: 'card'}), picture = h('div');
  const {fault, attempt} = attempts(), takes = h('div', {class: 'bar submitter'}), castings = h('p');
  replace(element, heading, state, castings, answer, takes, fault, surface, table);
  surface.hidden = answer.hidden = true;

  // The castings of a line say more of its data.
  const line = h('select', {id: 'line'});
  async function offerLines() {
    const {lines} = await call('ListLines');
    replace(line, h('option', {value: ''}, 'none'),
      lines.map(({name}) => h('option', {value: name}, `line ${name}`)),
      h('option', {value: soundly}, '200 sound ones'));
  }
  function drawLine() {
    const name = line.value === soundly ? '' : line.value;
    replace(castings, field('Given castings:', line),
      name ? h('a', {href: `#/line/${name}/${id}`}, ' those that count') : null);
  }

  // What the server concludes, asked for when runs have ended since: that of a sweep can take a second.
  let judged = '';
  async function judge(study) {
    if (study.sweep?.purpose === 'UNCERTAINTY' && !line.isConnected) {
      drawLine();
      offerLines().catch(() => {});
    }
    const given = line.value;
    const now = `${study.state} ${study.succeeded} ${study.failed} ${study.cancelled} ${given}`;
    if (now === judged) return;
    judged = now;
    const question = given === soundly ? {assume_sound: true} : {line: given};
    const {judgement: found, result} =
      await callDrawn('JudgeStudy', {id, ...question, with_result: Boolean(study.recipe)});
    if (signal.aborted || now !== judged) return;

    // Those of the table that is shown: their order changes while castings end.
    recipes = result?.recipe;
    offer(study);

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

  // Buttons stay as they are while what they do does.
  let offered = '', recipes;
  function offer({state: now}) {
    const {front = [], chosen} = recipes ?? {};
    const ready = front.map(({full_job: job, full_state: end}, i) => ({job, end, i}))
      .filter(({end}) => end === 'SUCCEEDED');
    const key = JSON.stringify([now, ready, chosen]);
    if (key === offered) return;
    offered = key;
    const act = (text, method) => button(text, () => attempt(() => call(method, {id})));
    replace(takes,
      now === 'STUDY_RUNNING' ? act('Cancel the study', 'CancelStudy') : null,
      ['STUDY_CANCELLED', 'STUDY_FAILED'].includes(now) ? act('Resume the study', 'ResumeStudy') : null,
      ready.map(({job, i}) => button(`Take recipe ${i + 1}${i === chosen ? ', the chosen one' : ''}`,
        () => attempt(() => goOnWithJob('new', job)))));
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
    line.onchange = () => {
      drawLine();
      judge(study).catch(showFault);
    };
    offer(study);
    heading.textContent = nameOf(study);
    state.textContent = `${kindOf(study)} ${shortId(id)}, ${answerState(study)}`;
    replace(table, runTable(result));
    if (!controls && axes.length && study.sweep.design !== 'ENDS') addControls(axes, result.runs);
    if (controls) predict();
  });
}
