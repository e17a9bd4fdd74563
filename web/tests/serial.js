// The test of Web Serial in a browser; serial.py serves it and judges its results. The page with a link is in a frame,
// so that it can be left; this outer page holds the board, the stand-in for the port, and the written bytes.

import init, * as program from "./sonoglyph.js";
import { StandIn } from "./stand-in.js";

const wait = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

async function until(what, condition) {
  for (let begun = performance.now(); !condition(); await wait(2)) {
    if (performance.now() - begun > 30000) throw new Error(`timed out waiting for ${what}`);
  }
}

// A page with a stand-in for its serial ports.
async function pageWith(board) {
  const frame = document.createElement("iframe");
  frame.src = `${location.pathname}?inside`;
  document.body.append(frame);
  await until("the page in the frame", () => frame.contentWindow.program);
  const standIn = new StandIn(board).install(frame.contentWindow);
  return { frame, standIn, port: standIn.port, program: frame.contentWindow.program };
}

const hex = (bytes) => Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
const hexOf = (written) => written.map(({ bytes }) => hex(bytes)).join("");

// Whether a board plays the expected drive: the same elements sound, with the same phases up to a common offset.
// Amplitudes follow the envelope.
function plays(board, wanted) {
  const STEP = 1 / 64; // turns: both are rounded to a board's steps
  const playing = board.playing();
  const sounds = wanted.flatMap((value, n) => (n % 2 === 0 && value > 0 ? [n] : []));
  if (!playing.every((value, n) => n % 2 === 1 || value > 0 === sounds.includes(n))) return false;
  const turns = sounds.map((n) => (playing[n + 1] - wanted[n + 1]) / (2 * Math.PI));
  const off = turns.map((turn) => turn - turns[0]).map((turn) => Math.abs(turn - Math.round(turn)));
  return sounds.length > 0 && off.every((turn) => turn < STEP);
}

// Waits for the same, as the envelope may be in its pause.
async function comesToPlay(board, wanted) {
  for (let looks = 0; looks < 200; looks += 1) {
    if (plays(board, wanted)) return true;
    await wait(3);
  }
  return false;
}

const is_silent = (board) => board.playing().every((value, n) => n % 2 === 1 || value === 0);

// Opens a link through the browser's chooser, and waits until its board is ready.
async function connect(page, profile, scene, baud) {
  const { Sender, choose, ports } = page.program;
  const steps = {};
  steps.before = await ports();
  page.standIn.chooses = false;
  steps.declined = (await choose()) ?? null;
  page.standIn.chooses = true;
  steps.chosen = await choose();
  steps.after = await ports();
  const sender = new Sender(steps.chosen, profile, baud, scene);
  const told = [];
  const hear = () => {
    for (let event = sender.event(); event !== undefined; event = sender.event()) told.push(event);
  };
  await until("the board", () => (hear(), sender.is_ready()));
  return { sender, told, hear, steps };
}

// Measures the longest time (ms) that blocks the page in the frame.
function watch(page) {
  let longest = 0;
  let last = performance.now();
  const timer = page.frame.contentWindow.setInterval(() => {
    const now = performance.now();
    longest = Math.max(longest, now - last);
    last = now;
  }, 4);
  return () => (page.frame.contentWindow.clearInterval(timer), longest);
}

// A scene at rest for a second, and the end of its link.
async function still({ profile, scene, baud }) {
  const board = new program.Board(profile);
  const page = await pageWith(board);
  const { sender, told, hear, steps } = await connect(page, profile, scene, baud);
  const wanted = Array.from(sender.show());
  const longest = watch(page);
  await until("the sound", () => sender.is_in_place());
  await wait(1000);
  const held = longest();
  const is_played = await comesToPlay(board, wanted);
  hear();
  const figures = Array.from(sender.figures());
  sender.free();
  await until("the end", () => page.port.events.at(-1) === "close" && !page.port.writable);
  await wait(50);
  return { steps, told, is_played, is_silent: is_silent(board), figures, held, events: page.port.events, bytes: hexOf(page.port.written) };
}

// A drag: one request per frame of the screen. The board ends with the last of them.
async function drag({ profile, scene, baud }) {
  const board = new program.Board(profile);
  const page = await pageWith(board);
  const { sender } = await connect(page, profile, scene, baud);
  const longest = watch(page);
  sender.one(0);
  await until("the sound", () => sender.is_in_place());
  board.frames();
  const begun = performance.now();
  let wishes = 0;
  for (; performance.now() - begun < 2000; wishes += 1) {
    sender.one(wishes % 256);
    await wait(16);
  }
  const seconds = (performance.now() - begun) / 1e3;
  sender.one(7);
  await until("the last", () => sender.is_in_place());
  await wait(100);
  const is_last = board.playing().every((value, n) => n % 2 === 1 || value > 0 === (n === 14));
  const figures = Array.from(sender.figures());
  const frames = board.frames();
  const held = longest();
  sender.free();
  await until("the end", () => !page.port.writable);
  return { wishes, frames, seconds, is_last, figures, held };
}

