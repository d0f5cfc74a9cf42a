// One job: its answer, its curl as it grows, its findings, its slab, its report.
import {call, get, getBytes, repeat, shared} from './api.js';
import {cancelJobs, confirmed} from './cancel.js';
import {goOnWithJob} from './cases.js';
import {chart, wantedBand} from './chart.js';
import {copyBox} from './copy_box.js';
import {
  attempts, button, durationText, faultLine, field, findingList, h, mm, monitorText, replace, shortId,
  stateText
} from './dom.js';
import {frameViewer} from './frame.js';
import {addStep, curlLines, ended, isSound, lastMonitors} from './history.js';
import {followJob} from './job_events.js';

/** The stored frames of a job, for the viewer. */
export const framesOf = job => ({
  look: () => get(`/frames/${job}`),
  frame: number => getBytes(`/jobs/${job}/frame?number=${number}`),
  field: (number, name) =>
    getBytes(`/jobs/${job}/frame?number=${number}&field=${encodeURIComponent(name)}`),
});

/** Shows the address of a job's page, for colleagues. */
function linkButton(job) {
  const hash = `#/job/${job.id}`, here = `${location.origin}/${hash}`;
  return button('Link', () => {
    const dialog = h(
      'dialog', {class: 'link', 'aria-label': 'Link to this job', onclose: () => dialog.remove()},
      h('h2', {}, 'Link to this job'),
      copyBox(shared ? 'For users of this server' : 'For this browser', here),
      h('p', {class: 'soft'}, `In a dashboard of your own: add ${hash} to its address.`),
      h('div', {class: 'bar'}, button('Close', () => dialog.close())));
    document.body.append(dialog);
    dialog.showModal();
  });
}

/**
 * Labels, priority, whether the job is kept, and its end.
 * @param act  (method, request, then) calls the service
 */
function marksOf({id, title, labels = [], pinned, priority, state}, act) {
  const update = request => act('UpdateJob', request);
  const label = h('input', {type: 'text', id: 'label', placeholder: 'line=3'});
  const kept = h('input', {
    type: 'checkbox', checked: pinned, onchange: () => update({pinned: kept.checked})
  });
  const choice = h('select', {
    id: 'priority', onchange: () => update({priority: choice.value})
  }, ['LOW', 'NORMAL', 'HIGH'].map(
    name => h('option', {value: name, selected: name === priority}, stateText(name))));
  const remove = async () => {
    const details = h('p', {class: 'soft'}, 'Its results go, too, and cannot be brought back.');
    if (await confirmed(`Delete ${title || id}?`, details, 'Delete it', 'Keep it'))
      await act('DeleteJob', {}, () => { location.hash = '#/jobs'; });
  };
  return [
    ...labels.map(text => h('span', {class: 'label'}, text,
      button('×', () => update({remove_labels: [text]}), {'aria-label': `Remove the label ${text}`}))),
    field('Label', label),
    button('Add', () => label.value.trim() && update({set_labels: [label.value.trim()]})),
    state === 'QUEUED' ? field('Priority', choice) : null,
    h('label', {}, kept, ' Keep when old jobs are deleted'),
    ended.has(state) ? button('Delete', remove, {class: 'danger'}) : null
  ];
}

/** Drafts of what helps against the findings, on a page of their own. */
function remedyButton({job, has_levers: hasLevers}) {
  if (!ended.has(job.state) || !hasLevers) return null;
  const {fault, attempt} = attempts();
  const begin = () => attempt(async () => {
    const {id} = await call('CreateStudy', {find: true, remedy: {job: job.id}});
    location.hash = `#/study/${id}`;
  });
  return h('div', {}, button('Compute what helps', begin, {class: 'submitter'}), fault);
}

