// What-if: a case with a plant's levers changed, computed at once as a draft, beside the case as it
// is.
import {callDrawn} from './api.js';
import {caseNames, computeCase, readCase, submitCase, textOf} from './cases.js';
import {chart, wantedBand} from './chart.js';
import {findingList, fixed, h, monitorText, replace} from './dom.js';
import {judgement, plant} from './drawn.js';
import {addStep, curlLines, lastMonitors, lengthsDiffer} from './history.js';
import {saveBlob} from './save.js';
import {changeText, givenOf, levers, leverText} from './levers.js';

/** "PLACE: VALUE" lines as a table of a case file; null of none. */
export function rampText(text) {
  const rows = text.split('\n').map(line => line.trim()).filter(line => line).map(line => {
    const [place, value] = line.split(':').map(t => t.trim());
    if (!place || !value) throw new Error(`${line}: write PLACE: VALUE, such as 60 s: 40 mm/min`);
    return [place, value];
  });
  return rows.length ? JSON.stringify(rows) : null;
}

/** @param wanted  name of the case to begin with */
export function whatIfPage(element, signal, wanted) {
  const base = h('select', {id: 'base', onchange: () => restart()});
  const quality =
    h('select', {id: 'quality', onchange: () => restart()},
      ['draft', 'engineering', 'fine'].map(q => h('option', {}, q)));
  const status = h('p', {role: 'status', class: 'soft'}), picture = h('div', {class: 'card'}),
        verdict = h('div', {class: 'card'}), kept = h('p', {role: 'status'});
  const speed = h('textarea', {
    id: 'ramp-speed',
    rows: 4,
    placeholder: '60 s: 40 mm/min\n200 s: 60 mm/min',
    onchange: () => ask()
  });
  const water = h('textarea', {
    id: 'ramp-water',
    rows: 4,
    placeholder: '60 s: 1.5e-3 m2/s\n200 s: 3e-3 m2/s',
    onchange: () => ask()
  });
  const more = h(
    'textarea', {id: 'more', rows: 3, placeholder: 'KEY=VALUE, one a line', onchange: () => ask()});
  let reference = null;
  const sliders = levers.map(lever => {
    const id = lever.key.replaceAll('.', '-'), output = h('output', {for: id
                                               });
    const slider = h('input', {
      type: 'range',
      id,
      min: lever.low,
      max: lever.high,
      step: lever.step,
      value: 0,
      oninput: () => {
        show();
        ask();
      }
    });
    const show = () => {
      output.textContent = leverText(
        lever, Number(slider.value), reference && givenOf(lever, reference.complete, plant));
    };
    show();
    return {
      lever,
      slider,
      show,
      element:
        h('label',
          {for: id
          },
          lever.name, output, slider)
    };
  });

  const changes = () => {
    const list = sliders.filter(s => Number(s.slider.value) !== 0)
                   .map(s => changeText(s.lever, Number(s.slider.value)));
    for (const [box, key] of [[speed, 'schedule.casting_speed'], [water, 'schedule.water_flow']]) {
      const ramp = rampText(box.value);
      if (ramp) list.unshift(`${key}=${ramp}`);  // before its factor
    }
    return [...list, ...more.value.split('\n').map(l => l.trim()).filter(l => l)];
  };
  const read = list => readCase(base.value, [`quality=${quality.value}`, ...list]);

  let timer, running = new AbortController();
  signal.addEventListener('abort', () => running.abort());

  function draw(now, done) {
    const lines = [];
    // As the server compares them.
    const byLength = reference && now ? lengthsDiffer(reference.steps, now.steps) : false;
    if (reference)
      lines.push(...curlLines(reference.steps, ' as it is', byLength)
                   .map((line, i) => ({...line, dashed: true, colour: i})));
    if (now && now !== reference)
      lines.push(...curlLines(now.steps, ' changed', byLength)
                   .map((line, i) => ({...line, colour: i})));
    if (lines.length === 0)
      return replace(
        picture,
        done ? h('p', {class: 'soft'}, 'This case has no monitor whose curl could be drawn.')
             : null);
    replace(picture, chart(lines, {
              title: 'Curl; the bands are the error of mesh and time steps',
              xLabel: byLength ? 'cast length, mm' : 'time, s',
              yLabel: 'mm',
              wanted: wantedBand((now || reference).wanted)
            }));
    if (!done) return;
    if (reference && now !== reference) compare(now);
    const ends = ({steps}) => {
      const {time_s: time, cast_length_m: length} = steps.at(-1);
      return `${lastMonitors(steps).map(m => `${m.name} ${monitorText(m)}`).join(', ')}, at its end, ${
        fixed(time, 0)} s and ${fixed(1e3 * length, 0)} mm cast`;
    };
    replace(
      verdict, h('h2', {}, 'Answer'), reference ? h('p', {}, `As it is: ${ends(reference)}`) : null,
      now !== reference ? h('p', {}, h('strong', {}, `Changed: ${ends(now)}`)) : null,
      now.failure ? h('p', {class: 'bad', role: 'alert'}, now.failure.message) : null,
      findingList(now.findings), difference);
  }

  // The server compares, as it does for dccast compare: a later question makes an earlier answer
  // worthless.
  const difference = h('div', {id: 'difference', 'aria-live': 'polite'});
  let compared = 0;
  async function compare(now) {
    const mine = ++compared,
          named = (answer, name) =>
            ({...(answer.job ? {job: answer.job} : {answer: answer.key}), name});
    replace(difference);
    try {
      const found =
        await callDrawn('CompareRuns', {runs: [named(reference, 'as it is'), named(now, 'changed')]});
      if (mine === compared)
        replace(
          difference, h('h2', {}, 'Difference of run 2, changed, from run 1, as it is'),
          judgement(found.judgement, key => key === 'differences'));
    } catch (fault) {
      if (mine === compared) replace(difference, h('p', {class: 'soft'}, fault.message));
    }
  }

  async function compute(list, done) {
    running.abort();
    running = new AbortController();
    const {signal: mine} = running, begin = performance.now();
    const look = ({waiting, steps, progress}) => {
      if (mine.aborted) return;
      if (steps) draw({steps}, false);
      status.textContent = waiting
        ? `${waiting.reason[0].toUpperCase()}${waiting.reason.slice(1)}, about ${
            fixed(Math.max(1, waiting.expected_s), 0)} s`
        : `Computing… ${fixed(100 * progress, 0)} %`;
    };

    status.textContent = 'Computing…';
    try {
      const changed = await read(list);
      const answer = await computeCase(changed, mine, look);
      if (mine.aborted) return;
      status.textContent = `Computed in ${fixed((performance.now() - begin) / 1000, 1)} s`;
      done({...answer, complete: changed.complete});
    } catch (fault) {
      if (mine.aborted) return;
      status.textContent = '';
      replace(verdict,
        h('p', {class: 'bad', role: 'alert'}, h('span', {class: 'lines'}, fault.message)));
    }
  }

  function ask() {
    clearTimeout(timer);
    timer = setTimeout(() => {
      try {
        const list = changes();
        if (list.length === 0 && reference) {
          running.abort();
          status.textContent = '';
          return draw(reference, true);
        }
        compute(list, answer => draw(answer, true));
      } catch (fault) { replace(verdict, h('p', {class: 'bad', role: 'alert'}, fault.message)); }
    }, 150);
  }

  function restart() {
    reference = null;
    compute([], answer => {
      reference = answer;
      for (const s of sliders) s.show();
      draw(answer, true);
      if (changes().length) ask();
    });
  }

  async function keep() {
    try {
      const {id} = await submitCase(await read(changes()));
      replace(kept, 'Queued as ', h('a', {href: `#/job/${id}`}, id));
    } catch (fault) { replace(kept, h('span', {class: 'bad'}, fault.message)); }
  }
  async function save() {
    try {
      const text = await textOf(await read(changes()));
      saveBlob('what-if.toml', new Blob([text], {type: 'text/plain'}));
      replace(kept, 'Saved as what-if.toml');
    } catch (fault) { replace(kept, h('span', {class: 'bad'}, fault.message)); }
  }
  function reset() {
    for (const s of sliders) {
      s.slider.value = 0;
      s.show();
    }
    for (const box of [speed, water, more]) box.value = '';
    ask();
  }

  const button = (text, action) => h('button', {type: 'button', onclick: action}, text);
  replace(
    element, h('h1', {}, 'What-if'),
    h('div', {class: 'bar'},
      h('label',
        {for: 'base'
        },
        'Case ', base),
      h('label',
        {for: 'quality'
        },
        'Quality ', quality),
      button('As it is', reset), button('Keep as a job', keep), button('Save as a case', save)),
    kept,
    h('div', {class: 'what-if'},
      h('div', {class: 'card levers'}, sliders.map(s => s.element),
        h('details', {}, h('summary', {}, 'Ramps'),
          h('label',
            {for: 'ramp-speed'
            },
            'Casting speed', speed),
          h('label',
            {for: 'ramp-water'
            },
            'Water per metre of perimeter', water)),
        h('details', {}, h('summary', {}, 'Other keys'),
          h('label',
            {for: 'more'
            },
            'Keys of a case, as with --set', more))),
      h('div', {}, status, picture, verdict)));
  caseNames()
    .then(names => {
      replace(
        base,
        names.map(
          name =>
            h('option', {
              selected: wanted ? name === wanted
                               : name === 'start-2d-thickness' && !names[0].endsWith('.toml')
            },
              name)));
      if (!signal.aborted) restart();
    })
    .catch(fault => replace(verdict, h('p', {class: 'bad', role: 'alert'}, fault.message)));
}
