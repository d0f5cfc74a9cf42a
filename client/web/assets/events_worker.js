// Follows jobs for all tabs of a browser. A tab names a lock that it holds as long as it is there.
import {EventTurns} from './event_turns.js';

const turns = new EventTurns();

self.onconnect = ({ports: [port]}) => {
  const leaving = new Map();  // by the number that the tab gives
  port.onmessage = ({data: {tab, number, id}}) => {
    if (tab) {
      navigator.locks.request(tab, () => {
        for (const leave of leaving.values()) leave();
      });
    } else if (id) {
      const send = message => port.postMessage({number, ...message});
      const plain = fault => fault && {code: fault.code, message: fault.message};
      leaving.set(number, turns.add(id, event => send({event}), fault => send({end: plain(fault)})));
    } else {
      leaving.get(number)?.();
      leaving.delete(number);
    }
  };
};
