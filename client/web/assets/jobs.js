// The queue: newest first, runs folded under their study, with a sketch of each curl and its
// gravest finding.
import {call, repeat} from './api.js';
import {cancelJobs} from './cancel.js';
import {spark} from './chart.js';
import {ago, button, curlText, h, mm, replace, severityText, shortId, stateText, worst} from './dom.js';
import {curlLines, ended, isSound, judgedMonitor} from './history.js';
import {answerState, kindOf, nameOf} from './studies.js';

const sketches = new Map();  // lines of curl by job and step: ended jobs change no more
const most = 1000;

const lastCurl = job => judgedMonitor(job)?.curl_m ?? NaN;

async function sketch(job, cell) {
  const judged = judgedMonitor(job);
  if (!judged) return replace(cell);
  const key = ended.has(job.state) ? job.id : `${job.id} ${job.last_step?.step}`;
  if (!sketches.has(key)) {
    const {steps} = await call('QueryResult', {id: job.id, samples: 60});
    sketches.set(key, curlLines(steps).find(line => line.monitor === judged.name));
  }
  const line = sketches.get(key);
  if (line?.x.length > 1) replace(cell, spark(line.x, line.y));
}

/** "draft" and what differs from the case file, as lines. */
function changesOf(job, without = new Set()) {
  const changes =
    (job.changes || []).filter(c => c.key !== 'quality').map(c => `${c.key} = ${c.value}`);
  return changes.filter(text => !without.has(text));
}
const qualityOf = job => job.quality ||
  (job.changes || []).find(c => c.key === 'quality')?.value.replaceAll('"', '') || '';

/** A change, which may be broken behind the dots of its key. */
const changeLine = text => h('small', {class: 'change'},
  text.split('.').flatMap((part, i) => (i ? ['.', h('wbr'), part] : [part])));

function qualityCell(quality, changes) {
  const shown = changes.slice(0, 3).map(changeLine);
  const rest = changes.length > 3
    ? h('small', {class: 'change', title: changes.slice(3).join('\n')},
        `and ${changes.length - 3} more`)
    : null;
  return [quality, ...shown, rest];
}

const columns = [
  ['title', 'Job'], ['state', 'State'], ['curl', 'Curl'], ['sketch', 'Course'],
  ['quality', 'Quality, changes'], ['finding', 'Findings'], ['owner', 'Owner'],
  ['when', 'Submitted']
];

/** A row with a box to choose it and an empty cell for each column. */
function emptyRow(attributes, box) {
  const cells = Object.fromEntries(columns.map(
    ([name,
      label]) => [name, h('td', {class: name, 'data-label': name === 'title' ? null : label})]));
  return {
    tr: h('tr', attributes, h('td', {class: 'box'}, box), Object.values(cells)),
    cells,
    seen: ''
  };
}

const severityTag = findings => {
  const grave = worst(findings);
  return grave > 1 ? h('span', {class: `tag ${severityText[grave]}`}, severityText[grave]) : '';
};

