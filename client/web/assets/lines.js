// Lines: what was cast on each, and what each casting has told. Castings are typed, corrected and
// forgotten here.
import {call, repeat} from './api.js';
import {confirmed} from './cancel.js';
import {caseNames, readCase, withFaults} from './cases.js';
import {ago, attempts, button, field, fixed, h, mm, replace, sheet, shortId, stateText} from './dom.js';

const outcomes = ['SOUND', 'BLED_OUT', 'CRACKED', 'HUNG_UP', 'ABORTED'];
const lineLink = name => h('a', {href: `#/line/${name}`}, name);

/** @param text  "38 41 35 37" @param unit  for the fault */
const numbersOf = (text, unit) => text.split(/\s+/).filter(word => word).map(word => {
  if (!Number.isFinite(Number(word))) throw new Error(`${word}: write a number${unit}`);
  return Number(word);
});
const metresOf = text => numbersOf(text, ', in mm').map(length => length / 1e3);
const inMm = metres => metres === undefined ? '' : mm(metres).replace(/\.0$/, '');
const dayOf = time => time?.slice(0, 10) ?? '';

/** "200 bled out at 40 mm, 60 mm sawn off" */
function outcomeText({outcome, count, at_m: at, sawn_off_m: sawnOff}) {
  const castings = Number(count) > 1 ? `${count} ` : '';
  const words = outcome === 'UNKNOWN' ? '' : stateText(outcome);
  return `${castings}${words}${at === undefined ? '' : ` at ${inMm(at)} mm`}${
    sawnOff === undefined ? '' : `, ${inMm(sawnOff)} mm sawn off`}`;
}

function toldText({ended, curls = [], cold_curl_m: cold = []}) {
  if (!ended) return 'has not ended';
  if (cold.length) return `${cold.map(inMm).join(' ')} mm cold`;
  return curls.filter(({time_s: time}) => time?.length).map(({monitor, time_s: time, curl_m: curl}) =>
    `${monitor} ${mm(curl.at(-1))} mm at ${fixed(time.at(-1), 0)} s`).join(', ') || 'nothing';
}

/**
 * A form for what is typed of castings.
 * @param nameOf  () of the line
 * @param done    called when the server has them
 * @return {element, edit: (record) shows a record to be corrected}
 */
function castingForm(nameOf, done) {
  const {fault, attempt} = attempts(), heading = h('summary', {}, 'Add castings');
  const text = (id, placeholder, type = 'text') => h('input', {id: `casting-${id}`, type, placeholder});
  const recipe = h('select', {id: 'casting-recipe'}), count = text('count', '1'), at = text('at', '40');
  const outcome = h('select', {id: 'casting-outcome'},
    outcomes.map(value => h('option', {value}, stateText(value))));
  const curl = text('curl', '38 41 35 37'), sawnOff = text('sawn-off', '60'), date = text('date', '', 'date');
  const recipeField = field('Recipe: a job, or a case that names no files', recipe);
  let edited = null;

  attempt(async () => {
    const [{jobs}, names] = await Promise.all([call('ListJobs', {page_size: 100}), caseNames()]);
    replace(recipe, jobs.filter(({study}) => !study).map(({id, title}) =>
      h('option', {value: `job ${id}`}, `${title || 'Job'} ${shortId(id)}`)),
    names.map(value => h('option', {value}, value)));
  });

  async function recipeOf(name) {
    if (name.startsWith('job ')) return {job: name.slice(4)};
    const {case: description, attachments} = await readCase(name);
    if (attachments.length) throw new Error('This case names files: queue it, and choose its job.');
    return {case: description};
  }
  const record = () => ({
    outcome: outcome.value, count: numbersOf(count.value || '1', '')[0], at_m: metresOf(at.value)[0],
    cold_curl_m: metresOf(curl.value), sawn_off_m: metresOf(sawnOff.value)[0],
    begin_time: date.value === dayOf(edited?.begin_time) ? edited?.begin_time
      : date.value && `${date.value}T12:00:00Z`
  });

  function show(casting) {
    edited = casting;
    heading.textContent = casting ? `Correct casting ${shortId(casting.id)}` : 'Add castings';
    recipeField.hidden = Boolean(casting);
    outcome.value = outcomes.includes(casting?.outcome) ? casting.outcome : 'SOUND';
    count.value = casting?.count ?? '';
    at.value = inMm(casting?.at_m);
    curl.value = (casting?.cold_curl_m ?? []).map(inMm).join(' ');
    sawnOff.value = inMm(casting?.sawn_off_m);
    date.value = dayOf(casting?.begin_time);
  }
  const send = () => attempt(async () => {
    const id = nameOf();
    await withFaults(edited
      ? call('EditCasting', {id, casting: edited.id, record: record()})
      : call('AddCastings', {
        id, request_id: crypto.randomUUID(), recipes: [await recipeOf(recipe.value)],
        castings: [{recipe: 0, record: record()}]
      }));
    show(null);
    await done(id);
  });

  const element = h('details', {class: 'card levers submitter'}, heading, recipeField,
    h('div', {class: 'levers row'}, field('Outcome', outcome), field('Castings that went alike', count),
      field('Cast length at which it failed, mm', at),
      field('Cold curl by hand, at the points of the plant, mm', curl),
      field('Sawn off the butt, mm', sawnOff), field('Cast on; empty: today', date)),
    h('div', {class: 'bar'}, button('Keep it', send)), fault);
  const edit = casting => {
    show(casting);
    element.open = true;
    element.scrollIntoView();
    outcome.focus();
  };
  return {element, edit};
}

