// The events of jobs, by a worker that all tabs of the browser share.
import {EventTurns} from './event_turns.js';

/** What the worker follows for this tab; as EventTurns. */
class SharedTurns {
  #followers = new Map();
  #port = new SharedWorker('/events_worker.js', {type: 'module', name: 'dccast'}).port;

  constructor() {
    const tab = crypto.randomUUID();
    navigator.locks.request(tab, () => {
      this.#port.postMessage({tab});
      return new Promise(() => {});  // until the tab is gone
    });
    this.#port.onmessage = ({data: {number, event, end}}) => {
      const follower = this.#followers.get(number);
      if (event) return follower?.take(event);
      this.#followers.delete(number);
      follower?.end(end && Object.assign(new Error(end.message), {code: end.code}));
    };
  }

  add(id, take, end) {
    const number = crypto.randomUUID();
    this.#followers.set(number, {take, end});
    this.#port.postMessage({number, id});
    return () => {
      this.#followers.delete(number);
      this.#port.postMessage({number});
    };
  }
}

let turns;

/** The events of a job as they come, each once. Rejects at a fault. */
export function followJob(id, signal, take) {
  turns ??= globalThis.SharedWorker ? new SharedTurns() : new EventTurns();
  return new Promise((resolve, reject) => {
    const leave = turns.add(id, take, fault => fault ? reject(fault) : resolve());
    signal.addEventListener('abort', () => {
      leave();
      resolve();
    });
  });
}
