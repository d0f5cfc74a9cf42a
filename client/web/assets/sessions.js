// Where one is signed in: sessions of browsers and logins of machines. Ends one, and makes a link for
// one more.
import {call, post, repeat, shared, showSignIn} from './api.js';
import {confirmed} from './cancel.js';
import {copyBox} from './copy_box.js';
import {ago, attempts, button, h, replace, sheet} from './dom.js';

const nameOf = ({name, is_secret: isSecret}) => {
  if (isSecret) return 'Link that was not used yet';
  return name === 'web' ? 'Browser' : name || 'A login without a name';
};
const lastUse = ({last_use_time: time, last_use_address: address}) =>
  time ? `${ago(time)}, from ${address}` : 'not since the server was started';
// The cookie of a browser ends long before its token.
const endOf = ({name, is_secret: isSecret, expire_time: time}) =>
  name === 'web' && !isSecret ? '12 h without use, 30 days' : dateText(time);
const dateText = time => new Date(time).toLocaleString();

export function sessionsPage(element, signal) {
  const list = h('div'), made = h('div', {role: 'status'}), {fault, attempt} = attempts();

  async function makeLink() {
    const line = await call('IssueSignIn');
    const link = shared ? `${location.origin}/sign-in.html#${line.secret}` : line.link;
    if (!link) throw new Error('This server names no address for browsers: access.web_address.');
    replace(
      made, copyBox('Open it in the other browser', link),
      h('p', {class: 'soft'},
        `It signs in as you, once, until ${new Date(line.expire_time).toLocaleTimeString()}.`));
    await load();
  }

  async function end(token) {
    const details = h('p', {}, `${nameOf(token)}, used ${lastUse(token)}.`);
    if (!await confirmed('End it?', details, 'End it', 'Keep it')) return;
    if (token.is_of_this_call && shared) {
      await post('/session/out');
      return showSignIn();
    }
    await call('RevokeToken', {id: token.id});
    await load();
  }

  let seen = '';
  async function load() {
    const {tokens} = await call('ListTokens');
    if (signal.aborted || JSON.stringify(tokens) === seen) return;
    seen = JSON.stringify(tokens);
    replace(list, tokens.length === 0
      ? h('p', {}, 'None: you work on the machine of the server, which knows you.')
      : sheet(['Where', 'Made', 'Last used', 'Until', 'End'], [...tokens].reverse().map(token => [
        [nameOf(token), token.is_of_this_call ? h('strong', {}, ', this one') : null],
        dateText(token.create_time), lastUse(token), endOf(token),
        button('End', () => attempt(() => end(token)),
          {class: 'danger', 'aria-label': `End ${nameOf(token)}`})
      ])));
  }

  replace(
    element, h('h1', {}, 'Your sessions'),
    h('p', {}, 'Browsers and machines that are signed in as you. End one that you do not know.'),
    h('div', {class: 'bar'},
      button('Sign in another browser', () => attempt(makeLink))),
    made, fault, list);
  repeat(5000, signal, () => attempt(load));
}
