// Cases as a page holds them: files named when the dashboard was started, texts that were opened or
// made on a page, and built-in ones.
import {call, get, post, stream, upload} from './api.js';
import {shortId} from './dom.js';
import {addStep} from './history.js';

const opened = new Map();  // {text, attachments} by name, until the page is closed
let known;
const knownCases = () => known ??= get('/cases/');

/**
 * Keeps a case under a name and opens a page that takes it.
 * @param page  'new', 'what-if' or 'studies'
 */
export function goOn(page, name, {text, attachments}) {
  const own = `page: ${name}`;
  opened.delete(own);
  opened.set(own, {text, attachments});
  location.hash = `#/${page}/${encodeURIComponent(own)}`;
}

/** The same with the case of a job, whose files the server has. */
export async function goOnWithJob(page, id) {
  const {job, case: text, attachments} = await get(`/job/${id}`);
  goOn(page, job.title || shortId(id), {text, attachments});
}

/** Names of all cases: those of one's own first, the newest at the front. */
export async function caseNames() {
  const {given, shipped} = await knownCases();
  return [...given.map(({name}) => name), ...[...opened.keys()].reverse(), ...shipped];
}

async function sourceOf(name) {
  const {given} = await knownCases();
  return opened.get(name) ?? given.find(file => file.name === name) ?? {shipped: name};
}

const faultText = ({field, value, message, permitted, remedy}, line) =>
  [line ? `line ${line}: ${field || 'the text'}` : field,
    [value, message].filter(text => text).join(': '),
    permitted && `permitted: ${permitted}`, remedy].filter(text => text).join('; ');

function refuse(faults, lines = []) {
  if (faults.length)
    throw new Error(faults.map((fault, i) => faultText(fault, lines[i])).join('\n'));
}

/** Faults that a refused call names, else its message. */
function named(refusal) {
  refuse((refusal.details || []).flatMap(({debug}) => debug?.faults || []));
  throw refusal;
}

/** The answer of a call. Rejects with the faults that answer or refusal name. */
export async function withFaults(asked) {
  const answer = await asked.catch(named);
  refuse(answer.faults || []);
  return answer;
}

/** @param files  of the browser, among which are those that the case names */
async function read(source, {attachments = [], changes = [], files = []} = {}) {
  const answer = await call('ReadCase', {...source, changes});
  refuse(answer.faults, answer.lines);
  if (attachments.length) return {...answer, attachments, changes};

  const wanted = answer.files.map(path => path.split(/[/\\]/).at(-1));
  const found = wanted.map(name => files.find(file => file.name === name));
  const missing = wanted.filter((name, i) => !found[i]);
  if (missing.length)
    throw new Error(`the case names ${missing.join(', ')}: choose these files together with it`);
  return {...answer, attachments: await Promise.all(found.map(upload)), changes};
}

/** "KEY=VALUE" as CaseChange. */
function changeOf(text) {
  const at = text.indexOf('=');
  if (at < 1) throw new Error(`${text}: write KEY=VALUE`);
  return {key: text.slice(0, at).trim(), value: text.slice(at + 1).trim()};
}

/**
 * Reads a case by its name, with changes "KEY=VALUE".
 * @return the answer of ReadCase with attachments and changes; rejects with its faults
 */
export async function readCase(name, changes = []) {
  const {text, shipped, attachments} = await sourceOf(name);
  return read(shipped ? {shipped} : {text}, {attachments, changes: changes.map(changeOf)});
}
/** The same of a text that was opened. @param files  of the browser, which it may name */
export const readText = (text, files) => read({text}, {files});
/** The start of a slab by a few figures: {size, alloy, speed, water}. */
export const readSlab = slab => read({slab});

/** Has the server check a case. @return its answer; rejects with the faults */
export function checkCase({case: description, attachments}) {
  return withFaults(call('ValidateCase', {case: description, attachments}));
}

/** The text of a case with its changes. */
export const textOf = async ({case: description}) => (await call('ReadCase', {case: description})).text;

/** What requests have of a case that was read. */
const parts = ({case: description, attachments, changes}) => ({case: description, attachments, changes});

/**
 * Begins a study of a case that was read. @return it
 * @param limits  of a recipe, as texts; undefined: the plan is complete
 */
export function beginStudy(made, {limits, ...plan}) {
  const request = {...parts(made), ...plan};
  const begun = limits ? post(`/recipe?${new URLSearchParams(limits)}`, request)
    : call('CreateStudy', {request_id: crypto.randomUUID(), ...request});
  return withFaults(begun);
}

/** What the forecast of a casting would rest on, which is begun where it is not there. */
export const prepareCasting = made => withFaults(call('PrepareCasting', parts(made)));

/**
 * Submits a case that was read; once more, it is the same job. @return the job
 * @param waits  {after: ids of jobs, after_end}
 */
export function submitCase(made, waits = {}) {
  made.requestId ??= crypto.randomUUID();  // whose answer a lost connection may take
  const bytes = new TextEncoder().encode(made.text);
  const file = btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join(''));
  return withFaults(
    call('SubmitJob', {request_id: made.requestId, ...parts(made), ...waits, case_file: file}));
}

/**
 * Computes a case. @param look  called some ten times a second with {waiting} or {steps, progress}
 * @return {steps, findings, wanted, failure, job, key}
 */
export async function computeCase(made, signal, look) {
  const answer = {steps: [], findings: []};
  let shown = performance.now(), ended = null;
  const take = event => {
    if (event.accepted) {
      answer.wanted = event.accepted.case.plausibility;
      answer.job = event.accepted.job;
      answer.key = event.accepted.answer;
    }
    if (event.waiting) look({waiting: event.waiting});
    if (event.finding)
      answer.findings =
        [...answer.findings.filter(f => f.code !== event.finding.code), event.finding];
    if (event.ended) ended = event.ended;
    if (!event.step) return;
    addStep(answer.steps, event.step);
    if (performance.now() - shown < 100) return;
    shown = performance.now();
    look({steps: answer.steps, progress: event.step.progress});
  };
  await stream('QueryButtCurl', parts(made), signal, take).catch(named);
  if (!ended) throw new Error('The server ended the answer before its end; ask again.');
  return {...answer, failure: ended.failure};
}
