// Timers. A worker's are exact to about a millisecond and go on in a page that is hidden; the page's own are held to 4 ms, and to a
// second when it is hidden. They serve where no worker may be had.

const SOURCE = "onmessage = ({ data: [id, ms] }) => setTimeout(() => postMessage(id), ms);";

let worker;
let count = 0;
const waiting = new Map();

function wake(id) {
  waiting.get(id)?.();
  waiting.delete(id);
}

function give_up() {
  worker = null;
  // What waits has waited for some of its time already.
  [...waiting.keys()].forEach(wake);
}

function begin() {
  try {
    const address = URL.createObjectURL(new Blob([SOURCE], { type: "text/javascript" }));
    worker = new Worker(address);
    worker.onmessage = ({ data }) => wake(data);
    worker.onerror = give_up;
  } catch {
    worker = null;
  }
}

export function pause(ms) {
  if (worker === undefined) begin();
  return new Promise((resolve) => {
    if (!worker) {
      setTimeout(resolve, ms);
      return;
    }
    count += 1;
    waiting.set(count, resolve);
    worker.postMessage([count, ms]);
  });
}
