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

/** Whether the server of this page serves several users, who sign in and out. */
export let shared = false;
export const setShared = now => { shared = now; };
export function showSignIn() {
  sessionStorage.setItem('page', location.hash);
  location.assign('/sign-in.html');
}

/** A refusal of the service or of the dashboard. @return an Error, with the code of the service */
const failure = ({code, message, error, details}) =>
  Object.assign(new Error(message ?? error), {code, details});

async function ask(path, options) {
  let response;
  try {
    response = await fetch(path, options);
  } catch (error) {
    if (!options?.signal?.aborted)
      setReachable(false, shared ? 'No answer from the server; trying again.'
        : 'The dashboard has ended; start dccast dashboard again.');
    throw error;
  }
  if (response.ok) {
    setReachable(true, '');
    return response;
  }
  if (response.status === 401 && (shared || path === '/server/')) showSignIn();
  const text = await response.text();
  let fault = new Error(text);
  try {
    fault = failure(JSON.parse(text));
  } catch { /* plain text */
  }
  const isCut = fault.code ? fault.code === 'unavailable' : [502, 403].includes(response.status);
  setReachable(!isCut, fault.message);
  throw fault;
}

// Where JSON of protobuf differs from what a page counts with.
const wholeNumbers = new Set(['step', 'last_step', 'sequence', 'number', 'nodes', 'elements']);
const numbers = new Set(['NaN', 'Infinity', '-Infinity']);
const isNumber = (key, value) =>
  typeof value === 'string' && (numbers.has(value) || wholeNumbers.has(key));
/** A request as protobuf reads it, with its NaN. */
const written = request => JSON.stringify(
  request,
  (key, value) => typeof value === 'number' && !Number.isFinite(value) ? String(value) : value);
const parse =
  text => JSON.parse(text, (key, value) => isNumber(key, value) ? Number(value) : value);

export const get = async path => (await ask(path)).json();
export const getBytes = async path => (await ask(path)).arrayBuffer();

const posted = (type, body, {accept = '*/*', ...options} = {}) =>
  ({method: 'POST', headers: {'Content-Type': type, Accept: accept}, body, ...options});
const method = name => `/dccast.v1.SimulationService/${name}`;

export const post = async (path, body = {}) =>
  (await ask(path, posted('application/json', JSON.stringify(body)))).json();

export const put = async (path, body) => (await ask(path, {method: 'PUT', body})).json();

/** Brings a file of the browser to the server. @return it as an Attachment */
export async function upload(file) {
  const digest = new Uint8Array(await crypto.subtle.digest('SHA-256', await file.arrayBuffer()));
  const sha256 = Array.from(digest, byte => byte.toString(16).padStart(2, '0')).join('');
  const path = `/attachments/${sha256}?name=${encodeURIComponent(file.name)}`;
  await put(path, file);
  return {name: file.name, sha256, size_bytes: file.size};
}

/** A call of the service by its name, as in service.proto. */
export async function call(name, request = {}, options = {}) {
  const init = posted('application/json', written(request), options);
  return parse(await (await ask(method(name), init)).text());
}
/** The same, with the parts of the judgement in its response as HTML. */
export const callDrawn = (name, request) =>
  call(name, request, {accept: 'application/json; judgement=html'});

/**
 * A call whose response is a stream: `take` gets each message until the stream ends or `signal`
 * aborts. Rejects at a fault. @param most  of its duration [ms]; undefined: no bound
 */
export async function stream(name, request, signal, take, most) {
  const prefix = 5;  // flags and length before each message
  const body = new TextEncoder().encode('\0'.repeat(prefix) + written(request));
  new DataView(body.buffer).setUint32(1, body.length - prefix);
  const init = posted('application/connect+json', body, {signal});
  if (most) init.headers['Connect-Timeout-Ms'] = most;
  const reader = (await ask(method(name), init)).body.getReader();

  for (let rest = new Uint8Array(); ;) {
    const {done, value} = await reader.read();
    if (done) throw new Error('The connection was lost.');
    const all = new Uint8Array(rest.length + value.length);
    all.set(rest);
    all.set(value, rest.length);
    rest = all;
    while (rest.length >= prefix) {
      const end = prefix + new DataView(rest.buffer, rest.byteOffset).getUint32(1);
      if (rest.length < end) break;
      const message = parse(new TextDecoder().decode(rest.subarray(prefix, end)));
      const isLast = rest[0] & 2;
      rest = rest.subarray(end);
      if (!isLast) take(message);
      else if (message.error) throw failure(message.error);
      else return;
    }
  }
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
