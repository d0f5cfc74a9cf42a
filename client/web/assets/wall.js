// One line for a screen on the wall: what runs now, large enough to be read across the hall.
import {call, get, repeat} from './api.js';
import {chart, curlLines, wantedBand} from './chart.js';
import {
  byGravity, curlText, findingList, h, replace, severityText, stateText, worst
} from './dom.js';
import {largestMonitor} from './jobs.js';

/** The gravest finding, with its remedy where it names one, in one line. */
function worstLine(findings) {
  const [gravest, ...others] = byGravity(findings);
  if (!gravest) return h('p', {class: 'verdict soft'}, 'No findings.');
  const severity = severityText[worst([gravest])], remedy = gravest.remedy;
  return h(
    'p', {class: 'verdict'}, h('span', {class: `tag ${severity}`}, severity),
    ` ${gravest.message || gravest.code}`, remedy ? h('strong', {}, ` ${remedy}`) : null,
    others.length ? h('small', {}, ` and ${others.length} more`) : null);
}

export function wallPage(element, signal, label) {
  repeat(2000, signal, async () => {
    const filter = label ? {labels: [label]} : {};
    const running = (await call('ListJobs', {page_size: 1, states: ['RUNNING'], ...filter})).jobs;
    const jobs =
      running.length ? running : (await call('ListJobs', {page_size: 1, ...filter})).jobs;
    if (jobs.length === 0)
      return replace(element, h('h1', {}, label ? `No job with label ${label}` : 'No job yet'));
    const {job, history, wanted} = await get(`/job/${jobs[0].id}`);
    if (signal.aborted) return;

    const findings = (job.findings || []).filter(f => f.severity !== 'NOTE'), last = largestMonitor(job);
    replace(
      element, h('h1', {}, job.title || job.id),
      h('div', {class: 'headline'},
        h('p', {class: 'huge'},
          last ? curlText(last.curl_m, last.curl_lower_error_m, last.curl_upper_error_m) : '–'),
        worstLine(findings)),
      h('p', {}, h('span', {class: `state ${job.state.toLowerCase()}`}, stateText(job.state)),
        job.last_step?.time_s ? ` at ${job.last_step.time_s.toFixed(0)} s` : ''),
      history.time_s.length
        ? chart(
            curlLines(history),
            {title: 'Curl', xLabel: 'time, s', yLabel: 'mm', wanted: wantedBand(wanted)})
        : null,
      findings.length > 1 ? findingList(findings) : null);
  });
}
