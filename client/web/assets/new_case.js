// A new case: a file that is uploaded, or the start of a slab by a few figures, as dccast new
// --slab has it.
import {get, post, postText} from './api.js';
import {castingDrawing} from './casting.js';
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
  function show({summary, drawing}, acts) {
    const said = h('p', {role: 'status'});
    replace(
      found,
      h('div', {class: 'card'}, h('p', {}, summary),
        drawing ? castingDrawing(drawing) : null,
        h('div', {class: 'bar'}, acts(said)), said));
  }

  /**
   * Gives a text to the dashboard, which has the server check it. @return its name there; '' with
   * faults, which are shown
   */
  async function give(name, text) {
    const answer = await postText(`/upload/${encodeURIComponent(name)}`, text);
    if (answer.faults) complain(answer.faults);
    return answer;
  }
  /** Buttons that go on with a case. @param kept  gives its name here, '' with faults */
  const goOn = kept => said => {
    const follow = act => async () => {
      try {
        const name = await kept();
        if (name) await act(name);
      } catch (fault) { replace(said, h('span', {class: 'bad'}, fault.message)); }
    };
    return [
      button('What-if with it', follow(name => {
               location.hash = `#/what-if/${encodeURIComponent(name)}`;
             })),
      button('Queue as a job', follow(async name => {
               const {job} = await post(`/keep/?case=${encodeURIComponent(name)}`);
               replace(said, 'Queued as ', h('a', {href: `#/job/${job}`}, job));
             }))
    ];
  };

  async function upload(file) {
    if (!file) return;
    try {
      const answer = await give(file.name, await file.text());
      if (!signal.aborted && answer.name) show(answer, goOn(() => answer.name));
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
    const mine = ++asked,
          given = new URLSearchParams(fields.map((field, i) => [field.key, boxes[i].value]));
    given.set('alloy', alloy.value);
    const made = await get(`/slab/?${given}`);
    if (mine !== asked || signal.aborted) return;
    if (made.faults) return complain(made.faults);

    const name = `slab-${boxes[0].value}.toml`;
    const kept = async () => (await give(name, made.text)).name;
    show(
      made,
      said =>
        [...goOn(kept)(said),
         button(
           'Save the file',
           () => saveBlob(
             `${fileName(name.replace('.toml', ''))}.toml`,
             new Blob([made.text], {type: 'text/plain'})))]);
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
          button('Draw it', () => draft().catch(fault => complain(fault.message))))),
      h('div', {class: 'card'}, h('h2', {}, 'A case file of your own'),
        h('label',
          {for: 'new-file'
          },
          'File ', file),
        h('p', {class: 'soft'},
          'The server checks it. A case that names further files, such as a mesh, is sent with ',
          'dccast submit.'))),
    found);
  get('/alloys/')
    .then(names => {
      replace(alloy, names.map(name => h('option', {selected: name === 'aa5182'}, name)));
      return draft();
    })
    .catch(fault => complain(fault.message));
}
