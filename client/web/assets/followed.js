// The wall of a casting that is followed: its curl now and to come, its levers, what is off, and how
// old all of this is. The figures are the server's.
import {repeat} from './api.js';
import {chart, valueAt, wantedBand} from './chart.js';
import {durationText, fixed, gravestFinding, h, mm, purpose, replace} from './dom.js';
import {plant} from './drawn.js';
import {curlLines} from './history.js';

const oldAfter = 10;  // s without a reading
const ahead = 60;     // s

// ---- Curl now and to come

/** A curl of the forecast and its band at a time, in m; the ends hold beyond them. */
function expectedAt(curl, time) {
  const x = curl.time_s, at = Math.min(Math.max(time, x[0]), x.at(-1));
  const value = y => x.length > 1 ? valueAt({x, y}, at) : y[0];
  return {curl: value(curl.curl_m), lower: value(curl.lower_m), upper: value(curl.upper_m)};
}

const figure = (name, heading, curl, ...lines) =>
  h('div', {class: 'figure', 'data-figure': name}, h('h2', {}, heading),
    h('p', {class: 'huge'}, mm(curl), h('small', {}, ' mm')),
    lines.map(line => h('p', {class: 'beside'}, line)));
const bandText = ({lower, upper}) => `${mm(lower)} to ${mm(upper)} mm`;

/** The figures of a gauge: its curl now, measured beside it, and in a minute or at the end. */
function figuresOf(curl, now, measured) {
  const left = curl.time_s.at(-1) - now, next = expectedAt(curl, now + ahead);
  const present = expectedAt(curl, now), shown = measured?.find(m => m.monitor === curl.monitor);
  return [
    figure('now', `${curl.monitor} now`, present.curl, bandText(present),
      shown ? `measured ${mm(shown.curl_m)} mm` : 'not measured'),
    figure('next', left >= ahead ? `in ${ahead} s` : `at the end, in ${durationText(Math.max(left, 0))}`,
      next.curl, bandText(next))
  ];
}

function curlFigures({job, forecast, noForecast}) {
  const {measured} = job.casting;
  if (forecast) {
    const rows = forecast.curls.map(curl => figuresOf(curl, forecast.time_s, measured?.curls));
    return h('div', {class: rows.length > 1 ? 'curls several' : 'curls'}, rows.flat());
  }
  const computed = (job.last_step?.monitors || []).filter(m => Number.isFinite(m.curl_m));
  return h('div', {class: 'curls several'},
    (measured?.curls || []).map(m => figure('measured', `${m.monitor} now, measured`, m.curl_m)),
    computed.map(m => figure('computed', `${m.name} now, computed`, m.curl_m)),
    h('p', {class: 'beside', 'data-figure': 'no-forecast'}, `No forecast: ${noForecast}`));
}

// ---- Levers

// Name, field of Reading, its unit, and decimals in that of a plant.
const levers = [
  ['Speed', 'casting_speed_m_per_s', 'm/s', 1],
  ['Water', 'water_flow_m2_per_s', 'm2/s', 0],
  ['Narrow water', 'narrow_water_flow_m2_per_s', 'm2/s', 0],
  ['Second water', 'second_water_flow_m2_per_s', 'm2/s', 0],
  ['Metal', 'casting_temperature_c', 'degC', 0],
  ['Water temperature', 'water_temperature_c', 'degC', 0],
  ['Metal level', 'metal_level_m', 'm', 0],
];

function leverRows({measured, planned}) {
  const known = levers.filter(([, field]) => (measured?.[field] ?? planned?.[field]) !== undefined);
  return h('table', {class: 'levers-now'},
    h('thead', {}, h('tr', {}, ['', 'now', 'plan', ''].map(head => h('th', {scope: 'col'}, head)))),
    h('tbody', {}, known.map(([name, field, si, digits]) => {
      const {name: unit, factor} = plant(si), shown = at => fixed(factor * at?.[field], digits);
      return h('tr', {'data-lever': name},
        h('th', {scope: 'row'}, name),
        h('td', {class: 'measured'}, shown(measured)),
        h('td', {class: 'planned'}, shown(planned)),
        h('td', {class: 'unit'}, unit));
    })));
}

// ---- What is off

const warningLine = ({monitor, text, causes}) =>
  h('li', {}, h('strong', {}, `${monitor}: ${text}`),
    causes.length ? h('p', {}, `Likeliest: ${causes.join(', ')}`) : null);

/** Levers that are off their plan: what the hall can mend at once. Empty where none is. */
const alarmsOf = ({casting}) => h('div', {class: 'alarms', role: 'alert'},
  [...(casting.alarms || [])].reverse().map(({monitor, text}) => h('p', {}, `${monitor}: ${text}`)));

