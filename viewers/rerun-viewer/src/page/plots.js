// rerun's viewer in a frame of its own, so that the page around it can have it draw fewer pixels than it covers.
//
// `wasm_bindgen` comes from re_viewer.js, the program that rerun publishes for browsers.
"use strict";

/**
 * Has time stand still for rerun while it draws a picture. In each it takes in messages until 10 ms have passed by the clock;
 * on a loaded machine that is one message, and thirty of them take thirty pictures.
 */
function take_in_everything() {
  const draw_next = window.requestAnimationFrame.bind(window);
  const now = performance.now.bind(performance);
  let begun = null;
  performance.now = () => begun ?? now();
  window.requestAnimationFrame = (draw) =>
    draw_next((time) => {
      begun = now();
      try {
        draw(time);
      } finally {
        begun = null;
      }
    });
}

/** Loads and starts the viewer; `progress` hears which share of it is here. */
window.start = async (in_software, query, progress) => {
  if (in_software) {
    // rerun smooths edges by drawing each pixel four times, which without a graphics card takes a third of the time.
    const { prototype } = WebGL2RenderingContext;
    const allocate = prototype.renderbufferStorageMultisample;
    prototype.renderbufferStorageMultisample = function (target, _, ...rest) {
      return allocate.call(this, target, 0, ...rest);
    };
  }
  const response = await fetch("re_viewer_bg.wasm");
  const total = Number(response.headers.get("content-length"));
  let loaded = 0;
  const counted = new TransformStream({
    transform(portion, out) {
      loaded += portion.byteLength;
      if (total) progress(loaded / total);
      out.enqueue(portion);
    },
  });
  await wasm_bindgen(new Response(response.body.pipeThrough(counted), { headers: response.headers }));
  const viewer = new wasm_bindgen.WebHandle({
    url: [],
    manifest_url: null,
    render_backend: query.get("renderer"),
    video_decoder: null,
    hide_welcome_screen: true,
    panel_state_overrides: { top: "Hidden", blueprint: "Hidden", selection: "Hidden" },
    enable_history: false,
    notebook: false,
    // A layout that the browser remembers from an earlier version would hide this one.
    persist: false,
    theme: query.get("theme"),
  });
  take_in_everything();
  await viewer.start(document.getElementById("canvas"));
  return viewer;
};
