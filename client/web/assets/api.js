// What the page asks its server. A server that does not answer is asked again; the page says so
// meanwhile.

const listeners = new Set();
let reachable = true;
export const onReachable = listener => listeners.add(listener);
function setReachable(now, text) {
  if (now === reachable && now) return;
  reachable = now;
  for (const listener of listeners) listener(now, text);
}

async function ask(path, options) {
  let response;
  try {
    response = await fetch(path, options);
  } catch (error) {
    setReachable(false, 'The dashboard has ended; start dccast dashboard again.');
    throw error;
  }
  if (response.ok) {
    setReachable(true, '');
    return response;
  }
  const text = await response.text();
  let fault = text;
  try {
    fault = JSON.parse(text).error;
  } catch { /* plain text */
  }
  setReachable(response.status !== 502 && response.status !== 403, fault);
  throw new Error(fault);
}

export const get = async path => (await ask(path)).json();
export const getText = async path => (await ask(path)).text();
export const getBytes = async path => (await ask(path)).arrayBuffer();
export const post = async path => (await ask(path, {method: 'POST'})).json();
export const postText = async (path, body) => (await ask(path, {method: 'POST', body})).json();
/** A call of the service by its name, as in service.proto. */
export async function call(name, request = {}, options = {}) {
  const init = {method: 'POST', body: JSON.stringify(request), ...options};
  const reply = await (await ask(`/call/${name}`, init)).json();
  if (reply.refused) throw new Error(reply.refused);
  return reply;
}

/**
 * Calls `take` with every event until `signal` aborts. Ends by itself at a fault, which goes to
 * `fail`.
 */
export function events(path, signal, take, fail = () => {}) {
  const source = new EventSource(path);
  const close = () => source.close();
  signal.addEventListener('abort', close);
  source.onmessage = event => take(JSON.parse(event.data), close);
  source.addEventListener('fault', event => {
    close();
    fail(JSON.parse(event.data).error);
  });
  return close;
}

/**
 * Calls `work` now and every so many milliseconds while the page is seen, until `signal` aborts.
 */
export function repeat(milliseconds, signal, work) {
  let timer;
  const turn = async () => {
    if (!document.hidden) await work().catch(() => {});
    if (!signal.aborted) timer = setTimeout(turn, milliseconds);
  };
  signal.addEventListener('abort', () => clearTimeout(timer));
  turn();
}
