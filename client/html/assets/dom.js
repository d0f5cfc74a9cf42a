// Elements, numbers and words. Text from the server reaches the page as text nodes, or as HTML in which the
// client has escaped it.

/**
 * An element: h('a', {href: '#/x', onclick: f}, 'text', child). Attributes that are null are left
 * out.
 */
export function h(tag, attributes = {}, ...children) {
  const svg = svgTags.has(tag);
  const element =
    svg ? document.createElementNS('http://www.w3.org/2000/svg', tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, '');
    else if (value !== null && value !== undefined && value !== false)
      element.setAttribute(name, value);
  }
  element.append(...children.flat().filter(child => child !== null && child !== undefined));
  return element;
}
const svgTags = new Set(['svg', 'path', 'line', 'circle', 'text', 'g', 'rect', 'polyline']);

export function replace(parent, ...children) {
  parent.replaceChildren(...children.flat().filter(child => child !== null && child !== undefined));
}

export const button = (text, onclick, attributes = {}) =>
  h('button', {type: 'button', onclick, ...attributes}, text);

/** An entry behind its name. */
export const field = (name, entry) => h('label', {for: entry.id}, name, ' ', entry);

/** An error, where a reader of the screen hears it. */
export const faultLine = ({message}) => h('p', {class: 'bad lines', role: 'alert'}, message);

/** @return {fault: where faults are shown, attempt: (act) does it, and shows its fault} */
export function attempts() {
  const fault = faultLine({message: ''});
  const attempt = async act => {
    try {
      replace(fault);
      await act();
    } catch ({message}) { replace(fault, message); }
  };
  return {fault, attempt};
}

/** A number with so many decimals; zero has no sign. */
export const fixed = (value, digits) =>
  Number.isFinite(value) ? value.toFixed(digits).replace(/^-(?=[0.]*$)/, '') : '–';
export const mm = (metres, digits = 1) => fixed(1e3 * metres, digits);

/** Decimals in mm of a curl: two digits of its error, and no finer than hundredths. */
const decimalsFor = error => {
  if (!(error > 0)) return 2;
  const rounded = Number((1e3 * error).toPrecision(2));
  return Math.min(2, Math.max(0, 1 - Math.floor(Math.log10(rounded))));
};

/** A curl and its error in mm: "5.25" and "± 0.21", "35.5" and "-0 +4.9"; given in m. No error: none is known. */
export const curlParts = (curl, lower, upper) => {
  const digits = decimalsFor(Math.max(lower, upper)), shown = mm(curl, digits);
  if (!Number.isFinite(upper)) return {curl: shown, error: ''};
  if (lower === upper) return {curl: shown, error: `± ${mm(upper, digits)}`};
  const side = error => mm(error, digits).replace(/^[0.]*$/, '0');
  return {curl: shown, error: `-${side(lower)} +${side(upper)}`};
};

/** "5.25 ± 0.21 mm", "35.5, -0 +4.9 mm". */
export const curlText = (...figures) => {
  const {curl, error} = curlParts(...figures), comma = error.startsWith('-') ? ',' : '';
  return `${curl}${comma}${error && ` ${error}`} mm`;
};

/** The curl of a MonitorValue with its errors, for curlText() and curlParts(). */
export const curlOf = monitor =>
  [monitor.curl_m ?? NaN, monitor.curl_lower_error_m, monitor.curl_upper_error_m];
export const monitorText = monitor => curlText(...curlOf(monitor));

export const stateText = state => (state || '').toLowerCase().replaceAll('_', ' ');
export const shortId = id => id.slice(0, 8);

export function ago(time) {
  if (!time) return '';
  const seconds = Math.max(0, (Date.now() - Date.parse(time)) / 1000);
  for (const [unit, size] of [['d', 86400], ['h', 3600], ['min', 60]])
    if (seconds >= size) return `${Math.floor(seconds / size)} ${unit} ago`;
  return 'now';
}

/** "1 h 05 min", "2 min 05 s", "8 s". */
export function durationText(seconds) {
  const whole = Math.round(seconds), two = number => String(number).padStart(2, '0');
  if (whole >= 3600) return `${Math.floor(whole / 3600)} h ${two(Math.floor(whole / 60) % 60)} min`;
  return whole >= 60 ? `${Math.floor(whole / 60)} min ${two(whole % 60)} s` : `${whole} s`;
}

const rank = {
  NOTE: 1,
  WARNING: 2,
  DANGER: 3
};
export const worst = findings =>
  findings.reduce((most, f) => Math.max(most, rank[f.severity] || 0), 0);
export const severityText = ['', 'note', 'warning', 'danger'];

/**
 * A table that a phone shows as one block for each row.
 * @param heads  [text]
 * @param rows   [[content, or {class, content}]]; content as of h()
 */
export function sheet(heads, rows) {
  const cell = (given, i) => {
    const {content, class: kind} = given?.content !== undefined ? given : {content: given};
    return h('td', {class: kind, 'data-label': heads[i]}, content);
  };
  return h(
    'div', {class: 'scroll', tabindex: 0},
    h('table', {class: 'sheet'},
      h('thead', {}, h('tr', {}, heads.map(text => h('th', {scope: 'col'}, text)))),
      h('tbody', {}, rows.map(row => h('tr', {}, row.map(cell))))));
}

export const byGravity =
  findings => [...findings].sort((a, b) => (rank[b.severity] || 0) - (rank[a.severity] || 0));

/** The message of a finding, after the worst that came once it was raised, as in findings.cpp. */
export function findingText({message, code, worst, unit, ...raised}) {
  const {time_s: time = 0, value = 0} = worst || raised, text = message || code;
  if (time === (raised.time_s ?? 0) && value === (raised.value ?? 0)) return text;
  const isLength = unit === 'm', shown = Number((isLength ? 1e3 * value : value).toPrecision(3));
  const words = unit && unit !== '1' ? `${shown} ${isLength ? 'mm' : unit}` : `${shown}`;
  return `At worst ${words}, at ${fixed(time, 2)} s. ${text}`;
}

/** The gravest finding, with its remedy where it names one, in one line. */
export function gravestFinding(findings) {
  const [gravest, ...others] = byGravity(findings);
  if (!gravest) return h('p', {class: 'verdict soft'}, 'No findings.');
  const severity = severityText[worst([gravest])], remedy = gravest.remedy;
  return h(
    'p', {class: 'verdict'}, h('span', {class: `tag ${severity}`}, severity),
    ` ${findingText(gravest)}`, remedy ? h('strong', {}, ` ${remedy}`) : null,
    others.length ? h('small', {}, ` and ${others.length} more`) : null);
}

/** What the program is for: on pages that are looked at while metal flows. */
export const purpose = () => h(
  'p', {class: 'soft'}, 'Screening and advice, not a safety system: the limits of your plant hold.');

/** The findings of a job as a list, the gravest first. */
export function findingList(findings) {
  if (findings.length === 0) return h('p', {class: 'soft'}, 'No findings.');
  return h('ul', {class: 'findings'}, byGravity(findings).map(finding => {
    const grave = (finding.severity || '').toLowerCase();
    return h(
      'li', {}, h('span', {class: `tag ${grave}`}, grave), ' ', findingText(finding),
      finding.remedy ? h('strong', {}, ` ${finding.remedy}`) : null);
  }));
}
