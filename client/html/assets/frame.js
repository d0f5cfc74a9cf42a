// The slab of a job: fields of its stored frames in WebGL, cut, turned, in time, at a point and
// along a line.
import {chart, ticks} from './chart.js';
import {fixed, h, replace} from './dom.js';
import {
  byValue, cut, fieldsOf, fieldValues, locate, magnification, readFrame, shown, spreadFromBottom, temperature,
  valueAtPlace
} from './frame_data.js';
import {
  colourBar, colours, fit, isBelow, numberText, Painter, rulerLength, seesCut, viewOf, viewOfCut, views
} from './frame_view.js';
import {canvasOfSvg, fileName, saveCsv, savePng} from './save.js';

const mostKept = 40;  // frames in memory
const ofBottom = new Set(['gap_m', 'contact_pressure_pa']);

/** The frames of a source as they are asked for. */
class Frames {
  constructor(source) {
    this.source = source;
    this.kept = new Map();
    this.times = [];
    this.fields = [temperature];
  }

  /** Asks which frames there are. @return whether there are more than before */
  async look() {
    const {times, fields, reason, beyond} = await this.source.look();
    const more = times.length > this.times.length;
    if (times.length) [this.times, this.fields] = [times, fieldsOf(fields)];
    this.reason = reason;
    this.beyond = beyond ?? Infinity;
    return more;
  }

  async frame(number) {
    if (!this.kept.has(number)) {
      if (this.kept.size >= mostKept) this.kept.delete(this.kept.keys().next().value);
      this.kept.set(number, readFrame(await this.source.frame(number)));
    }
    return this.kept.get(number);
  }

  values(frame, number, field) {
    return fieldValues(frame, field, () => this.source.field(number, field.name));
  }
}

function boundsOf(frame) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  frame.place.forEach((v, i) => {
    low[i % 3] = Math.min(low[i % 3], v);
    high[i % 3] = Math.max(high[i % 3], v);
  });
  return {low, high};
}

function rangeOf(values) {
  let low = Infinity, high = -Infinity;
  for (const v of values)
    if (Number.isFinite(v)) {
      low = Math.min(low, v);
      high = Math.max(high, v);
    }
  if (!(low <= high)) return [0, 1];
  return low === high ? [low - 0.5, high + 0.5] : [low, high];
}

/**
 * Fills `box` with the slab of a run.
 * @param source  where its frames are: look() gives {times, fields, reason: why there are none,
 *   beyond: time from which on the model is not valid}, frame(number) and field(number, name) bytes
 * @param title  of the run, for pictures
 * @param beside  {}, the same for slabs that stand side by side: they are turned together
 * @return {is3d, refresh, copy}: refresh() looks for further frames, copy() draws another view
 */
