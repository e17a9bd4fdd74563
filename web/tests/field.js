// The field of a scene file without the window; with `?jobs` the page runs the server's jobs and returns their numbers.
import init, { Field } from "./sonoglyph.js";

const SIZE = 512;
const PROGRAM = "sonoglyph_bg.wasm";
const element = name => document.getElementById(name);
const fields = new Map();

// A scene's field by one evaluator; everything unchanged from map to map is kept.
async function field(evaluator) {
  if (!fields.has(evaluator)) fields.set(evaluator, await Field.open(evaluator));
  return fields.get(evaluator);
}

function show(map, size) {
  const canvas = element("picture");
  [canvas.width, canvas.height] = [size, size];
  const image = new ImageData(size, size);
  // Maps have their lowest row first.
  for (let row = 0; row < size; row++) {
    image.data.set(map.colours.subarray(row * size * 4, (row + 1) * size * 4), (size - 1 - row) * size * 4);
  }
  canvas.getContext("2d").putImageData(image, 0, 0);
}

function times(map) {
  return { solving: map.solving, mapping: map.mapping, colouring: map.colouring };
}

async function draw(event) {
  event?.preventDefault();
  try {
    const own = await field(element("evaluator").value);
    const map = await own.map(element("scene").value, element("quantity").value, SIZE, SIZE);
    show(map, SIZE);
    const { solving, mapping, colouring } = times(map);
    element("word").textContent = `${own.evaluator}: ${map.how}\npeak ${map.peak.toPrecision(4)}, error ${map.error.toExponential(1)}`
      + `\nsolving ${solving.toFixed(1)} ms, map ${mapping.toFixed(1)} ms, colours ${colouring.toFixed(1)} ms`;
  } catch (error) {
    element("word").textContent = error?.message ?? String(error);
  }
}

// Runs a job: the map of a given drive, or the times of a drag from scene to scene.
async function done(job) {
  const own = await field(job.evaluator);
  if (job.drag) {
    const frames = [];
    for (const scene of job.drag) {
      const start = performance.now();
      const map = await own.drag(scene, job.quantity, job.size, job.size);
      frames.push({ ...times(map), all: performance.now() - start });
    }
    return { evaluator: own.evaluator, frames };
  }
  const map = job.phases
    ? await own.of_drive(job.scene, job.quantity, job.size, job.size, new Float64Array(job.phases), new Float64Array(job.amplitudes))
    : await own.map(job.scene, job.quantity, job.size, job.size);
  show(map, job.size);
  await fetch(`/values?${job.name}`, { method: "POST", body: map.values });
  return { evaluator: own.evaluator, how: map.how, peak: map.peak, error: map.error, ...times(map) };
}

async function work() {
  const jobs = await (await fetch("/jobs")).json();
  for (const job of jobs) {
    let answer;
    try {
      answer = await done(job);
    } catch (error) {
      answer = { problem: error?.message ?? String(error) };
    }
    await fetch(`/answer?${job.name}`, { method: "POST", body: JSON.stringify(answer) });
  }
  await fetch("/end", { method: "POST", body: navigator.userAgent });
}

if (location.search === "?jobs") {
  try {
    await init({ module_or_path: PROGRAM });
    await work();
  } catch (error) {
    await fetch("/problem", { method: "POST", body: error?.message ?? String(error) });
  }
} else {
  await init({ module_or_path: PROGRAM });
  element("wish").addEventListener("submit", draw);
  await draw();
}
