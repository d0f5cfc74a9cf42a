// Curls of some jobs in one picture, and the comparison that dccast compare makes of them.
import {get} from './api.js';
import {chart, curlLines} from './chart.js';
import {h, replace, shortId} from './dom.js';

export async function comparePage(element, signal, ...ids) {
  try {
    const jobs = await Promise.all(ids.map(id => get(`/job/${id}`)));
    if (signal.aborted) return;
    const monitors = [...new Set(jobs.flatMap(job => job.history.monitors.map(m => m.name)))];
    const query = ids.map(id => `job=${encodeURIComponent(id)}`).join('&');
    replace(element, h('h1', {}, `${jobs.length} jobs compared`),
      h('ul', {}, jobs.map(({job}) => h('li', {}, h('a', {href: `#/job/${job.id}`}, job.title || job.id), ` ${shortId(job.id)}`))),
      h('p', {}, h('a', {class: 'button', href: `/compare/?${query}`, target: '_blank', rel: 'noopener'}, 'What differs, what is real, and why')),
      monitors.map(name => h('div', {class: 'card'}, chart(jobs.flatMap(({job, history, relative_curl_error: error}) =>
        curlLines({...history, monitors: history.monitors.filter(m => m.name === name)}, error).map(line => ({...line, name: `${job.title || ''} ${shortId(job.id)}`}))),
      {title: `Curl of ${name}, with the error of mesh and time steps where it is known`, xLabel: 'time, s', yLabel: 'mm'}))));
  } catch (fault) {
    replace(element, h('p', {class: 'bad', role: 'alert'}, fault.message));
  }
}