// The board is unplugged and plugged in; then the page is left in each of three ways, or its program fails.
async function loss({ profile, scene, baud }) {
  const board = new program.Board(profile);
  const page = await pageWith(board);
  const { sender, told, hear } = await connect(page, profile, scene, baud);
  const wanted = Array.from(sender.show());
  await until("the sound", () => sender.is_in_place());
  page.port.unplug();
  await until("the loss", () => (hear(), told.some((event) => event.startsWith("lost"))));
  await wait(600);
  hear();
  page.port.plug();
  await until("the board again", () => (hear(), sender.is_ready()));
  await until("the sound again", () => sender.is_in_place());
  await wait(300);
  const is_played = await comesToPlay(board, wanted);
  page.port.is_stuck = true;
  await until("the stall", () => (hear(), told.some((event) => event.includes("takes no bytes"))));
  page.port.is_stuck = false;
  await until("the board once more", () => (hear(), sender.is_ready()));
  hear();
  // The next link waits for the end of this one.
  sender.free();
  const next = new page.program.Sender(await page.program.choose(), profile, baud, scene);
  await until("the next link", () => next.is_ready());
  const again = next.event();
  next.free();
  await until("the end", () => !page.port.writable);
  return { told, again, is_played };
}

async function left({ profile, scene, baud }, how) {
  const board = new program.Board(profile);
  const page = await pageWith(board);
  const { sender } = await connect(page, profile, scene, baud);
  sender.show();
  await until("the sound", () => sender.is_in_place());
  await wait(200);
  const before = page.port.written.length;
  const calls = {
    address: () => (page.frame.src = "about:blank"),
    removed: () => page.frame.remove(),
    failed: () => page.frame.contentWindow.failSoon(),
  };
  calls[how]();
  await wait(500);
  const after = page.port.written.slice(before);
  await wait(100);
  return { is_silent: is_silent(board), last: hexOf(after) };
}

// Bit rates that a board or an adapter does not support.
async function rates({ scene }) {
  const page = await pageWith(new program.Board("native"));
  page.port.impossible = [3000000];
  const found = {};
  await page.program.choose();
  const [name] = await page.program.ports();
  for (const [profile, baud] of [["native", 9000000], ["native", 3000000], ["sonicsurface", 3000000]]) {
    const sender = new page.program.Sender(name, profile, baud, scene);
    let event;
    await until("a refusal", () => (event = sender.event()) !== undefined);
    found[`${profile} ${baud}`] = event;
    sender.free();
    await wait(1200);
  }
  return found;
}

// Sound and darkness alternate at the requested rate.
async function swaps({ scene }) {
  const board = new program.Board("sonicsurface");
  const page = await pageWith(board);
  const { sender, told, hear } = await connect(page, "sonicsurface", scene, undefined);
  const longest = watch(page);
  sender.show();
  await until("the sound", () => sender.is_in_place());
  await wait(2000);
  hear();
  const figures = Array.from(sender.figures());
  const frames = board.frames();
  const held = longest();
  sender.free();
  await until("the end", () => !page.port.writable);
  return { told, figures, frames, held };
}

// The survey of board and line: each rate is tried on a port closed and opened for it.
async function survey() {
  const board = new program.Board("native");
  const page = await pageWith(board);
  page.port.impossible = [230400];
  const name = await page.program.choose();
  const found = await page.program.survey(name);
  await until("the end", () => !page.port.writable);
  return { found, events: page.port.events };
}

async function run(tasks) {
  const parts = { still, drag, loss, rates, survey, swaps, left: (task) => left(task, task.how) };
  const found = {};
  for (const task of tasks) {
    try {
      found[task.name] = await parts[task.part](task);
    } catch (error) {
      found[task.name] = { error: `${error?.message ?? error}\n${error?.stack ?? ""}` };
    }
    document.querySelectorAll("iframe").forEach((frame) => frame.remove());
  }
  return found;
}

await init();
if (location.search === "?inside") {
  globalThis.failSoon = () => setTimeout(() => program.fail(), 0);
  globalThis.program = program;
} else {
  const tasks = await (await fetch("/tasks")).json();
  await fetch("/found", { method: "POST", body: JSON.stringify(await run(tasks)) });
}