export function jobsPage(element, signal) {
  const counts = h('p', {class: 'soft', role: 'status'}),
        fault = h('p', {class: 'bad', role: 'alert'});
  const body = h('tbody'), chosen = new Set(), rows = new Map(), groups = new Map();
  let jobs = [], studies = new Map();

  const filter = h('input', {
    type: 'search',
    placeholder: 'Title, id, owner or label',
    'aria-label': 'Filter the jobs',
    oninput: () => draw()
  });
  const label = h('select', {'aria-label': 'Label', onchange: () => draw()});
  /** A box that chooses jobs. */
  function boxOf(label, choice) {
    const onchange = () => {
      for (const job of choice())
        if (box.checked) chosen.add(job.id);
        else chosen.delete(job.id);
      draw();
    };
    const box = h('input', {type: 'checkbox', 'aria-label': label, onchange});
    return box;
  }
  const everything = boxOf(null, () => matching());

  // ---- What is done with the chosen jobs

  const chosenJobs = able => jobs.filter(job => chosen.has(job.id) && able(job));
  const told = text => {
    fault.textContent = text;
    refresh().catch(() => {});
  };
  async function each(name, able) {
    const answers = await Promise.allSettled(chosenJobs(able).map(job => call(name, {id: job.id})));
    told(answers.filter(a => a.reason).map(a => a.reason.message).join('; '));
  }

  const canPause = job => ['RUNNING', 'QUEUED'].includes(job.state);
  const canCancel = job => !ended.has(job.state);
  const openComparison = () => { location.hash = `#/compare/${[...chosen].join('/')}`; };
  const acts = [
    {text: 'Compare', least: 2, able: () => true, act: openComparison},
    {text: 'Pause', able: canPause, act: able => each('PauseJob', able)},
    {text: 'Resume', able: job => job.state === 'PAUSED', act: able => each('ResumeJob', able)},
    {text: 'Cancel', able: canCancel, act: able => cancelJobs(chosenJobs(able), {done: told})},
  ];
  for (const act of acts) {
    const kind = act.act === openComparison ? null : 'submitter';  // which a viewer does not see
    const onclick = () => act.act(act.able);
    act.button = button(act.text, onclick, {class: kind, disabled: true});
  }

  function drawActs() {
    for (const {text, least = 1, able, button} of acts) {
      const count = chosenJobs(able).length;
      button.disabled = count < least;
      button.textContent = count < least ? text : `${text} ${count}`;
    }
    const shown = matching();
    everything.checked = shown.length > 0 && shown.every(job => chosen.has(job.id));
  }

  // ---- Rows

  const seen = new IntersectionObserver(entries => {
    for (const entry of entries)
      if (entry.isIntersecting) {
        const row = rows.get(entry.target.dataset.job);
        if (row) sketch(row.job, row.cells.sketch).catch(() => {});
        seen.unobserve(entry.target);
      }
  });
  signal.addEventListener('abort', () => seen.disconnect());

  function rowOf(job) {
    const box = boxOf(`Choose ${job.title || job.id}`, () => [job]);
    const row = emptyRow({'data-job': job.id, class: job.study ? 'run' : null}, box);
    replace(
      row.cells.title, h('a', {href: `#/job/${job.id}`}, job.title || shortId(job.id)),
      h('small', {}, ` ${shortId(job.id)}`),
      (job.labels || []).map(text => h('small', {class: 'label'}, text)));
    return {...row, box};
  }

  function fill(row, job, common) {
    row.box.checked = chosen.has(job.id);
    const now = JSON.stringify([job, [...common]]);
    if (row.seen === now) return;
    row.seen = now;
    row.job = job;

    const {cells} = row, curl = lastCurl(job);
    replace(
      cells.state, h('span', {class: `state ${job.state.toLowerCase()}`}, stateText(job.state)),
      job.state === 'RUNNING'
        ? h('progress', {value: job.last_step?.progress || 0, max: 1, 'aria-label': 'Progress'})
        : null,
      job.state === 'QUEUED' && job.queue_position ? h('small', {}, ` place ${job.queue_position}`)
                                                   : null);
    replace(cells.curl, Number.isFinite(curl) ? curlText(curl) : '');
    replace(cells.quality, qualityCell(qualityOf(job), changesOf(job, common)));
    replace(cells.finding, severityTag(job.findings || []));
    replace(cells.owner, job.owner || '');
    replace(cells.when, ago(job.create_time));
    seen.observe(row.tr);
  }

  // ---- Studies: one row for all runs, which unfolds

  function groupOf(study) {
    const group = {unfolded: false, runs: []};
    const box = boxOf(`Choose the runs of study ${shortId(study)}`, () => group.runs);
    const fold = () => {
      group.unfolded = !group.unfolded;
      group.toggle.setAttribute('aria-expanded', group.unfolded);
      draw();
    };
    group.toggle = button('Runs', fold, {class: 'fold', 'aria-expanded': 'false'});
    return Object.assign(group, emptyRow({class: 'study', 'data-study': study}, box), {box});
  }

  /** Changes that all runs have in common. */
  function commonChanges(runs) {
    const [first, ...others] = runs.map(job => new Set(changesOf(job)));
    return new Set([...first].filter(text => others.every(changes => changes.has(text))));
  }

  function fillGroup(group, id) {
    const {runs, cells} = group, study = studies.get(id), common = commonChanges(runs);
    group.common = runs.length > 1 ? common : new Set();
    group.box.checked = runs.every(job => chosen.has(job.id));
    const now = JSON.stringify([study, runs]);
    if (group.seen === now) return;
    group.seen = now;

    group.toggle.textContent = `${runs.length} runs`;
    group.toggle.setAttribute('aria-label', `${runs.length} runs of study ${shortId(id)}`);
    replace(
      cells.title, group.toggle,
      study ? h('a', {href: `#/study/${id}`}, nameOf(study)) : `Study ${shortId(id)}`,
      h('small', {}, study ? ` ${kindOf(study)} ${shortId(id)}` : ''));

    const count = state => runs.filter(job => job.state === state).length;
    replace(
      cells.state,
      study ? answerState(study) : `${count('SUCCEEDED')} of ${runs.length} succeeded`);
    const curls = runs.map(lastCurl).filter(Number.isFinite);
    replace(
      cells.curl, curls.length ? `${mm(Math.min(...curls))} to ${mm(Math.max(...curls))} mm` : '');
    const qualities = new Set(runs.map(qualityOf));
    replace(
      cells.quality, qualityCell([...qualities].filter(q => q).join(', '), [...group.common]));
    replace(cells.finding, severityTag(runs.flatMap(job => job.findings || [])));
    replace(cells.owner, runs[0].owner || '');
    replace(cells.when, ago(runs.at(-1).create_time));
  }

  // ---- The list

  const matches = job => {
    const text = filter.value.trim().toLowerCase();
    if (label.value && !(job.labels || []).includes(label.value)) return false;
    return text === '' || [
      job.title, job.id, job.owner, ...(job.labels || [])
    ].some(t => (t || '').toLowerCase().includes(text));
  };
  const matching = () => jobs.filter(matches);

  function jobRow(job, common = new Set()) {
    if (!rows.has(job.id)) rows.set(job.id, rowOf(job));
    const row = rows.get(job.id);
    fill(row, job, common);
    return row.tr;
  }

  /** The rows that are shown, a study where its newest run is. */
  function shownRows() {
    for (const group of groups.values()) group.runs = [];
    const entries = [];
    for (const job of matching()) {
      if (!job.study) {
        entries.push(() => [jobRow(job)]);
        continue;
      }
      if (!groups.has(job.study)) groups.set(job.study, groupOf(job.study));
      const group = groups.get(job.study);
      group.runs.push(job);
      if (group.runs.length > 1) continue;
      entries.push(() => {
        fillGroup(group, job.study);
        return [
          group.tr, ...(group.unfolded ? group.runs.map(run => jobRow(run, group.common)) : [])
        ];
      });
    }
    return entries.flatMap(make => make());
  }

  function drawLabels() {
    const labels = [...new Set(jobs.flatMap(job => job.labels || []))].sort();
    const now = labels.join('\n');
    if (label.dataset.labels === now) return;
    label.dataset.labels = now;
    const before = label.value;
    replace(
      label, h('option', {value: ''}, 'All labels'),
      labels.map(text => h('option', {value: text}, text)));
    label.value = labels.includes(before) ? before : '';
    label.hidden = labels.length === 0;
  }

  function draw() {
    drawLabels();
    const wanted = shownRows();
    if (wanted.length !== body.children.length || wanted.some((tr, i) => body.children[i] !== tr))
      replace(body, wanted);
    drawActs();
    const of = state => jobs.filter(job => job.state === state).length;
    counts.textContent = jobs.length === 0
      ? 'No jobs yet: dccast submit my.toml, or What-if.'
      : `${jobs.length}${jobs.length === most ? ' newest' : ''} jobs: ${of('RUNNING')} running, ${
          of('QUEUED')} queued, ${of('SUCCEEDED')} succeeded, ${of('FAILED')} failed`;
  }

  async function refresh() {
    const [listed, known] = await Promise.all(
      [call('ListJobs', {page_size: most}), call('ListStudies', {page_size: 200})]);
    jobs = listed.jobs;
    studies = new Map(known.studies.map(study => [study.id, study]));
    if (!signal.aborted) draw();
  }

  replace(
    element, h('h1', {}, 'Jobs'),
    h('div', {class: 'bar'}, filter, label, h('label', {}, everything, ' All shown'),
      acts.map(act => act.button)),
    fault, counts,
    h('div', {class: 'scroll'},
      h('table', {class: 'jobs sheet'},
        h('thead', {},
          h('tr', {},
            h('td'), columns.map(([, text]) => h('th', {scope: 'col'}, text)))),
        body)));
  repeat(2000, signal, refresh);
}
