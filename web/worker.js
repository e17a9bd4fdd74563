// Another copy of the program beside the page, for what takes long. The first message is the compiled program.
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
