// A stand-in for `navigator.serial`: one port, which records all bytes written to it and answers like the board behind
// it.
//
// A board has `write(bytes)`, `read()` (its answers since the last call, a Uint8Array) and `set_baud(baudRate)`.
// Without a board the line does not answer.

const BITS = 10; // of a byte on the line
const TICK = 1; // ms between reads of the board's answers

const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const refused = (name, message) => new DOMException(message, name);

class Port extends EventTarget {
  // `usb`: the browser's description of the adapter.
  constructor(board, usb = { usbVendorId: 0x0403, usbProductId: 0x6010 }) {
    super();
    Object.assign(this, { board, usb, connected: true, readable: null, writable: null });
    // All written data: { at (ms), baudRate, bytes }.
    this.written = [];
    // The port's events in order: "open 921600", "close".
    this.events = [];
    // Unsupported rates; a stuck port accepts no bytes.
    this.impossible = [];
    this.is_stuck = false;
  }

  getInfo() {
    return this.usb;
  }

  async open({ baudRate, bufferSize = 255 }) {
    if (this.readable || this.writable) throw refused("InvalidStateError", "The port is already open.");
    if (!(baudRate > 0)) throw new TypeError("Requested baud rate must be greater than zero.");
    if (!this.connected || this.impossible.includes(baudRate)) throw refused("NetworkError", "Failed to open serial port.");
    await wait(1);
    this.events.push(`open ${baudRate}`);
    this.board?.set_baud(baudRate);
    // The time at which the line will have carried all bytes.
    let free = performance.now();
    const carry = async (bytes) => {
      while (this.is_stuck) await wait(5);
      if (!this.connected) throw refused("NetworkError", "The device has been lost.");
      const at = performance.now();
      this.written.push({ at, baudRate, bytes: bytes.slice() });
      this.board?.write(bytes);
      free = Math.max(free, at) + (bytes.length * BITS * 1e3) / baudRate;
      const rest = free - at - (bufferSize * BITS * 1e3) / baudRate;
      if (rest > 0) await wait(rest);
    };
    this.writable = new WritableStream({
      write: carry,
      close: async () => {
        while (performance.now() < free) await wait(1);
      },
    });
    const look = (controller) => {
      const bytes = this.board?.read() ?? [];
      if (bytes.length > 0) controller.enqueue(bytes);
    };
    this.readable = new ReadableStream({
      start: (controller) => {
        this.reading = controller;
        this.ticking = setInterval(() => look(controller), TICK);
      },
      cancel: () => clearInterval(this.ticking),
    });
  }

  async close() {
    if (this.readable?.locked || this.writable?.locked) throw new TypeError("Cannot cancel a locked stream");
    clearInterval(this.ticking);
    this.readable = this.writable = null;
    this.events.push("close");
  }

  // Unplugs the port.
  unplug() {
    this.connected = false;
    const reading = this.reading;
    clearInterval(this.ticking);
    this.readable = this.writable = null;
    reading?.error(refused("NetworkError", "The device has been lost."));
    this.dispatchEvent(new Event("disconnect"));
  }

  plug() {
    this.connected = true;
    this.dispatchEvent(new Event("connect"));
  }
}

export class StandIn extends EventTarget {
  constructor(board) {
    super();
    this.port = new Port(board);
    // The user chooses the port, or dismisses the browser's dialog.
    this.chooses = true;
    this.granted = [];
  }

  async getPorts() {
    return this.granted;
  }

  async requestPort() {
    if (!this.chooses) throw refused("NotFoundError", "No port selected by the user.");
    if (!this.granted.includes(this.port)) this.granted.push(this.port);
    return this.port;
  }

  // Replaces the browser's own in a page.
  install(page = globalThis) {
    Object.defineProperty(page.navigator, "serial", { value: this, configurable: true });
    return this;
  }
}
