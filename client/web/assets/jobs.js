// The queue: newest first, with a sketch of each curl and its gravest finding.
import {call, get, repeat} from './api.js';
import {spark} from './chart.js';
import {ago, curlText, h, replace, severityText, shortId, stateText, worst} from './dom.js';

const sketches = new Map();  // of jobs that have ended: they change no more
const ended = new Set(['SUCCEEDED', 'FAILED', 'CANCELLED']);
const most = 1000;

export const lastCurl = job => (job.last_step?.monitors || []).reduce((most, m) => {
  const curl = (m.displacement_m || []).at(-1);
  return curl !== undefined && !(Math.abs(curl) <= Math.abs(most)) ? curl : most;
}, NaN);

async function sketch(job, cell) {
  const key = ended.has(job.state) ? job.id : `${job.id} ${job.last_step?.step}`;
  if (!sketches.has(key)) sketches.set(key, await get(`/sketch/${job.id}`));
  const {time_s: x, curl_m: y} = sketches.get(key);
  if (x.length > 1) replace(cell, spark(x, y));
}

export function jobsPage(element, signal) {
  const counts = h('p', {class: 'soft', role: 'status'});
  const filter = h('input', {type: 'search', placeholder: 'Title, id, owner or label', 'aria-label': 'Filter the jobs', oninput: () => draw()});
  const compare = h('button', {type: 'button', disabled: true, onclick: () => { location.hash = `#/compare/${[...chosen].join('/')}`; }}, 'Compare');
  const body = h('tbody');
  const chosen = new Set(), rows = new Map();
  let jobs = [];
  const seen = new IntersectionObserver(entries => {
    for (const entry of entries) if (entry.isIntersecting) {
      const row = rows.get(entry.target.dataset.job);
      if (row) sketch(row.job, row.cells.sketch).catch(() => {});
      seen.unobserve(entry.target);
    }
  });
  signal.addEventListener('abort', () => seen.disconnect());

  function rowOf(job) {
    const cells = {};
    const cell = name => (cells[name] = h('td', {class: name}));
    const box = h('input', {type: 'checkbox', 'aria-label': `Compare ${job.title || job.id}`, onchange: event => {
      if (event.target.checked) chosen.add(job.id); else chosen.delete(job.id);
      compare.disabled = chosen.size < 2;
    }});
    const tr = h('tr', {'data-job': job.id}, h('td', {}, box), cell('title'), cell('state'), cell('curl'), cell('sketch'), cell('finding'), cell('owner'), cell('when'));
    replace(cells.title, h('a', {href: `#/job/${job.id}`}, job.title || shortId(job.id)), h('small', {}, ` ${shortId(job.id)}`));
    return {tr, cells, job: null};
  }

  function fill(row, job) {
    const before = row.job;
    row.job = job;
    if (before && JSON.stringify(before) === JSON.stringify(job)) return;
    const {cells} = row, progress = job.last_step?.progress;
    replace(cells.state, h('span', {class: `state ${job.state.toLowerCase()}`}, stateText(job.state)),
      job.state === 'RUNNING' ? h('progress', {value: progress || 0, max: 1, 'aria-label': 'Progress'}) : null,
      job.state === 'QUEUED' && job.queue_position ? h('small', {}, ` place ${job.queue_position}`) : null);
    const curl = lastCurl(job);
    replace(cells.curl, Number.isFinite(curl) ? curlText(curl) : '');
    const grave = worst(job.findings || []);
    replace(cells.finding, grave > 1 ? h('span', {class: `tag ${severityText[grave]}`}, severityText[grave]) : '');
    replace(cells.owner, job.owner || '');
    replace(cells.when, ago(job.create_time));
    seen.observe(row.tr);
  }

  const matches = job => {
    const text = filter.value.trim().toLowerCase();
    return text === '' || [job.title, job.id, job.owner, ...(job.labels || [])].some(t => (t || '').toLowerCase().includes(text));
  };

  function draw() {
    const shown = jobs.filter(matches);
    for (const job of shown) {
      if (!rows.has(job.id)) rows.set(job.id, rowOf(job));
      fill(rows.get(job.id), job);
    }
    const wanted = shown.map(job => rows.get(job.id).tr);
    if (wanted.length !== body.children.length || wanted.some((tr, i) => body.children[i] !== tr)) replace(body, wanted);
    const of = state => jobs.filter(job => job.state === state).length;
    counts.textContent = jobs.length === 0 ? 'No jobs yet: dccast submit my.toml, or What-if.'
      : `${jobs.length}${jobs.length === most ? ' newest' : ''} jobs: ${of('RUNNING')} running, ${of('QUEUED')} queued, ${of('SUCCEEDED')} succeeded, ${of('FAILED')} failed`;
  }

  replace(element, h('h1', {}, 'Jobs'), h('div', {class: 'bar'}, filter, compare), counts,
    h('div', {class: 'scroll'}, h('table', {class: 'jobs'}, h('thead', {}, h('tr', {}, ['', 'Job', 'State', 'Curl', 'Course', 'Findings', 'Owner', 'Submitted'].map(t => h('th', {scope: 'col'}, t)))), body)));
  repeat(2000, signal, async () => {
    jobs = (await call('ListJobs', {page_size: most})).jobs;
    if (!signal.aborted) draw();
  });
}