export function linesPage(element, signal) {
  const list = h('div'), name = h('input', {id: 'line-name', type: 'text', placeholder: 'pit-3'});
  const {element: form} = castingForm(() => name.value.trim(), id => { location.hash = `#/line/${id}`; });
  form.firstChild.after(field('Line, which the first casting begins', name));
  replace(element, h('h1', {}, 'Lines'), form, list);
  repeat(5000, signal, async () => {
    const {lines, damaged = []} = await call('ListLines');
    if (signal.aborted) return;
    replace(list,
      damaged.map(each => h('p', {class: 'bad'}, `${each} is damaged: its file is restored from a backup.`)),
      lines.length ? sheet(['Line', 'Owner', 'Castings', 'Since'], lines.map(line => [
        lineLink(line.name), line.owner, {class: 'number', content: `${line.number}`},
        ago(line.restart_time ?? line.create_time)
      ])) : h('p', {class: 'soft'}, 'No lines yet.'));
  });
}

/** @param study  whose answer is given these castings: those that count are marked; undefined: none */
export function linePage(element, signal, name, study) {
  const owner = h('p', {class: 'soft'}), list = h('div'), {fault, attempt} = attempts();
  const {element: form, edit} = castingForm(() => name, () => load());
  let seen = '';

  /** What became of a casting in the answer of the study. @return (id) text */
  async function markOf() {
    const question = {id: study, line: name, with_result: true};
    const {experience} = (await call('JudgeStudy', question)).result;
    const {counted = [], unexplained = []} = experience ?? {};
    return id => {
      if (unexplained.includes(id)) return 'counts, but hardly fits';
      return counted.includes(id) ? 'counts' : 'does not count';
    };
  }

  const asked = (question, details, yes, method, request) => attempt(async () => {
    if (!await confirmed(question, h('p', {}, details), yes, 'Keep them')) return;
    await call(method, {id: name, ...request});
    await load();
  });
  const forget = ({id, title}) =>
    asked(`Forget casting ${shortId(id)}?`, title, 'Forget it', 'ForgetCastings', {castings: [id]});

  async function load() {
    const line = await call('GetLine', {id: name}), now = JSON.stringify(line);
    if (signal.aborted || now === seen) return;
    const mark = study ? await markOf() : null;
    seen = now;
    replace(owner, `Line of ${line.owner}, since ${ago(line.restart_time ?? line.create_time)}`);
    const heads = ['Casting', 'Cast', 'Outcome', 'Measured', 'Recipe', ...(mark ? ['Study'] : []), 'Change'];
    replace(list, (line.castings ?? []).length === 0 ? h('p', {class: 'soft'}, 'No castings.')
      : sheet(heads, line.castings.map(casting => [
        casting.job ? h('a', {href: `#/job/${casting.job}`}, shortId(casting.job)) : casting.id,
        dayOf(casting.begin_time), outcomeText(casting), toldText(casting),
        [casting.title, h('small', {}, ` ${casting.recipe.slice(0, 8)}`)],
        ...(mark ? [mark(casting.id)] : []),
        h('span', {class: 'submitter'},
          button('Correct', () => edit(casting), {'aria-label': `Correct casting ${shortId(casting.id)}`}),
          ' ',
          button('Forget', () => forget(casting),
            {class: 'danger', 'aria-label': `Forget casting ${shortId(casting.id)}`}))
      ])));
  }

  replace(element, h('h1', {}, name), owner,
    study
      ? h('p', {}, 'Marked by what counts in ', h('a', {href: `#/study/${study}`}, 'a study'), '.')
      : null,
    form, list, fault,
    h('div', {class: 'bar submitter'}, button('Begin afresh', () => asked(
      `Begin ${name} afresh?`, 'New mould, new water: no casting so far counts any more.', 'Begin afresh',
      'RestartLine'), {class: 'danger'})));
  repeat(5000, signal, () => attempt(load));
}
