// The history of a run: its accepted steps, as StepReport has them, each once.

/** Adds a step. Those from its number on are taken back: the run was resumed before it. */
export function addStep(steps, step) {
  while (steps.length > 0 && steps.at(-1).step >= step.step) steps.pop();
  steps.push(step);
}

/** The monitors of a history by their names, in the order in which they were first reported. */
const monitorsOf = steps => [...new Set(steps.flatMap(step => step.monitors.map(m => m.name)))];

const figures = ({monitors}, name) => monitors.find(m => m.name === name) || {name};

/** The last figures of every monitor. */
export const lastMonitors =
  steps => monitorsOf(steps).map(name => figures(steps.at(-1), name));

/** States in which a job has no further step. */
export const ended = new Set(['SUCCEEDED', 'FAILED', 'CANCELLED']);

/** Whether the curls of a job are an answer, or will be one: it has not failed and has stayed valid. */
export const isSound = job => job.state !== 'FAILED' && !job.validity_loss;

/** The monitor whose curl is judged; none before the first step, and of a run that is no answer. */
export const judgedMonitor = job =>
  isSound(job) ? (job.last_step?.monitors || []).find(m => m.judged) : undefined;

/** Whether two histories have not cast the same length at the time that both have reached. */
export function lengthsDiffer(first, other) {
  if (!first.length || !other.length) return false;
  const until = Math.min(first.at(-1).time_s, other.at(-1).time_s);
  const [mine, theirs] =
    [first, other].map(steps => steps.findLast(step => step.time_s <= until)?.cast_length_m ?? 0);
  return Math.abs(mine - theirs) > 0.01 * Math.max(mine, theirs);
}

/** The curls of a history with their bands, in mm, against time or against cast length in mm. */
export const curlLines = (steps, suffix = '', byLength = false) => monitorsOf(steps).map(name => {
  const x = steps.map(step => byLength ? 1e3 * step.cast_length_m : step.time_s);
  const known = steps.map(step => figures(step, name));
  const inMm = of => known.map(m => 1e3 * (of(m) ?? NaN));
  const line = {name: name + suffix, monitor: name, x, y: inMm(m => m.curl_m)};
  if (!Number.isFinite(known.at(-1).curl_upper_error_m)) return line;
  return {
    ...line,
    low: inMm(m => m.curl_m - m.curl_lower_error_m),
    high: inMm(m => m.curl_m + m.curl_upper_error_m)
  };
});
