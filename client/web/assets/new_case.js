// A new case: a file that is uploaded, or the start of a slab by a few figures, as dccast new
// --slab has it.
import {call} from './api.js';
import {castingDrawing} from './casting.js';
import {checkCase, keepCase, readSlab, readText, submitCase} from './cases.js';
import {durationText, findingList, h, replace} from './dom.js';
import {fileName, saveBlob} from './save.js';

const fields = [
  {key: 'slab', name: 'Slab, width x thickness', usual: '1320x570mm'},
  {key: 'speed', name: 'Casting speed, start..steady', usual: '40..60mm/min'},
  {
    key: 'water',
    name: 'Water, in all (m3/h) or per metre of perimeter (l/min/m)',
    usual: '90..180l/min/m'
  },
];

export function newCasePage(element, signal) {
  const found = h('div', {id: 'found', 'aria-live': 'polite'});
  const button = (text, act) => h('button', {type: 'button', onclick: act}, text);
  const complain = text =>
    replace(found, h('div', {class: 'card'}, h('p', {class: 'bad lines', role: 'alert'}, text)));

  /** What a case casts, with its drawing. @param acts  buttons */
  function show({summary, complete, charts}, judged, acts) {
    const said = h('p', {role: 'status'});
    replace(
      found,
      h('div', {class: 'card'}, h('p', {}, summary), judged,
        castingDrawing({case: complete, charts}),
        h('div', {class: 'bar'}, acts(said)), said));
  }

  /** Shows a case that was read, with buttons that go on with it. @param more  further ones */
  function present(name, made, more = []) {
    const follow = act => async () => {
      try {
        await checkCase(made);
        await act();
      } catch (fault) { complain(fault.message); }
    };
    const judged = h('div', {role: 'status'});
    checkCase(made).then(({estimate, findings}) => replace(judged,
      h('p', {class: 'soft'}, `About ${durationText(estimate.solver_s)} of one processor, ${
        estimate.nodes} nodes, ${estimate.steps} steps.`),
      findings.length ? findingList(findings) : null
    ), ({message}) => replace(judged, h('p', {class: 'bad lines', role: 'alert'}, message)));
    show(made, judged, said => [
      button('What-if with it', follow(() => {
        location.hash = `#/what-if/${encodeURIComponent(keepCase(name, made))}`;
      })),
      button('Queue as a job', follow(async () => {
        const {id} = await submitCase(made);
        replace(said, 'Queued as ', h('a', {href: `#/job/${id}`}, id));
      })),
      ...more
    ]);
  }

  async function open(files) {
    // A card is TOML, too.
    const texts = await Promise.all(files.map(each => each.name.endsWith('.toml') ? each.text() : ''));
    const at = Math.max(0, texts.findIndex(text => /^\[section\]/m.test(text))), file = files[at];
    if (!file) return;
    try {
      const made = await readText(texts[at], files);
      await checkCase(made);
      if (!signal.aborted) present(file.name, made);
    } catch (fault) { complain(fault.message); }
  }

  // ---- By a form

  const alloy = h('select', {id: 'new-alloy', onchange: () => draft()});
  const boxes = fields.map(
    field =>
      h('input',
        {type: 'text', id: `new-${field.key}`, value: field.usual, onchange: () => draft()}));
  let asked = 0;
  async function draft() {
    const mine = ++asked, [size, speed, water] = boxes.map(box => box.value);
    try {
      const made = await readSlab({size, speed, water, alloy: alloy.value});
      if (mine !== asked || signal.aborted) return;
      const name = `slab-${size}.toml`;
      const save = () => saveBlob(
        `${fileName(name.replace('.toml', ''))}.toml`, new Blob([made.text], {type: 'text/plain'}));
      present(name, made, [button('Save the file', save)]);
    } catch (fault) {
      if (mine === asked) complain(fault.message);
    }
  }

  const file = h('input', {
    type: 'file',
    id: 'new-file',
    multiple: true,
    onchange: () => open([...file.files])
  });
  replace(
    element, h('h1', {}, 'New case'),
    h('div', {class: 'pair'},
      h('div', {class: 'card levers'}, h('h2', {}, 'A slab by a few figures'),
        h('label',
          {for: 'new-slab'
          },
          fields[0].name, boxes[0]),
        h('label',
          {for: 'new-alloy'
          },
          'Alloy', alloy),
        h('label',
          {for: 'new-speed'
          },
          fields[1].name, boxes[1]),
        h('label',
          {for: 'new-water'
          },
          fields[2].name, boxes[2]),
        h('div', {class: 'bar'},
          button('Draw it', draft))),
      h('div', {class: 'card'}, h('h2', {}, 'A case file of your own'),
        h('label',
          {for: 'new-file'
          },
          'File ', file),
        h('p', {class: 'soft'},
          'The server checks it. Choose the files that it names, such as a mesh or a card, with it.'))),
    found);
  call('ListAlloys')
    .then(({alloys}) => {
      replace(alloy, alloys.map(({card}) => h('option', {selected: card === 'aa5182'}, card)));
      return draft();
    })
    .catch(fault => complain(fault.message));
}
