// Studies, and of a sweep the response surface: a slider for each key.
import {call, repeat} from './api.js';
import {chart, curlLines} from './chart.js';
import {ago, curlText, fixed, h, mm, replace, shortId, stateText} from './dom.js';
import {judgement} from './judgement.js';

const kinds = {sweep: 'sweep', refinement: 'refinement', mould: 'mould design', recipe: 'recipe'};
const kindOf = study => kinds[Object.keys(kinds).find(kind => study[kind])] || 'study';

export function studiesPage(element, signal) {
  const body = h('tbody');
  replace(element, h('h1', {}, 'Studies'), h('div', {class: 'scroll'}, h('table', {}, h('thead', {}, h('tr', {},
    ['Study', 'Kind', 'State', 'Runs', 'Begun'].map(t => h('th', {scope: 'col'}, t)))), body)));
  repeat(3000, signal, async () => {
    const {studies} = await call('ListStudies', {page_size: 200});
    replace(body, studies.length ? studies.map(study => h('tr', {}, h('td', {}, h('a', {href: `#/study/${study.id}`}, study.title || shortId(study.id))),
      h('td', {}, kindOf(study)), h('td', {}, stateText(study.state)), h('td', {}, `${study.succeeded || 0} of ${study.runs}`), h('td', {}, ago(study.create_time))))
      : h('tr', {}, h('td', {colspan: 5}, 'No studies yet: dccast sweep my.toml --grid KEY=a,b')));
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
      const mesh = found.relative_curl_error;
      const lines = found.curves.map(curve => {
        const y = curve.curl_m.map(v => (v === null ? NaN : 1e3 * v)), off = curve.uncertainty_m.map(v => (v === null ? NaN : 2e3 * v));
        return {name: curve.monitor, x: curve.time_s, y, low: y.map((v, i) => v - off[i]), high: y.map((v, i) => v + off[i])};
      });
      const ends = found.curves.map(curve => `${curve.monitor} ${curlText(curve.curl_m.at(-1) ?? NaN, mesh)}`).join(', ');
      replace(picture, chart(lines, {title: 'Curl by the response surface; the band is twice its own standard error', xLabel: 'time, s', yLabel: 'mm'}),
        h('p', {}, `${ends}${mesh ? ' (± mesh and time steps)' : ''}; from ${found.runs} runs.`));
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
    heading.textContent = study.title || shortId(id);
    state.textContent = `${kindOf(study)} ${shortId(id)}, ${stateText(study.state)}: ${study.succeeded || 0} of ${study.runs} runs succeeded`;
    const axes = sweep?.axes || [];
    replace(table, h('div', {class: 'scroll'}, h('table', {}, h('thead', {}, h('tr', {}, ['Run', ...axes.map(a => a.key), ...result.monitors.map(m => `${m} mm`), 'State'].map(t => h('th', {scope: 'col'}, t)))),
      h('tbody', {}, result.runs.map((run, i) => h('tr', {}, h('td', {}, run.job ? h('a', {href: `#/job/${run.job}`}, `${i + 1}`) : `${i + 1}`), axes.map((a, k) => h('td', {}, run.values[k] || '')),
        result.monitors.map((m, k) => h('td', {class: 'number'}, run.end_curl_m[k] === null || run.end_curl_m[k] === undefined ? '–'
          : run.relative_curl_error ? curlText(run.end_curl_m[k], run.relative_curl_error).replace(' mm', '') : mm(run.end_curl_m[k], 2))),
        h('td', {}, stateText(run.state))))))));
    if (!controls && axes.length && sweep.design !== 'ENDS') {
      controls = axes.map((axis, k) => control(axis, result.runs.map(run => run.numbers[k] ?? NaN), () => predict(sweep)));
      surface.hidden = false;
      replace(surface, h('h2', {}, 'Response surface'), h('div', {class: 'levers'}, controls.map(c => c.element)), picture);
    }
    if (controls) predict(sweep);
  });
}
