// One line for a screen on the wall: what runs now, large enough to be read across the hall.
import {call, get, repeat} from './api.js';
import {chart, wantedBand} from './chart.js';
import {curlOf, curlParts, findingList, gravestFinding, h, purpose, replace, stateText} from './dom.js';
import {followedWall} from './followed.js';
import {curlLines, judgedMonitor} from './history.js';

/** A job for the wall: a running one, if possible one that follows a casting; else the newest. */
async function findJob(label) {
  const filter = label ? {labels: [label]} : {};
  const running = (await call('ListJobs', {page_size: 100, states: ['RUNNING'], ...filter})).jobs;
  if (running.length) return running.find(job => job.casting) || running[0];
  return (await call('ListJobs', {page_size: 1, ...filter})).jobs[0];
}

/** The curl that is judged in the largest letters, its error below it; of a run without one its state. */
function curlFigure(job) {
  const judged = judgedMonitor(job);
  if (!judged) return h('p', {class: 'huge'}, stateText(job.state));
  const {curl, error} = curlParts(...curlOf(judged));
  return h('div', {}, h('p', {class: 'huge'}, curl, h('small', {}, ' mm')),
    h('p', {class: 'beside'}, judged.name, error ? `, ${error} mm` : ''));
}

function drawRun(element, {job, steps, wanted}) {
  const findings = (job.findings || []).filter(f => f.severity !== 'NOTE');
  replace(
    element, h('h1', {}, job.title || job.id),
    h('div', {class: 'headline'}, curlFigure(job), gravestFinding(findings)),
    h('p', {}, h('span', {class: `state ${job.state.toLowerCase()}`}, stateText(job.state)),
      job.last_step?.time_s ? ` at ${job.last_step.time_s.toFixed(0)} s` : ''),
    steps.length
      ? chart(
          curlLines(steps),
          {title: 'Curl', xLabel: 'time, s', yLabel: 'mm', wanted: wantedBand(wanted)})
      : null,
    findings.length > 1 ? findingList(findings) : null, purpose());
}

/** The forecast of a job, or why there is none. */
const forecastOf = id => call('ForecastJob', {id}).then(
  forecast => ({forecast}), fault => ({noForecast: fault.message}));

/**
 * @param chosen   () id of the job to show; undefined: there is none
 * @param nothing  what is shown then
 */
function screen(element, signal, chosen, nothing) {
  // The casting that is shown: draws its new state, and ends its page.
  let drawCasting = null;
  let shown = null;
  function leaveCasting() {
    shown?.abort();
    drawCasting = null;
    element.classList.remove('stale');
  }
  signal.addEventListener('abort', leaveCasting);

  repeat(2000, signal, async () => {
    const asked = performance.now(), job = await chosen();
    if (!job) return replace(element, h('h1', {}, nothing));
    const seen = await get(`/job/${job}`);
    const forecast = seen.job.casting ? await forecastOf(seen.job.id) : {};
    if (signal.aborted) return;

    if (!seen.job.casting) {
      leaveCasting();
      return drawRun(element, seen);
    }
    if (!drawCasting) {
      shown = new AbortController();
      drawCasting = followedWall(element, shown.signal);
    }
    drawCasting({...seen, ...forecast, asked});
  });
}

/** @param label  of the jobs among which one is shown; undefined: all */
export const wallPage = (element, signal, label) => screen(
  element, signal, async () => (await findJob(label))?.id,
  label ? `No job with label ${label}` : 'No job yet');

/** One casting that is followed. */
export const castingPage = (element, signal, job) => screen(element, signal, async () => job);