export function jobPage(element, signal, id) {
  const head = h('div'), curves = h('div', {class: 'card'}), findings = h('div', {class: 'card'}),
        slab = h('div', {class: 'card'}), solver = h('div'), details = h('div');
  const answer = h('div');
  replace(
    element, head, answer, curves, h('div', {class: 'job-parts'}, slab, findings), solver, details);

  // Buttons stay as they are while the state does: one that is replaced under the pointer is not
  // pressed.
  const title = h('div'), at = h('p'), message = h('p', {class: 'bad', role: 'alert'}),
        tiles = h('div', {class: 'tiles'}), buttons = h('div', {class: 'bar'}),
        marks = h('div', {class: 'bar submitter'});
  replace(head, title, at, message, tiles, buttons, marks);
  let stateOfButtons = '', stateOfMarks = '';

  const download = (name, text) =>
    h('a', {class: 'button', href: `/jobs/${id}/${name}`, download: `${shortId(id)}-${name}`}, text);
  const withIt = (text, page) => button(
    text, () => goOnWithJob(page, id).catch(fault => replace(message, fault.message)), {class: 'submitter'});

  function drawHead({job, steps}) {
    const step = job.last_step || {};
    const forSubmitters = (text, work) => button(text, async ({target}) => {
      target.disabled = true;
      const enable = () => { target.disabled = false; };
      await work(enable);
    }, {class: 'submitter'});
    const act = (name, text) => forSubmitters(text, enable => call(name, {id: job.id}).then(load, fault => {
      replace(message, fault.message);
      enable();
    }));
    const cancel = () => forSubmitters('Cancel', async enable => {
      const done = text => {
        if (text) replace(message, text);
        enable();
        load();
      };
      if (!await cancelJobs([job], {done, undone: enable})) enable();
    });
    const last = (isSound(job) ? lastMonitors(steps) : []).map(
      m => h('div', {class: 'tile'}, h('span', {}, m.name), h('strong', {}, monitorText(m))));
    replace(
      title, h('p', {class: 'soft'}, `Job ${shortId(job.id)} of ${job.owner || 'unknown'}`),
      h('h1', {}, job.title || job.id));
    replace(message, job.failure?.message || job.held || null);
    replace(tiles, last);
    replace(
      at, h('span', {class: `state ${job.state.toLowerCase()}`}, stateText(job.state)),
      step.time_s ? ` at ${step.time_s.toFixed(1)} s, ${mm(step.cast_length_m, 0)} mm cast` : '',
      job.state === 'RUNNING'
        ? h('progress', {value: step.progress || 0, max: 1, 'aria-label': 'Progress'})
        : null,
      job.state === 'RUNNING' && job.ends_in_s ? ` about ${durationText(job.ends_in_s)} left` : '');
    const marked = JSON.stringify([job.state, job.labels, job.pinned, job.priority]);
    if (stateOfMarks !== marked)
      replace(marks, marksOf(job, (name, request, then = load) =>
        call(name, {id: job.id, ...request}).then(then, fault => replace(message, fault.message))));
    stateOfMarks = marked;
    if (stateOfButtons === job.state) return;
    stateOfButtons = job.state;
    replace(
      buttons, job.state === 'RUNNING' ? act('PauseJob', 'Pause') : null,
      job.state === 'PAUSED' ? act('ResumeJob', 'Resume') : null,
      ended.has(job.state) ? null : cancel(), linkButton(job),
      h('a', {class: 'button', href: `/jobs/${job.id}/report`, target: '_blank', rel: 'noopener'},
        'Report'),
      download('curl.csv', 'Curl as CSV'),
      job.state === 'SUCCEEDED' ? download('results.h5', 'Results') : null,
      withIt('What-if with it', 'what-if'), withIt('New case from it', 'new'),
      job.casting ? h('a', {class: 'button', href: `#/casting/${job.id}`}, 'Watch the casting') : null);
  }

  function drawCurves({steps, wanted}) {
    if (steps.length === 0) return replace(curves, h('p', {class: 'soft'}, 'No step yet.'));
    const lines = curlLines(steps);
    replace(curves, chart(lines, {
              title: lines.some(line => line.low) ? 'Curl, with the error of mesh and time steps' : 'Curl',
              xLabel: 'time, s',
              yLabel: 'mm',
              wanted: wantedBand(wanted)
            }));
  }

  // How well the steps of a run are solved, while it is watched.
  const solved = [];
  const digits = residual => Math.log10(Math.max(Math.abs(residual || 0), 1e-16));
  // The disclosure stays: one that is replaced under the pointer is not opened.
  const residuals = h('div');
  function drawSolved() {
    if (solved.length < 2) return;
    const line = (name, figure) => ({
      name, x: solved.map(step => step.time_s || 0), y: solved.map(step => digits(step[figure]))
    });
    if (!residuals.isConnected)
      replace(solver, h('details', {}, h('summary', {}, 'Residuals of the steps'), residuals));
    replace(
      residuals,
      chart([line('equilibrium', 'equilibrium_residual'), line('energy', 'energy_balance_error')], {
        title: 'Residuals of the steps, relative',
        xLabel: 'time, s',
        yLabel: 'log10',
        unit: ''
      }));
  }

  let shown = null, waiting = false, watched = false;
  function redraw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      drawHead(shown);
      drawCurves(shown);
      drawSolved();
      replace(
        findings, h('h2', {}, 'Findings'), findingList(shown.job.findings || []),
        remedyButton(shown));
    });
  }

  function watch() {
    watched = true;
    repeat(5000, signal, async () => {
      if (shown.job.state !== 'RUNNING') return;
      shown.job.ends_in_s = (await call('GetJob', {id})).ends_in_s;
      redraw();
    });
    followJob(id, signal, event => {
      if (event.step) addStep(solved, event.step);
      if (event.step && event.step.step > (shown.job.last_step?.step || 0)) {
        addStep(shown.steps, event.step);
        shown.job.last_step = event.step;
        redraw();
      } else if (event.finding) {
        shown.job.findings =
          [...(shown.job.findings || []).filter(f => f.code !== event.finding.code), event.finding];
        redraw();
      } else if (event.resumed || event.state_change) {
        if (event.resumed || event.state_change.state !== shown.job.state) load();
      }
    }).catch(fault => replace(details, faultLine(fault)));
  }

  // The slab with the frames that are stored so far, until the run has ended.
  let seesSlab = false;
  function watchSlab() {
    seesSlab = true;
    const looking = new AbortController();
    signal.addEventListener('abort', () => looking.abort());
    let viewer = null;
    repeat(4000, looking.signal, async () => {
      const last = ended.has(shown.job.state);
      try {
        if (viewer) await viewer.refresh();
        else viewer = await frameViewer(slab, signal, framesOf(id), shown.job.title || shortId(id));
      } catch (fault) {
        if (!viewer) replace(slab, h('h2', {}, 'Slab'), h('p', {class: 'soft'}, fault.message));
      }
      if (last) looking.abort();
    });
  }

  /** What the server concludes from the run, once it has ended. */
  async function conclude() {
    if (!ended.has(shown.job.state) || !shown.job.last_step) return;
    const {judgement} = await call('CompareRuns', {runs: [{job: id}]});
    replace(answer, judgement.sentences.map(text => h('p', {class: 'answer'}, text)));
  }

  let asked = 0, answered = 0;
  async function load() {
    const question = ++asked, seen = await get(`/job/${id}`);
    if (signal.aborted || question < answered) return;  // a later question has its answer already
    answered = question;
    shown = seen;
    redraw();
    replace(
      details, h('details', {}, h('summary', {}, 'The case, complete'), h('pre', {tabindex: 0}, shown.case)));
    if (!ended.has(shown.job.state) && !watched) watch();
    if (!seesSlab) watchSlab();
    conclude().catch(fault => replace(answer, h('p', {class: 'soft'}, fault.message)));
  }
  load().catch(fault => replace(element, faultLine(fault)));
}
