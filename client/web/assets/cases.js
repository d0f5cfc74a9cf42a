// Cases as a page holds them: files named when the dashboard was started, texts that were opened or
// made on a page, and built-in ones.
import {call, get, stream, upload} from './api.js';
import {addStep} from './history.js';

const opened = new Map();  // {text, attachments} by name, until the page is closed
let known;
const knownCases = () => known ??= get('/cases/');

/** Keeps a case that was read. @return the name by which it is found */
export function keepCase(name, {text, attachments}) {
  const own = `page: ${name}`;
  opened.delete(own);
  opened.set(own, {text, attachments});
  return own;
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
export async function checkCase({case: description, attachments}) {
  const verdict = await call('ValidateCase', {case: description, attachments});
  refuse(verdict.faults);
  return verdict;
}

/** The text of a case with its changes. */
export const textOf = async ({case: description}) => (await call('ReadCase', {case: description})).text;

/** Begins a study of a case that was read. @return it */
export function beginStudy({case: description, attachments, changes}, plan) {
  const request = {request_id: crypto.randomUUID(), case: description, attachments, changes, ...plan};
  return call('CreateStudy', request).catch(named);
}

/** Submits a case that was read; once more, it is the same job. @return the job */
export function submitCase(made) {
  const {case: description, attachments, changes, text} = made;
  made.requestId ??= crypto.randomUUID();  // whose answer a lost connection may take
  const bytes = new TextEncoder().encode(text);
  const file = btoa(Array.from(bytes, byte => String.fromCharCode(byte)).join(''));
  return call('SubmitJob', {
    request_id: made.requestId, case: description, attachments, changes, case_file: file
  }).catch(named);
}

/**
 * Computes a case. @param look  called some ten times a second with {waiting} or {steps, progress}
 * @return {steps, findings, wanted, failure, job, key}
 */
export async function computeCase({case: description, attachments, changes}, signal, look) {
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
  await stream('QueryButtCurl', {case: description, attachments, changes}, signal, take)
    .catch(named);
  if (!ended) throw new Error('The server ended the answer before its end; ask again.');
  return {...answer, failure: ended.failure};
}
