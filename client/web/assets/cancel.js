// Cancelling jobs: it is asked for, and for some seconds it can be undone. The server cannot undo
// it, so it hears of it only then.
import {call} from './api.js';
import {button, h} from './dom.js';

const seconds = 8;

/** Asks in a dialog. @return whether the answer was yes */
export function confirmed(question, details, yes, no) {
  return new Promise(resolve => {
    const close = answer => () => {
      dialog.close();
      dialog.remove();
      resolve(answer);
    };
    const dialog =
      h('dialog', {'aria-label': question, oncancel: close(false)}, h('h2', {}, question), details,
        h('div', {class: 'bar'},
          button(yes, close(true), {class: 'danger'}), button(no, close(false), {autofocus: true})));
    document.body.append(dialog);
    dialog.showModal();
  });
}

/**
 * Does `act` after some seconds, at once when the page is left, and not at all when it is undone.
 */
function actUnlessUndone(text, act, undone) {
  const left = h('output');
  const note =
    h('div', {class: 'pending'}, text, left,
      button('Undo', () => end(undone)));

  let remaining = seconds;
  const show = () => {
    left.textContent = ` in ${remaining} s`;
  };
  const timer = setInterval(() => {
    remaining--;
    if (remaining <= 0) end(act);
    else show();
  }, 1000);

  const leave = () => end(act);
  function end(what) {
    clearInterval(timer);
    removeEventListener('pagehide', leave);
    note.remove();
    what();
  }

  addEventListener('pagehide', leave);
  show();
  document.getElementById('pending').append(note);
}

function namesOf(jobs) {
  const most = 5;
  const items = jobs.slice(0, most).map(job => h('li', {}, job.title || job.id));
  if (jobs.length > most) items.push(h('li', {}, `and ${jobs.length - most} more`));
  return h('ul', {}, items);
}

/**
 * Cancels jobs after a confirmation, unless it is undone.
 * @param jobs     [{id, title}]
 * @param options  {done: called with a fault's text or '' when the server has answered, undone}
 * @return whether they are going to be cancelled
 */
export async function cancelJobs(jobs, {done = () => {}, undone = () => {}} = {}) {
  const what = jobs.length === 1 ? 'this job' : `${jobs.length} jobs`;
  const details = [
    namesOf(jobs),
    h('p', {class: 'soft'},
      'A cancelled job cannot be continued. To go on later, pause it instead.')
  ];
  if (!await confirmed(`Cancel ${what}?`, details, `Cancel ${what}`, 'Keep running')) return false;

  actUnlessUndone(`Cancelling ${jobs.length === 1 ? jobs[0].title || 'a job' : what}`, async () => {
    // The browser sends these even while the page goes away.
    const asked = jobs.map(job => call('CancelJob', {id: job.id}, {keepalive: true}));
    const answers = await Promise.allSettled(asked);
    done(answers.filter(a => a.reason).map(a => a.reason.message).join('; '));
  }, undone);
  return true;
}