/** The newest warnings of the forecast, the gravest finding of the run, and what may come. */
function warningsOf({job, forecast}) {
  const newest = [...(forecast?.warnings || [])].reverse(), most = 2;
  const findings = (job.findings || []).filter(finding => finding.severity !== 'NOTE');
  const toCome = (forecast?.findings || []).map(({rule, members, of}) =>
    `${rule.replaceAll('_', ' ')} in ${members} of ${of}`);
  const isSound = !newest.length && !findings.length && !job.casting.alarms?.length;
  return h('section', {class: newest.length ? 'warnings raised' : 'warnings', 'aria-label': 'Warnings'},
    newest.length ? h('ul', {}, newest.slice(0, most).map(warningLine)) : null,
    isSound && forecast ? h('p', {}, 'No warning.') : null,
    newest.length > most ? h('p', {class: 'soft'}, `and ${newest.length - most} earlier`) : null,
    findings.length ? gravestFinding(findings) : null,
    toCome.length
      ? h('p', {class: 'soft'}, `To come in members of the ensemble: ${toCome.join(', ')}`)
      : null);
}

/** What can still be done, in large letters. Empty where the levers were not computed. */
const adviceOf = forecast => h(
  'section', {class: 'advice', 'aria-label': 'What can still be done'},
  (forecast?.advice || []).map(text => h('p', {}, text)));

// ---- The chart

const inMm = values => values.map(v => v === null ? NaN : 1e3 * v);

function chartLines({steps, forecast}) {
  if (!forecast) return curlLines(steps, ', computed');
  const byMonitor = curlLines(steps);
  return forecast.curls.flatMap((curl, i) => {
    const computed = byMonitor.find(line => line.monitor === curl.monitor);
    return [
      {name: `${curl.monitor}, forecast`, x: curl.time_s, y: inMm(curl.curl_m),
        low: inMm(curl.lower_m), high: inMm(curl.upper_m), dashed: true, colour: 3 * i + 2},
      computed
        ? {name: 'computed', x: computed.x, y: computed.y, colour: 3 * i + 1}
        : null,
      {name: 'measured', x: curl.measured_time_s, y: inMm(curl.measured_m), dots: true,
        colour: 3 * i}
    ].filter(line => line !== null && line.x.length > 0);
  });
}

function curlChart(seen) {
  const lines = chartLines(seen);
  if (lines.every(line => line.x.length === 0)) return h('div');
  return chart(lines, {
    title: 'Curl', xLabel: 'time, s', yLabel: 'mm', width: 960, wanted: wantedBand(seen.wanted)
  });
}

// ---- The age of the last reading

/** "11 s", "3 min", "2 h": short, so that it fits one line in the largest letters. */
function agedText(seconds) {
  if (seconds < 120) return `${Math.round(seconds)} s`;
  return seconds < 7200 ? `${Math.floor(seconds / 60)} min` : `${Math.floor(seconds / 3600)} h`;
}

/** What the page says of the age; `old` where the figures are not of now. */
function ageText({measured, closed}, seconds) {
  if (!measured) return {text: 'no reading yet'};
  if (closed) return {text: 'the readings have ended'};
  if (seconds === null)
    return {old: ['Age not known', 'These figures may be old. The next reading tells it.']};
  if (seconds <= oldAfter) return {text: `last reading ${agedText(seconds)} ago`};
  const at = fixed(measured.time_s, 0);
  return {old: [`No reading for ${agedText(seconds)}`, `These figures are of ${at} s, not of now.`]};
}

/**
 * The wall of a casting that is followed.
 * @return draws what was seen: {job, steps, wanted, forecast or noForecast: why there is none,
 *   asked: when the server was asked, of performance.now()}
 */
export function followedWall(element, signal) {
  const age = h('p', {class: 'age'}), old = h('div', {class: 'old'});
  let seen = null;

  // Nothing new comes from a server that is away: the age grows all the same.
  function drawAge() {
    if (!seen) return;
    const {casting} = seen.job, told = casting.age_s ?? null;
    const seconds = told === null ? null : told + (performance.now() - seen.asked) / 1e3;
    const {text, old: lines} = ageText(casting, seconds);
    age.textContent = text || '';
    replace(old, (lines || []).map(line => h('p', {}, line)));
    element.classList.toggle('stale', Boolean(lines));
  }
  repeat(1000, signal, async () => drawAge());

  return now => {
    seen = now;
    const {following, measured} = now.job.casting;
    const when = measured ? `${fixed(measured.time_s, 0)} s` : '';
    replace(element, h('div', {class: 'casting'},
      h('div', {class: 'place'}, h('h1', {}, following.line || now.job.title || now.job.id),
        h('p', {class: 'when'}, when), age),
      alarmsOf(now.job), old, curlFigures(now), leverRows(now.job.casting),
      h('div', {class: 'curl-chart'}, curlChart(now)),
      h('div', {class: 'remarks'}, warningsOf(now), adviceOf(now.forecast),
        (now.forecast?.notes || []).map(note => h('p', {class: 'note'}, note)), purpose())));
    drawAge();
  };
}
