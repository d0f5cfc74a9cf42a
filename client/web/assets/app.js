// Pages by the part of the address behind '#'. A page gets its element and a signal that aborts
// when it is left.
import {get, onReachable, post, repeat, setShared, showSignIn} from './api.js';
import {comparePage} from './compare.js';
import {h, replace} from './dom.js';
import {jobPage} from './job.js';
import {jobsPage} from './jobs.js';
import {linePage, linesPage} from './lines.js';
import {newCasePage} from './new_case.js';
import {sessionsPage} from './sessions.js';
import {studiesPage, studyPage} from './studies.js';
import {castingPage, wallPage} from './wall.js';
import {whatIfPage} from './what_if.js';

const pages = {
  jobs: ['Jobs', jobsPage],
  job: ['Job', jobPage],
  compare: ['Comparison', comparePage],
  studies: ['Studies', studiesPage],
  study: ['Study', studyPage],
  lines: ['Lines', linesPage],
  line: ['Line', linePage],
  casting: ['Casting', castingPage],
  new: ['New case', newCasePage],
  'what-if': ['What-if', whatIfPage],
  wall: ['Wall', wallPage],
  sessions: ['Your sessions', sessionsPage],
};
const main = document.getElementById('main'), status = document.getElementById('server');
let left = new AbortController();

function show() {
  const [, name, ...rest] = (location.hash || '#/jobs').split('/').map(decodeURIComponent);
  const [title, page] = pages[name] || pages.jobs;
  left.abort();
  left = new AbortController();
  document.title = `${title} · dccast`;
  document.body.classList.toggle('wall', name === 'wall' || name === 'casting');
  for (const link of document.querySelectorAll('nav a'))
    link.toggleAttribute('aria-current', link.getAttribute('href') === `#/${name}`);
  const element = h('div', {});
  replace(main, element);
  page(element, left.signal, ...rest);
}

onReachable((reachable, text) => {
  status.classList.toggle('bad', !reachable);
  status.textContent = reachable ? address : text;
});
let address = '', known = '';
// Asked for again, so that a page which asks nothing else shows that the server is away, or is back.
repeat(3000, new AbortController().signal, async () => {
  const server = await get('/server/'), now = JSON.stringify(server);
  if (now === known) return;
  known = now;
  setShared(server.shared);
  address = server.shared ? server.user : server.address;
  document.getElementById('sign-out').hidden = !server.shared;
  status.textContent = address;
  document.body.classList.toggle(
    'viewer', server.role === 'VIEWER');  // hides what the server would refuse
});
document.getElementById('sign-out').addEventListener('click', async () => {
  await post('/session/out');
  showSignIn();
});
// Its fragment would name a page.
document.querySelector('.skip').addEventListener('click', event => {
  event.preventDefault();
  main.focus();
});
addEventListener('hashchange', () => {
  show();
  main.focus({preventScroll: true});
  scrollTo(0, 0);
});
show();
