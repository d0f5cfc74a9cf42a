// What-if: a case with a plant's levers changed, computed at once as a draft, beside the case as it
// is.
import {callDrawn} from './api.js';
import {caseNames, computeCase, readCase, submitCase, textOf} from './cases.js';
import {chart, wantedBand} from './chart.js';
import {button, faultLine, field, findingList, fixed, h, monitorText, replace} from './dom.js';
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
  const quality = h('select', {id: 'quality', onchange: () => restart()},
    ['draft', 'engineering', 'fine'].map(name => h('option', {}, name)));
  const status = h('p', {role: 'status', class: 'soft'}), kept = h('p', {role: 'status'});
  const picture = h('div', {class: 'card'}), verdict = h('div', {class: 'card'});
  const lines = (id, placeholder) => h('textarea', {id, rows: 4, placeholder, onchange: () => ask()});
  const speed = lines('ramp-speed', '60 s: 40 mm/min\n200 s: 60 mm/min');
  const water = lines('ramp-water', '60 s: 1.5e-3 m2/s\n200 s: 3e-3 m2/s');
  const more = lines('more', 'KEY=VALUE, one a line');
  let reference = null;
  const sliders = levers.map(lever => {
    const {key, name, low: min, high: max, step} = lever, id = key.replaceAll('.', '-');
    const output = h('output', {for: id});
    const oninput = () => {
      show();
      ask();
    };
    const slider = h('input', {type: 'range', id, min, max, step, value: 0, oninput});
    const show = () => {
      output.textContent = leverText(
        lever, Number(slider.value), reference && givenOf(lever, reference.complete, plant));
    };
    show();
    return {lever, slider, show, element: h('label', {for: id}, name, output, slider)};
  });
  const showFault = fault => replace(verdict, faultLine(fault));

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
      now.failure ? faultLine(now.failure) : null,
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
      showFault(fault);
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
      } catch (fault) { showFault(fault); }
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

  /** What is done with the changed case. @return a handler */
  const withChanged = act => async () => {
    try {
      replace(kept, await act(await read(changes())));
    } catch (fault) { replace(kept, h('span', {class: 'bad'}, fault.message)); }
  };
  const keep = withChanged(async changed => {
    const {id} = await submitCase(changed);
    return ['Queued as ', h('a', {href: `#/job/${id}`}, id)];
  });
  const save = withChanged(async changed => {
    saveBlob('what-if.toml', new Blob([await textOf(changed)], {type: 'text/plain'}));
    return 'Saved as what-if.toml';
  });
  function reset() {
    for (const s of sliders) {
      s.slider.value = 0;
      s.show();
    }
    for (const box of [speed, water, more]) box.value = '';
    ask();
  }

  replace(
    element, h('h1', {}, 'What-if'),
    h('div', {class: 'bar'}, field('Case', base), field('Quality', quality),
      button('As it is', reset), button('Keep as a job', keep), button('Save as a case', save)),
    kept,
    h('div', {class: 'what-if'},
      h('div', {class: 'card levers'}, sliders.map(s => s.element),
        h('details', {}, h('summary', {}, 'Ramps'), field('Casting speed', speed),
          field('Water per metre of perimeter', water)),
        h('details', {}, h('summary', {}, 'Other keys'),
          field('Keys of a case, as with --set', more))),
      h('div', {}, status, picture, verdict)));
  caseNames().then(names => {
    const first = wanted ?? (names[0].endsWith('.toml') ? names[0] : 'start-2d-thickness');
    replace(base, names.map(name => h('option', {selected: name === first}, name)));
    if (!signal.aborted) restart();
  }).catch(showFault);
}
