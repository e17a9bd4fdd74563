// A second instance of the program for long computations. The first message is the compiled module.
import { initSync, work } from "./sonoglyph.js";

let ready = false;
onmessage = ({ data }) => {
  if (!ready) {
    initSync({ module: data });
    ready = true;
    return;
  }
  const made = work(...data);
  postMessage(made, [made.buffer]);
};
