// Serial ports as a browser lets a page have them (Web Serial).

// Bytes that the browser holds in either direction.
const BUFFER = 8192;
// ms in which a closing line sends its remaining bytes.
const PATIENCE = 1000;
// ms between two looks at it.
const MOMENT = 10;

const serial = () => globalThis.navigator?.serial;

// The name that a port was given when it was first seen. Ports have none of their own, and two adapters may be of one kind.
const names = new WeakMap();
// When a port's last line has ended, which it must have before the next begins.
const endings = new WeakMap();
// Those that are open.
const lines = new Set();
// The program in this page has a fault, and may not go on.
let has_failed = false;

const hex = (number) => number.toString(16).padStart(4, "0");

function kind(port) {
  const { usbVendorId, usbProductId, bluetoothServiceClassId } = port.getInfo();
  if (usbVendorId !== undefined) return `USB ${hex(usbVendorId)}:${hex(usbProductId ?? 0)}`;
  return bluetoothServiceClassId === undefined ? "serial port" : "Bluetooth port";
}

// The ports that the user has let this page have and that are plugged in, by name.
async function granted() {
  const ports = (await serial().getPorts()).filter((port) => port.connected !== false);
  const taken = new Set(ports.map((port) => names.get(port)));
  for (const port of ports.filter((port) => !names.has(port))) {
    let name = kind(port);
    for (let number = 2; taken.has(name); number += 1) name = `${kind(port)} #${number}`;
    names.set(port, name);
    taken.add(name);
  }
  return new Map(ports.map((port) => [names.get(port), port]));
}

export const is_there = () => serial() !== undefined;

export async function available() {
  return is_there() ? [...(await granted()).keys()].sort() : [];
}

// The name of a port that the user chooses; nothing if they choose none.
export async function choose() {
  try {
    const port = await serial().requestPort();
    await granted();
    return names.get(port) ?? null;
  } catch (error) {
    if (error.name === "NotFoundError") return null;
    throw error;
  }
}

async function within(ms, work) {
  let timer;
  const late = new Promise((resolve) => {
    timer = setTimeout(resolve, ms, false);
  });
  const done = await Promise.race([work.then(() => true), late]);
  clearTimeout(timer);
  return done;
}

// An open port.
export class Line {
  constructor(port) {
    this.port = port;
    this.arrived = [];
    this.last = null;
    this.error = null;
    this.is_closing = false;
  }

  async begin(baudRate) {
    await this.port.open({ baudRate, bufferSize: BUFFER });
    this.baudRate = baudRate;
    this.is_closing = false;
    this.writer = this.port.writable.getWriter();
    this.listening = this.listen();
  }

  async listen() {
    // A byte that came spoiled ends a stream, and the port has a new one. A port that is gone has none.
    for (let stream = null; this.port.readable && this.port.readable !== stream && !this.is_closing; ) {
      stream = this.port.readable;
      this.reader = stream.getReader();
      try {
        for (let part = await this.reader.read(); !part.done; part = await this.reader.read()) {
          this.arrived.push(part.value);
          this.ring();
        }
      } catch (error) {
        this.spoiled = error;
      } finally {
        this.reader.releaseLock();
      }
    }
    if (!this.is_closing) this.fail(this.spoiled ?? new Error("the port was closed"));
  }

  fail(error) {
    this.error ??= error;
    this.ring();
  }

  ring() {
    this.wake?.();
    this.wake = undefined;
  }

  // Until something has arrived, nothing can arrive any more, or this is called again.
  arrives() {
    this.ring();
    return new Promise((resolve) => {
      this.wake = resolve;
      if (this.arrived.length > 0 || this.error) this.ring();
    });
  }

  take() {
    if (this.arrived.length === 0 && this.error) throw this.error;
    const parts = this.arrived.splice(0);
    const bytes = new Uint8Array(parts.reduce((length, part) => length + part.length, 0));
    parts.reduce((at, part) => (bytes.set(part, at), at + part.length), 0);
    return bytes;
  }

  // The bytes lie in the program's memory, so they are copied at once.
  async write(bytes) {
    const own = bytes.slice();
    if (this.error) throw this.error;
    await this.writer.write(own);
  }

  // A port's bit rate is set when it is opened. One that it cannot have leaves it as it was.
  async set_baud(baudRate) {
    const before = this.baudRate;
    await this.close();
    try {
      await this.begin(baudRate);
    } catch (error) {
      await this.begin(before);
      throw error;
    }
  }

  async close() {
    this.is_closing = true;
    try {
      const sent = this.writer.close().catch(() => {});
      if (!(await within(PATIENCE, sent))) this.writer.abort().catch(() => {});
      await this.reader?.cancel().catch(() => {});
      await this.listening;
      this.writer.releaseLock();
    } finally {
      await this.port.close();
    }
  }

  // Lets the port go when it has sent these. Whether it took them.
  leave(bytes) {
    const is_there = !this.error && this.writer !== undefined;
    if (is_there) this.writer.write(bytes.slice()).catch(() => {});
    this.end();
    return is_there;
  }

  // What is sent when the page is left, or the program in it fails.
  leave_behind(bytes) {
    this.last = bytes.slice();
  }

  end() {
    if (lines.delete(this)) endings.set(this.port, this.close().catch(() => {}));
  }
}

// One line of this page ends before the next begins.
async function ending(port) {
  const is_open = () => [...lines].some((line) => line.port === port);
  for (let waits = 0; is_open() && waits < PATIENCE / MOMENT; waits += 1) {
    await new Promise((resolve) => setTimeout(resolve, MOMENT));
  }
  await within(2 * PATIENCE, endings.get(port) ?? Promise.resolve());
}

export async function open(name, baudRate) {
  if (has_failed) throw new Error("this page has failed and has to be loaded again");
  const port = (await granted()).get(name);
  if (!port) return null;
  await ending(port);
  const line = new Line(port);
  await line.begin(baudRate);
  lines.add(line);
  return line;
}

// Nothing is written after it: the rest of the program must not make a board sound again.
function fall_silent(why) {
  for (const line of lines) {
    if (!line.last || line.error) continue;
    line.writer?.write(line.last).catch(() => {});
    line.fail(new Error(why));
  }
}

function fall_silent_after(error) {
  if (!(error instanceof WebAssembly.RuntimeError)) return;
  has_failed = true;
  fall_silent("this page has failed");
}

globalThis.addEventListener?.("pagehide", () => fall_silent("the page was left"));
globalThis.addEventListener?.("error", (event) => fall_silent_after(event.error));
globalThis.addEventListener?.("unhandledrejection", (event) => fall_silent_after(event.reason));