export async function frameViewer(box, signal, source, title, beside = {}) {
  const frames = new Frames(source);
  await frames.look();
  if (frames.times.length === 0) throw new Error(frames.reason || 'No frame is stored.');

  const canvas = h('canvas', {width: 900, height: 620, tabindex: 0, role: 'img'});
  const painter = new Painter(canvas);
  signal.addEventListener('abort', () => painter.release());
  const aspect = () => canvas.width / canvas.height;
  const marker = h('span', {class: 'marker', hidden: true}),
        ruler = h('span', {class: 'ruler'}), stage = h('div', {class: 'stage'}, canvas, marker, ruler);
  const bar = h('div'), probe = h('p', {role: 'status', class: 'soft probe'}), picture = h('div');
  const hint = 'Drag to turn, wheel or + and - to zoom, click for values at a point.';

  const eye = beside.eye ??= {...views['From the corner'], size: 1, centre: [0, 0, 0]};
  let frame = null, number = frames.times.length, values = null, range = [0, 1], scale = 1,
      axis = -1, depth = 0.5, asked = 0;
  let point = null, end = null, drawnTimes = 0;

  // ---- Drawing

  const is3d = () => frame.dimension === 3;
  const isPlane = () => axis >= 0 && axis !== byValue;
  /** Where the cut is [m]; by value what is cut away is above it, in shares of the range of the colours. */
  const plane = () => {
    if (axis === byValue) return depth;
    const {low, high} = boundsOf(frame);
    return low[axis] + depth * (high[axis] - low[axis]);
  };
  /** @param shownField, between  what the painter has, and the range of its colours */
  function paint(shownField, between) {
    const keep = [0, 0, 0, 1];
    if (isPlane()) {
      keep[axis] = 1;
      keep[3] = plane() + 1e-6;
    }
    const most = axis === byValue ? plane() : Infinity;
    const scaled = v => (v - between[0]) / (between[1] - between[0]);
    const fronts =
      shownField === temperature ? [scaled(frame.solidus), scaled(frame.liquidus)] : [-5, -5];
    painter.draw({eye, scale, keep, most, fronts, contours: ticks(...between).values.map(scaled)});
  }
  function draw() {
    asked = 0;
    paint(field(), range);
    placeMarker();
    const across = eye.size * aspect(), length = rulerLength(across);
    ruler.style.width = `${100 * length / across}%`;
    ruler.textContent = lengthText(length);
  }
  const lengthText = metres => `${Number((1e3 * metres).toPrecision(3))} mm`;
  const redraw = () => {
    if (!asked && frame) asked = requestAnimationFrame(draw);
  };
  (beside.redraws ??= []).push(redraw);
  const redrawAll = () => beside.redraws.forEach(one => one());
  const cutNow = () => painter.setCap(
    axis < 0 || !is3d() ? new Float32Array() : cut(frame, painter.scaled, axis, plane()));

  /** The slab, or the cut through it, fills the canvas. */
  function fillCanvas() {
    const {low, high} = boundsOf(frame);
    if (isPlane()) low[axis] = high[axis] = plane();
    fit(eye, low, high, canvas);
    redrawAll();
  }

  function onScreen(place, moved) {
    const m = viewOf(eye, aspect()), p = [0, 1, 2].map(c => place[c] + scale * moved[c]);
    const at = r => m[r] * p[0] + m[r + 4] * p[1] + m[r + 8] * p[2] + m[r + 12];
    return [at(0), at(1), at(2)];
  }
  function placeMarker() {
    const place = point && locate(frame, point);
    marker.hidden = !place;
    if (!place) return;
    const [x, y] = onScreen(point, [0, 1, 2].map(c => valueAtPlace(place, frame.moved, 3, c)));
    marker.style.left = `${50 + 50 * x}%`;
    marker.style.top = `${50 - 50 * y}%`;
  }

  // ---- What is shown

  const field = () => frames.fields.find(f => f.name === choice.value) || temperature;
  async function show(wanted) {
    number = wanted;
    const seconds = frames.times[wanted - 1], beyond = seconds >= frames.beyond;
    time.output.textContent = `${fixed(seconds, 1)} s${beyond ? ', beyond validity' : ''}`;
    const chosen = field(), next = await frames.frame(wanted);
    const own = await frames.values(next, wanted, chosen);
    if (signal.aborted || number !== wanted || field() !== chosen)
      return;  // another one was asked for meanwhile

    const first = frame === null;
    frame = next;
    values = own;
    const {title: name, unit, range: fixedRange} = shown(chosen);
    if (fixedRange) range = fixedRange(frame);
    else if (!hold.checked || held !== chosen.name) range = rangeOf(values);
    held = chosen.name;

    painter.setFrame(frame, spreadFromBottom(frame, values), range);
    if (first) begin();
    cutMoved();
    replace(bar, colourBar(name, unit, range));
    lines.textContent = extremesText(unit) + (chosen !== temperature ? '' :
      ` White lines: solidus ${fixed(frame.solidus, 0)} and liquidus ${fixed(frame.liquidus, 0)} °C.`);
    canvas.setAttribute(
      'aria-label',
      `${name} of the slab at ${fixed(frame.time, 1)} s, ${fixed(1e3 * frame.length, 0)} mm cast`);
    showPoint();
  }
  let held = '';
  const failed = fault => {
    probe.textContent = fault.message;
  };
  const again = () => show(number).catch(failed);

  /** "Least 21 °C at 660.0, 285.0, 0.0 mm, largest 680 °C at ...". */
  function extremesText(unit) {
    let least = -1, largest = -1;
    values.forEach((v, n) => {
      if (!Number.isFinite(v)) return;
      if (least < 0 || v < values[least]) least = n;
      if (largest < 0 || v > values[largest]) largest = n;
    });
    if (least < 0) return 'No value in this frame.';
    const text = n => `${numberText(values[n], values[largest] - values[least])} ${unit} at ${
      mmOf([...frame.place.subarray(3 * n, 3 * n + 3)])} mm`;
    return `Least ${text(least)}, largest ${text(largest)}.`;
  }

  // ---- At a point

  const mmOf = place =>
    place.filter((v, c) => is3d() || c !== 1).map(v => fixed(1e3 * v, 1)).join(', ');
  function valuesAt(of, ofValues, place) {
    const {title: name, unit} = shown(field());
    const at = locate(of, place);
    if (!at) return 'no metal yet';
    const own = valueAtPlace(at, ofValues),
          moved = [0, 1, 2].map(c => valueAtPlace(at, of.moved, 3, c));
    const parts = [`${fixed(valueAtPlace(at, of.warm), 0)} °C`, `moved ${mmOf(moved)} mm`];
    if (field() !== temperature)
      parts.unshift(
        Number.isFinite(own) ? `${name} ${numberText(own, range[1] - range[0])} ${unit}` :
                               `${name} has no value here`);
    return parts.join(', ');
  }
  function showPoint() {
    probe.textContent = point
      ? `At ${mmOf(point)} mm, ${fixed(frame.time, 1)} s: ${valuesAt(frame, values, point)}`
      : hint;
  }

  /** The visible point of the slab nearest to the pointer, in the undeformed slab. */
  function pointUnder(event) {
    const rect = canvas.getBoundingClientRect();
    const x = (event.clientX - rect.left) / rect.width * 2 - 1,
          y = 1 - (event.clientY - rect.top) / rect.height * 2;
    let best = null, least = Infinity;
    const look = (place, moved) => {
      const [px, py, pz] = onScreen(place, moved);
      const off = Math.hypot(px - x, py - y) + 0.02 * pz;
      if (off < least) {
        least = off;
        best = [...place];
      }
    };

    const limit = axis >= 0 ? plane() + 1e-6 : Infinity;
    for (const n of frame.triangle) {
      const place = frame.place.subarray(3 * n, 3 * n + 3);
      const along = axis === byValue ? painter.scaled[n] : place[axis];
      if (axis < 0 || along <= limit) look(place, frame.moved.subarray(3 * n, 3 * n + 3));
    }
    if (axis >= 0) {
      const cap = cut(frame, painter.scaled, axis, plane());
      for (let i = 0; i < cap.length; i += 7)
        look(cap.subarray(i, i + 3), cap.subarray(i + 3, i + 6));
    }
    return best;
  }
  function choosePoint(place, asEnd) {
    if (asEnd) end = place;
    else point = place;
    (asEnd ? endBox : pointBox).value = mmOf(place);
    showPoint();
    redraw();
  }
  const placeOf = text => {
    const given = text.split(/[,;\s]+/).filter(t => t).map(t => Number(t) / 1e3);
    const wanted = is3d() ? 3 : 2;
    if (given.length !== wanted || given.some(v => !Number.isFinite(v)))
      throw new Error(`Write a point as ${is3d() ? 'x, y, z' : 'x, z'} in mm.`);
    return is3d() ? given : [given[0], 0, given[1]];
  };

  /** Draws a curve below the slab. @param x, y  arrays in the units of the labels */
  function drawCurve(name, xLabel, x, y) {
    const {title: fieldTitle, unit} = shown(field());
    if (!y.some(Number.isFinite)) throw new Error('There is no metal there.');
    replace(
      picture,
      chart(
        [{name: fieldTitle, x, y}],
        {title: `${fieldTitle} ${name}`, xLabel, yLabel: unit || fieldTitle, unit}));
  }
  async function overTime() {
    const place = placeOf(pointBox.value), chosen = field(), at = [];
    choosePoint(place, false);
    for (let n = 1; n <= frames.times.length; n++) {
      probe.textContent = `Reading frame ${n} of ${frames.times.length}`;
      const of = await frames.frame(n);
      at.push(valueAtPlace(locate(of, place), await frames.values(of, n, chosen)));
      if (signal.aborted) return;
    }
    showPoint();
    drawCurve(`at ${mmOf(place)} mm`, 'time, s', [...frames.times], at);
  }
  async function alongLine() {
    const from = placeOf(pointBox.value), to = placeOf(endBox.value), points = 101;
    choosePoint(from, false);
    const length = 1e3 * Math.hypot(...from.map((v, c) => to[c] - v)), x = [], y = [];
    for (let i = 0; i < points; i++) {
      const s = i / (points - 1);
      x.push(s * length);
      y.push(valueAtPlace(locate(frame, from.map((v, c) => v + s * (to[c] - v))), values));
    }
    drawCurve(
      `from ${mmOf(from)} to ${mmOf(to)} mm at ${fixed(frame.time, 1)} s`, 'distance, mm', x, y);
  }

  // ---- Files

  const file = () =>
    fileName(`${title}-${shown(field()).title}-${fixed(frame.time, 0)}s`);
  async function savePicture() {
    draw();
    const below = await canvasOfSvg(bar.firstChild), head = 40;
    const height = Math.round(below.height * canvas.width / below.width);
    const whole = h('canvas', {width: canvas.width, height: head + canvas.height + height}),
          context = whole.getContext('2d');
    const style = getComputedStyle(document.body);
    context.fillStyle = style.getPropertyValue('--card');
    context.fillRect(0, 0, whole.width, whole.height);
    context.fillStyle = style.getPropertyValue('--ink');
    context.font = '18px sans-serif';
    context.fillText(
      `${title}, ${fixed(frame.time, 1)} s, ${fixed(1e3 * frame.length, 0)} mm cast`, 10, 26,
      whole.width - 20);
    context.drawImage(canvas, 0, head);
    context.drawImage(below, 0, head + canvas.height, canvas.width, height);
    savePng(`${file()}.png`, whole);
  }
  function saveData() {
    const {title: name, unit} = shown(field()), axes = is3d() ? [0, 1, 2] : [0, 2],
                        names = is3d() ? 'xyz' : 'x z';
    const heads = [
      ...axes.map(c => `${names[c]} [mm]`), ...axes.map(c => `displacement ${names[c]} [mm]`),
      'temperature [°C]'
    ];
    if (field() !== temperature) heads.push(`${name} [${unit || 1}]`);
    const rows = [heads];
    for (let n = 0; n < frame.nodes; n++) {
      const row = [
        ...axes.map(c => 1e3 * frame.place[3 * n + c]),
        ...axes.map(c => 1e3 * frame.moved[3 * n + c]), frame.warm[n]
      ];
      if (field() !== temperature) row.push(values[n]);
      rows.push(row.map(v => Number(v.toPrecision(7))));
    }
    saveCsv(`${file()}.csv`, rows);
  }

  // ---- Pointer and keys

  let from = null, dragged = false;
  canvas.addEventListener('pointerdown', event => {
    from = [event.clientX, event.clientY];
    dragged = false;
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener('pointermove', event => {
    if (!from) return;
    const [dx, dy] = [event.clientX - from[0], event.clientY - from[1]];
    if (Math.hypot(dx, dy) < 3 && !dragged) return;
    dragged = true;
    turn(-0.008 * dx, 0.008 * dy);
    from = [event.clientX, event.clientY];
  });
  canvas.addEventListener('pointerup', event => {
    if (from && !dragged && frame) choosePoint(pointUnder(event), event.shiftKey);
    from = null;
  });
  canvas.addEventListener('wheel', event => {
    event.preventDefault();
    zoom(Math.exp(0.001 * event.deltaY));
  }, {passive: false});
  canvas.addEventListener('keydown', event => {
    const keys = {
      ArrowLeft: () => turn(0.1, 0),
      ArrowRight: () => turn(-0.1, 0),
      ArrowUp: () => turn(0, -0.1),
      ArrowDown: () => turn(0, 0.1),
      '+': () => zoom(0.9),
      '-': () => zoom(1.1)
    };
    if (keys[event.key]) {
      event.preventDefault();
      keys[event.key]();
    }
  });
  function turn(yaw, pitch) {
    if (!frame || !is3d()) return;
    eye.yaw += yaw;
    eye.pitch = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, eye.pitch + pitch));
    redrawAll();
  }
  function zoom(factor) {
    eye.size *= factor;
    redrawAll();
  }

  // ---- Controls

  const slider = (name, attributes, act) => {
    const input =
            h('input', {type: 'range', oninput: () => act(Number(input.value)), ...attributes}),
          output = h('output');
    return {input, output, label: h('label', {}, name, output, input)};
  };
  const select = (name, options, act) => {
    const input =
      h('select', {onchange: act}, options.map(([value, text]) => h('option', {value}, text)));
    return {input, label: h('label', {}, name, input)};
  };
  const button = (text, act) =>
    h('button', {
      type: 'button',
      onclick: async () => {
        try {
          await act();
        } catch (fault) { failed(fault); }
      }
    },
      text);

  const choice = h('select', {
    'aria-label': 'Field',
    onchange: () => {
      lookAtBottom();
      again();
    }
  });
  /** Fields of the bottom are seen from below. */
  function lookAtBottom() {
    if (!ofBottom.has(choice.value) || !is3d() || isBelow(eye)) return;
    look.input.value = 'From below';
    Object.assign(eye, views['From below']);
    fillCanvas();
  }
  const listFields = () => {
    const before = choice.value;
    replace(choice, frames.fields.map(f => h('option', {value: f.name}, shown(f).title)));
    if (before) choice.value = before;
  };
  const hold = h('input', {type: 'checkbox', onchange: again});
  const time = slider(
    'Time', {min: 1, max: frames.times.length, step: 1, value: frames.times.length},
    n => {
      playing = false;
      show(n).catch(failed);
    });
  let playing = false;
  const player = button('Play', play);
  /** Shows one frame after another, from the first if the last is shown; pressed again, it stops. */
  async function play() {
    playing = !playing;
    if (!playing) return;
    player.textContent = 'Stop';
    for (let n = number % frames.times.length + 1; playing && !signal.aborted; n++) {
      time.input.value = n;
      await Promise.all([show(n), new Promise(shown => { setTimeout(shown, 150); })]);
      if (n >= frames.times.length) playing = false;
    }
    player.textContent = 'Play';
  }
  const bent = slider('Deformation', {min: 0, max: 20, step: 1, value: 1}, value => {
    bend(value);
    redraw();
  });
  function bend(value) {
    scale = value;
    bent.output.textContent = `× ${value}`;
  }

  const deep =
    slider('Place of the cut', {min: 0, max: 1, step: 0.01, value: 0.5, disabled: true}, value => {
      depth = value;
      cutMoved();
    });
  const levelText = () => {
    const [low, high] = range;
    return `${numberText(low + depth * (high - low), high - low)} ${shown(field()).unit}`;
  };
  function cutMoved() {
    deep.output.textContent = axis < 0 ? '' : isPlane() ? `${fixed(1e3 * plane(), 0)} mm` : levelText();
    cutNow();
    redraw();
  }
  const across = select(
    'Cut',
    [
      ['-1', 'whole'], ['0', 'across the width'], ['1', 'across the thickness'],
      ['2', 'at a height'], [`${byValue}`, 'where it is below a value']
    ],
    () => {
      axis = Number(across.input.value);
      deep.input.disabled = axis < 0;
      // The eye stays where it is, if it sees the cut from there.
      if (isPlane() && !seesCut(eye, axis)) {
        Object.assign(eye, viewOfCut(axis));
        fillCanvas();
      }
      cutMoved();
    });
  const look = select('View', Object.keys(views).map(name => [name, name]), () => {
    Object.assign(eye, views[look.input.value]);
    fillCanvas();
  });

  const pointBox =
    h('input', {type: 'text', 'aria-label': 'Point, mm', placeholder: 'x, y, z in mm'});
  const endBox =
    h('input', {type: 'text', 'aria-label': 'End of the line, mm', placeholder: 'x, y, z in mm'});
  const lines = h('p', {class: 'soft'});
  const solidOnly = [look.label, h('div', {class: 'cuts'}, across.label, deep.label)];

  function begin() {
    bend(magnification(frame));
    bent.input.value = scale;
    if (!is3d()) Object.assign(eye, views['Middle plane']);
    for (const part of solidOnly) part.hidden = !is3d();
    for (const input of [pointBox, endBox])
      input.placeholder = is3d() ? 'x, y, z in mm' : 'x, z in mm';
    fillCanvas();
  }

  replace(
    box, h('h2', {}, 'Slab'),
    h('div', {class: 'bar'}, choice, h('label', {}, hold, ' Hold the colours'), player,
      button('Picture (PNG)', savePicture), button('Data (CSV)', saveData)),
    stage, bar, lines, h('div', {class: 'levers row'}, time.label, bent.label, solidOnly), probe,
    h('div', {class: 'bar'}, h('label', {}, 'Point ', pointBox), button('Over time', overTime),
      h('label', {}, 'to ', endBox), button('Along the line', alongLine)),
    picture);
  listFields();
  drawnTimes = frames.times.length;
  await show(number);

  return {
    is3d: is3d(),
    /**
     * Draws the frame into another canvas, as seen from elsewhere.
     * @return range of the colours
     */
    async copy(target, view, wanted = field()) {
      const own = await frames.values(frame, number, wanted);
      const between = wanted === field() ? range : rangeOf(own), kept = {...eye};
      const height = canvas.height;
      Object.assign(eye, views[view]);
      fillCanvas();
      painter.setFrame(frame, spreadFromBottom(frame, own), between);
      paint(wanted, between);
      Object.assign(target, {width: canvas.width, height: canvas.height});
      target.getContext('2d').drawImage(canvas, 0, 0);

      Object.assign(eye, kept);
      canvas.height = height;
      painter.setFrame(frame, spreadFromBottom(frame, values), range);
      cutNow();
      draw();
      return between;
    },
    /** Looks for further frames; the last one stays the one that is shown. */
    async refresh() {
      if (!await frames.look() || signal.aborted) return;
      const wasLast = number === drawnTimes;
      drawnTimes = frames.times.length;
      time.input.max = drawnTimes;
      listFields();
      if (!wasLast) return;
      time.input.value = drawnTimes;
      await show(drawnTimes);
    },
  };
}
