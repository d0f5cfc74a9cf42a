// The events of several jobs over one connection: HTTP/1.1 permits six to a server, and a browser
// has them for all of its tabs together. Jobs that are followed at once have their turns.
import {stream} from './api.js';

const turn = 500;    // ms of a job while others wait
const pause = 1000;  // ms behind a stream that broke

export class EventTurns {
  #jobs = new Map();  // sets of followers by job
  #now = null;        // whose turn it is: {id, end: an AbortController, most: its duration}
  #isServing = false;

  /**
   * Follows a job from its first event on.
   * @param take  called with each event, once
   * @param end   called once, with the fault that ends it, or null behind the last event
   * @return stops following
   */
  add(id, take, end) {
    const follower = {next: 1, take, end};
    if (!this.#jobs.has(id)) this.#jobs.set(id, new Set());
    this.#jobs.get(id).add(follower);
    const now = this.#now;
    if (now && !now.most) setTimeout(() => now.end.abort(), turn);
    this.#serve();
    return () => {
      this.#jobs.get(id)?.delete(follower);
      if (this.#jobs.get(id)?.size) return;
      this.#jobs.delete(id);
      if (this.#now?.id === id) this.#now.end.abort();
    };
  }

  async #serve() {
    if (this.#isServing) return;
    this.#isServing = true;
    while (this.#jobs.size) {
      const [id, followers] = this.#jobs.entries().next().value;
      this.#jobs.delete(id);  // behind the others
      this.#jobs.set(id, followers);
      await this.#turnOf(id, followers);
    }
    this.#isServing = false;
  }

  /** Hands events to all followers of a job, until it ends, or others have waited long enough. */
  async #turnOf(id, followers) {
    // The server ends a turn, so that the connection stays for the next one.
    const end = new AbortController(), most = this.#jobs.size > 1 ? turn : undefined;
    this.#now = {id, end, most};
    const first = Math.min(...[...followers].map(follower => follower.next));
    const take = event => {
      for (const follower of followers) {
        if (event.sequence < follower.next) continue;
        follower.next = event.sequence + 1;
        follower.take(event);
      }
    };
    const conclude = fault => {
      this.#jobs.delete(id);
      for (const follower of followers) follower.end(fault);
    };
    try {
      await stream('WatchJob', {id, from_sequence: first}, end.signal, take, most);
      conclude(null);
    } catch (fault) {
      if (end.signal.aborted || fault.code === 'deadline_exceeded') return;
      if (fault.code && fault.code !== 'unavailable') return conclude(fault);
      await new Promise(resolve => { setTimeout(resolve, pause); });
    } finally {
      this.#now = null;
    }
  }
}
