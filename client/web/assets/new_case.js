// A new case: a file that is uploaded, or the start of a slab by a few figures, as dccast new
// --slab has it.
import {call} from './api.js';
import {castingDrawing} from './casting.js';
import {checkCase, keepCase, readSlab, readText, submitCase} from './cases.js';
import {h, replace} from './dom.js';
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
  function show({summary, complete, charts}, acts) {
    const said = h('p', {role: 'status'});
    replace(
      found,
      h('div', {class: 'card'}, h('p', {}, summary),
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
    show(made, said => [
      button('What-if with it', follow(() => {
        location.hash = `#/what-if/${encodeURIComponent(keepCase(name, made.text))}`;
      })),
      button('Queue as a job', follow(async () => {
        const {id} = await submitCase(made);
        replace(said, 'Queued as ', h('a', {href: `#/job/${id}`}, id));
      })),
      ...more
    ]);
  }

  async function upload(file) {
    if (!file) return;
    try {
      const text = await file.text(), made = await readText(text);
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
    accept: '.toml,text/plain',
    onchange: () => upload(file.files[0])
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
          'The server checks it. A case that names further files, such as a mesh, is sent with ',
          'dccast submit.'))),
    found);
  call('ListAlloys')
    .then(({alloys}) => {
      replace(alloy, alloys.map(({card}) => h('option', {selected: card === 'aa5182'}, card)));
      return draft();
    })
    .catch(fault => complain(fault.message));
}
