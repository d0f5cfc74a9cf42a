// The secret of a link stands behind '#', which no browser sends: it is used up by the click alone,
// not by a program that opens links of mails.
import {post} from './api.js';

const line = document.getElementById('line'), fault = document.getElementById('fault');
function takeLink() {
  if (location.hash.length < 2) return line.focus();
  line.value = location.hash.slice(1);
  history.replaceState(null, '', location.pathname);
  document.querySelector('button').focus();
}
takeLink();
addEventListener('hashchange', takeLink);  // a link that is opened where this page is
document.getElementById('sign-in').addEventListener('submit', async event => {
  event.preventDefault();
  fault.textContent = '';
  try {
    await post('/session/in', {secret: line.value});
    const page = sessionStorage.getItem('page') ?? '';
    sessionStorage.removeItem('page');
    location.replace(`/${page}`);
  } catch (why) {
    fault.textContent = why.message;
  }
});
