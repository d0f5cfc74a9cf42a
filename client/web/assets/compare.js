// Jobs compared as dccast compare does: what differs, whether it is real, and what differed before it.
import {callDrawn} from './api.js';
import {faultLine, findingList, h, replace, shortId} from './dom.js';
import {judgement} from './drawn.js';
import {frameViewer} from './frame.js';
import {framesOf} from './job.js';

const runItem = run => h('li', {},
  h('a', {href: `#/job/${run.job}`}, run.title || run.job), ` ${shortId(run.job)}`,
  run.findings.length ? findingList(run.findings) : null);

const mostSlabs = 4;  // a browser draws few in 3D at once

export async function comparePage(element, signal, ...ids) {
  const slabs = h('div', {class: 'pair'});
  try {
    const {runs, judgement: found} = await callDrawn('CompareRuns', {runs: ids.map(id => ({job: id}))});
    if (signal.aborted) return;
    const query = ids.map(id => `job=${encodeURIComponent(id)}`).join('&');
    const page = {class: 'button', href: `/compare/?${query}`, target: '_blank', rel: 'noopener'};
    replace(element,
      h('h1', {}, `${runs.length} jobs compared`),
      h('ol', {}, runs.map(runItem)),
      h('p', {}, h('a', page, 'As a page to keep')),
      h('div', {class: 'card'}, h('h2', {}, 'Differences from the first job'), judgement(found)), slabs);
    const beside = {};
    for (const {job, title} of runs.slice(0, mostSlabs)) {
      const card = h('div', {class: 'card'});
      slabs.append(card);
      await frameViewer(card, signal, framesOf(job), title || shortId(job), beside)
        .then(() => { card.firstChild.textContent = `Slab of ${shortId(job)}`; }, () => card.remove());
    }
  } catch (fault) {
    replace(element, faultLine(fault));
  }
}
