// A new case: a file that is uploaded, the start of a slab by a few figures, as dccast new --slab has
// it, or a case that another page has given a name.
import {call} from './api.js';
import {castingDrawing} from './casting.js';
import {
  checkCase, goOn, prepareCasting, readCase, readSlab, readText, submitCase
} from './cases.js';
import {
  attempts, button, durationText, faultLine, field, findingList, h, replace, shortId, stateText
} from './dom.js';
import {fileName, saveBlob} from './save.js';

const figures = {
  slab: ['Slab, width x thickness', '1320x570mm'],
  speed: ['Casting speed, start..steady', '40..60mm/min'],
  water: ['Water, in all (m3/h) or per metre of perimeter (l/min/m)', '90..180l/min/m'],
};

/** A choice of a job to wait for. @return {element, waits: () of submitCase()} */
function awaited() {
  const job = h('select', {id: 'after'}, h('option', {value: ''}, 'no other job'));
  const end = h('select', {id: 'after-end'}, ['SUCCESS', 'FAILURE', 'ANY_END'].map(
    name => h('option', {value: `AWAITED_${name}`}, `its ${stateText(name).replace('any ', '')}`)));
  call('ListJobs', {page_size: 100, states: ['QUEUED', 'RUNNING', 'PAUSED']}).then(
    ({jobs}) => job.append(...jobs.map(({id, title, state}) =>
      h('option', {value: id}, `${title || 'Job'} ${shortId(id)}, ${stateText(state)}`))), () => {});
  return {
    element: [field('Wait for', job), field('until', end)],
    waits: () => job.value ? {after: [job.value], after_end: end.value} : {}
  };
}

/** @param wanted  name of a case that another page has kept; undefined: none */
export function newCasePage(element, signal, wanted) {
  const {fault, attempt} = attempts(), shown = h('div', {'aria-live': 'polite'});
  const found = h('div', {id: 'found'}, fault, shown);

  /** Shows a case that was read, its cost and its drawing, with buttons that go on with it. */
  function present(name, made) {
    const judged = h('div', {role: 'status'}), said = h('p', {role: 'status'});
    const {element: wait, waits} = awaited();
    checkCase(made).then(({estimate, findings}) => replace(judged,
      h('p', {class: 'soft'}, `About ${durationText(estimate.solver_s)} of one processor, ${
        estimate.nodes} nodes, ${estimate.steps} steps.`),
      findings.length ? findingList(findings) : null
    ), fault => replace(judged, faultLine(fault)));

    const act = (text, work) => button(text, () => attempt(async () => {
      await checkCase(made);
      await work();
    }));
    const studyLink = (text, study) => study ? ['; ', h('a', {href: `#/study/${study.id}`}, text)] : [];
    const prepare = async () => {
      const {ensemble, pairs, levers, plan_job: job, ready} = await prepareCasting(made);
      replace(said, ready ? 'Prepared' : 'Being prepared', ': ', h('a', {href: `#/job/${job}`}, 'plan'),
        studyLink('ensemble', ensemble), studyLink('pairs', pairs), studyLink('levers', levers),
        '. The machine that has the readings begins: dccast follow, with this case.');
    };
    const save = () => saveBlob(`${fileName(name.replace('.toml', ''))}.toml`,
      new Blob([made.text], {type: 'text/plain'}));
    const queue = async () => {
      const {id} = await submitCase(made, waits());
      replace(said, 'Queued as ', h('a', {href: `#/job/${id}`}, id));
    };
    replace(fault);
    replace(shown, h('div', {class: 'card'}, h('p', {}, made.summary), judged,
      castingDrawing({case: made.complete, charts: made.charts}),
      h('div', {class: 'bar'},
        act('What-if with it', () => goOn('what-if', name, made)),
        act('Queue as a job', queue), button('Save the file', save),
        act('Study of it', () => goOn('studies', name, made)), act('Prepare to follow it', prepare)),
      h('div', {class: 'bar'}, wait), said));
  }

  let asked = 0;
  /** Shows what `read` reads, unless a later question has been asked. */
  const ask = (name, read) => attempt(async () => {
    const mine = ++asked;
    try {
      const made = await read();
      if (mine === asked && !signal.aborted) present(name, made);
    } catch (why) {
      if (mine !== asked) return;
      replace(shown);
      throw why;
    }
  });

  async function open(files) {
    // A card is TOML, too.
    const texts = await Promise.all(files.map(each => each.name.endsWith('.toml') ? each.text() : ''));
    const at = Math.max(0, texts.findIndex(text => /^\[section\]/m.test(text)));
    if (files.length) ask(files[at].name, () => readText(texts[at], files));
  }

  // ---- By a form

  const draft = () => {
    const [size, speed, water] = boxes.map(box => box.value);
    return ask(`slab-${size}.toml`, () => readSlab({size, speed, water, alloy: alloy.value}));
  };
  const alloy = h('select', {id: 'new-alloy', onchange: draft});
  const boxes = Object.entries(figures).map(
    ([key, [, value]]) => h('input', {type: 'text', id: `new-${key}`, value, onchange: draft}));
  const file = h('input', {
    type: 'file', id: 'new-file', multiple: true, onchange: () => open([...file.files])
  });
  replace(
    element, h('h1', {}, 'New case'),
    h('div', {class: 'pair'},
      h('div', {class: 'card levers'}, h('h2', {}, 'A slab by a few figures'),
        Object.values(figures).map(([name], i) => field(name, boxes[i])), field('Alloy', alloy),
        h('div', {class: 'bar'}, button('Draw it', draft))),
      h('div', {class: 'card'}, h('h2', {}, 'A case file of your own'), field('File', file),
        h('p', {class: 'soft'},
          'The server checks it. Choose the files that it names, such as a mesh or a card, with it.'))),
    found);
  if (wanted) ask(wanted, () => readCase(wanted));
  call('ListAlloys').then(({alloys}) => {
    replace(alloy, alloys.map(({card}) => h('option', {selected: card === 'aa5182'}, card)));
    if (!wanted) draft();
  }, ({message}) => replace(fault, message));
}
