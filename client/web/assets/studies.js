// Studies, and of a sweep the response surface: a slider for each key.
import {call, repeat} from './api.js';
import {chart, curlLines} from './chart.js';
import {ago, curlText, h, meshErrors, mm, replace, sheet, shortId, stateText} from './dom.js';
import {judgement} from './judgement.js';

const kinds = {sweep: 'sweep', refinement: 'refinement', mould: 'mould design', recipe: 'recipe', remedy: 'remedy'};
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

export function studiesPage(element, signal) {
  const list = h('div');
  replace(element, h('h1', {}, 'Studies'), list);
  repeat(3000, signal, async () => {
    const {studies} = await call('ListStudies', {page_size: 200});
    if (signal.aborted) return;
    replace(list, studies.length === 0 ? h('p', {class: 'soft'}, 'No studies yet: dccast sweep my.toml --grid KEY=a,b')
      : sheet(['Study', 'Id', 'Kind', 'State', 'Begun'], studies.map(study => [
        h('a', {href: `#/study/${study.id}`}, nameOf(study)), shortId(study.id), kindOf(study), answerState(study), ago(study.create_time)])));
  });
}

/** Values of an axis: a slider between the ends of a range, a choice among others. */
function control(axis, numbers, changed) {
  const id = `axis-${axis.key}`, finite = numbers.filter(Number.isFinite);
  if (finite.length < numbers.length || finite.length === 0) {
    const select = h('select', {id, onchange: changed}, [...new Set(axis.values)].map(v => h('option', {}, v)));
    return {key: axis.key, value: () => select.value, element: h('label', {for: id}, axis.key, select)};
  }
  // The text of an end carries the unit: "40 mm/min".
  const [, , unit] = /^\s*([-+.\deE]+)\s*(.*)$/.exec(axis.values[0]) || [0, 0, ''];
  const ends = axis.values.map(parseFloat), low = Math.min(...ends), high = Math.max(...ends);
  const output = h('output', {for: id}), slider = h('input', {type: 'range', id, min: low, max: high, step: (high - low) / 100, value: (low + high) / 2, oninput: () => { show(); changed(); }});
  const value = () => `${Number(slider.value).toPrecision(5)}${unit ? ` ${unit}` : ''}`;
  const show = () => { output.textContent = value(); };
  show();
  return {key: axis.key, value, element: h('label', {for: id}, axis.key, output, slider)};
}

export async function studyPage(element, signal, id) {
  const state = h('p', {role: 'status'}), answer = h('div', {id: 'answer', class: 'card'}), table = h('div'), surface = h('div', {class: 'card'});
  let controls = null;
  const heading = h('h1', {}, 'Study');
  replace(element, heading, state, answer, surface, table);
  surface.hidden = answer.hidden = true;

  // What the server concludes, asked for when runs have ended since: that of a sweep can take a second.
  let judged = '';
  async function judge(study) {
    const now = `${study.state} ${study.succeeded} ${study.failed} ${study.cancelled}`;
    if (now === judged) return;
    judged = now;
    const found = (await call('JudgeStudy', {id})).judgement;
    if (signal.aborted) return;
    // The table of runs below has links to their jobs.
    const shown = judgement(found, part => part.table?.key !== 'runs');
    answer.hidden = shown.length === 0;
    replace(answer, h('h2', {}, found.heading), shown);
  }

  let asked = 0;
  async function predict(sweep) {
    const mine = ++asked;
    try {
      const found = await call('PredictStudy', {id, values: controls.map(c => ({key: c.key, value: c.value()}))});
      if (mine !== asked || signal.aborted) return;
      const mesh = found.mesh_error;
      const lines = found.curves.map(curve => {
        const y = curve.curl_m.map(v => (v === null ? NaN : 1e3 * v)), off = curve.uncertainty_m.map(v => (v === null ? NaN : 2e3 * v));
        return {name: curve.monitor, x: curve.time_s, y, low: y.map((v, i) => v - off[i]), high: y.map((v, i) => v + off[i])};
      });
      const ends = found.curves.map(curve => {
        const end = curve.curl_m.at(-1) ?? NaN;
        return `${curve.monitor} ${curlText(end, ...meshErrors(end, mesh))}`;
      }).join(', ');
      replace(picture, chart(lines, {title: 'Curl by the response surface; the band is twice its own standard error', xLabel: 'time, s', yLabel: 'mm'}),
        h('p', {}, `${ends}${mesh ? ' (with mesh and time steps)' : ''}; from ${found.runs} runs.`));
    } catch (fault) {
      replace(picture, h('p', {class: 'soft'}, fault.message));
    }
  }
  const picture = h('div');

  repeat(3000, signal, async () => {
    const result = await call('EvaluateStudy', {id});
    if (signal.aborted) return;
    const {study} = result, sweep = study.sweep;
    judge(study).catch(fault => { judged = ''; answer.hidden = false; replace(answer, h('p', {class: 'soft'}, fault.message)); });
    heading.textContent = nameOf(study);
    state.textContent = `${kindOf(study)} ${shortId(id)}, ${answerState(study)}`;
    const axes = sweep?.axes || [];
    const curl = (run, k) => {
      const end = run.end_curl_m[k];
      if (end === null || end === undefined) return '–';
      if (!run.mesh_error) return mm(end, 2);
      return curlText(end, ...meshErrors(end, run.mesh_error)).replace(' mm', '');
    };
    const levers = study.remedy ? ['Change'] : [];
    replace(table, sheet(['Run', ...levers, ...axes.map(a => a.key), ...result.monitors.map(m => `${m} mm`), 'State'],
      result.runs.map((run, i) => [
        run.job ? h('a', {href: `#/job/${run.job}`}, `${i + 1}`) : `${i + 1}`,
        ...levers.map(() => run.lever_step?.words || 'the case itself'),
        ...axes.map((a, k) => run.values[k] || ''),
        ...result.monitors.map((m, k) => ({class: 'number', content: curl(run, k)})),
        stateText(run.state)])));
    if (!controls && axes.length && sweep.design !== 'ENDS') {
      controls = axes.map((axis, k) => control(axis, result.runs.map(run => run.numbers[k] ?? NaN), () => predict(sweep)));
      surface.hidden = false;
      replace(surface, h('h2', {}, 'Response surface'), h('div', {class: 'levers'}, controls.map(c => c.element)), picture);
    }
    if (controls) predict(sweep);
  });
}
