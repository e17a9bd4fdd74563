// A stand-in for `navigator.serial`: one port, which keeps all that is written to it and answers as the board behind it does.
//
// A board has `write(bytes)`, `read()` (what it has answered since, a Uint8Array) and `set_baud(baudRate)`. Without one the port is
// a line that nobody answers on.

const BITS = 10; // of a byte on the line
const TICK = 1; // ms between looks at the board's answers

const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const refused = (name, message) => new DOMException(message, name);

class Port extends EventTarget {
  // `usb`: what the browser says of the adapter.
  constructor(board, usb = { usbVendorId: 0x0403, usbProductId: 0x6010 }) {
    super();
    Object.assign(this, { board, usb, connected: true, readable: null, writable: null });
    // All that was written: { at (ms), baudRate, bytes }.
    this.written = [];
    // What happened to it, in order: "open 921600", "close".
    this.events = [];
    // Rates that it does not have; a port that is stuck takes no bytes.
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
    // When the line will have carried what was written.
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

  // Pulls the plug.
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
    // The user chooses the port, or closes the browser's window without choosing.
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

  // Takes the place of the browser's own in a page.
  install(page = globalThis) {
    Object.defineProperty(page.navigator, "serial", { value: this, configurable: true });
    return this;
  }
}
