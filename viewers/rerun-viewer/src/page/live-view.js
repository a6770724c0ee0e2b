// The page around rerun's viewer: large figures, and what is drawn, fetched piece by piece.
//
// `wasm_bindgen` comes from re_viewer.js, the program that rerun publishes for browsers.
"use strict";

// How often the figures are asked for, ms.
const ASK_EVERY = 500;
// How often what was drawn since is asked for, ms.
const FETCH_EVERY = 250;
// How long an answer may take, ms: longer than a browser without a graphics card draws one picture.
const ANSWER_LIMIT = 10000;
// How long it may take to fetch what was drawn, ms: megabytes at first, over a slow line at that.
const FETCH_LIMIT = 60000;
// So many failures to fetch in a row are told.
const FAILURES_TOLD = 8;
// rerun's name for the way by which the pieces enter.
const CHANNEL = "live view";

const query = new URLSearchParams(location.search);
const at = (id) => document.getElementById(id);

/** The viewer once it runs. */
let viewer = null;
/** Where this page stands: the process that draws, the number of the piece to come and of the oldest one here. */
let fetched = { instance: null, next: 0, oldest: 0, behind: false };
/** How often in a row nothing could be fetched. */
let failures = 0;
/** The recording that was brought to the front. */
let shown = null;
/** The last status that was heard. */
let heard = null;

function show(id, text, className = "") {
  const element = at(id);
  if (element.textContent !== text) element.textContent = text;
  if (element.className !== className) element.className = className;
}

function figure(value, digits) {
  return value == null ? "–" : value.toFixed(digits).replace("-", "−");
}

function chips(id, items) {
  const wanted = JSON.stringify(items);
  if (at(id).dataset.shown === wanted) return;
  at(id).dataset.shown = wanted;
  at(id).replaceChildren(
    ...items.map(({ text, className }) => {
      const item = document.createElement("li");
      item.textContent = text;
      item.className = className;
      return item;
    }),
  );
}

function lateness(us) {
  return us < 1000 ? `${us.toFixed(us < 10 ? 1 : 0)} µs` : `${(us / 1000).toFixed(1)} ms`;
}

function banner(text, calm = false) {
  at("banner").hidden = !text;
  show("banner", text, calm ? "calm" : "");
}

function draw(status) {
  const known = status.parameters.filter((parameter) => parameter.enough).length;
  const all = status.parameters.length;
  const long = status.state.length > 14 ? " long" : "";
  show("state", status.state, (status.alarm ? "bad" : "") + long);
  show("knob", status.knob);
  const planned = status.planned_s == null ? "" : ` of ${status.planned_s.toFixed(0)}`;
  show("time", status.recording ? `${status.time_s.toFixed(1)}${planned} s` : "");
  show("angle", figure(status.angle_rad, 2));
  show("velocity", figure(status.velocity_rad_s, 1));
  show("torque", figure(status.torque_mnm, 1));
  if (status.sticking == null) show("motion", "–");
  else show("motion", status.sticking ? "sticking" : "slipping", status.sticking ? "sticking" : "good");
  show("enough", all ? `${known} of ${all}` : "–", all && known === all ? "good" : "wait");
  show("missed", String(status.missed_ticks), status.missed_ticks ? "bad" : "");
  show("lateness", lateness(status.max_lateness_us));
  chips(
    "parameters",
    status.parameters.map(({ name, enough }) => ({
      text: enough ? name : `${name} not yet`,
      className: enough ? "good" : "wait",
    })),
  );
  chips(
    "processes",
    status.processes.map(({ name, condition, alarm }) => ({
      text: condition === "alive" ? name : `${name} ${condition}`,
      className: alarm ? "bad" : "good",
    })),
  );
}

/** Up to where the viewer holds the run, in the timeline's own unit. */
function newest(status) {
  return viewer.get_timeline_time_range(status.recording, status.timeline)?.max ?? null;
}

function look_after(status) {
  if (!viewer || !status.recording) return;
  const reached = newest(status);
  document.body.dataset.newest = String(reached);
  // A new run comes to the front once; after that the operator may look at another. rerun itself brings to the front
  // what came first, an empty recording that belongs to no run.
  const of_a_run = viewer.get_active_recording_id()?.startsWith("run-");
  if (!(of_a_run && shown === status.recording) && reached != null) {
    viewer.set_active_recording_id(status.recording);
    shown = status.recording;
  }
}

/** Fetches what was drawn, hands it to the viewer and notes where the page stands now. */
async function fetch_drawn(wish) {
  const question = `drawn?instance=${fetched.instance}&${wish}`;
  const answer = await fetch(question, { cache: "no-store", signal: AbortSignal.timeout(FETCH_LIMIT) });
  if (!answer.ok) throw new Error(`${question}: ${answer.status}`);
  const bytes = new Uint8Array(await answer.arrayBuffer());
  const head_length = bytes.indexOf("\n".charCodeAt(0));
  const standing = JSON.parse(new TextDecoder().decode(bytes.subarray(0, head_length)));
  const drawn = bytes.subarray(head_length + 1);
  if (drawn.length) viewer.send_rrd_to_channel(CHANNEL, drawn);
  fetched = { ...fetched, ...standing };
  document.body.dataset.instance = fetched.instance;
}

/** Goes on with what is new, and with a portion of the past if all of that is here. */
async function follow() {
  try {
    await fetch_drawn(`since=${fetched.next}`);
    if (!fetched.behind && fetched.oldest > 0) await fetch_drawn(`before=${fetched.oldest}`);
    failures = 0;
  } catch (error) {
    // The next answer goes on where the last one ended.
    failures += 1;
    console.debug(`nothing drawn: ${error}`);
  }
  setTimeout(follow, FETCH_EVERY);
}

async function ask() {
  try {
    const answer = await fetch("status", { cache: "no-store", signal: AbortSignal.timeout(ANSWER_LIMIT) });
    heard = await answer.json();
    draw(heard);
    look_after(heard);
    banner(failures < FAILURES_TOLD ? "" : "What is drawn below has stopped: it cannot be fetched, and is tried again. The figures above are right.");
  } catch (error) {
    if (heard?.finished) banner("The run has ended and its view with it. What was shown stays until this page is closed; a new run appears here by itself.", true);
    else banner("No answer from the live view: trying again twice a second. Captures go on without it.");
    console.debug(`no status: ${error}`);
  }
  setTimeout(ask, ASK_EVERY);
}

async function load() {
  const response = await fetch("re_viewer_bg.wasm");
  const total = Number(response.headers.get("content-length"));
  let loaded = 0;
  const counted = new TransformStream({
    transform(portion, out) {
      loaded += portion.byteLength;
      if (total) show("loading", `loading the viewer: ${Math.round((100 * loaded) / total)} %`);
      out.enqueue(portion);
    },
  });
  await wasm_bindgen(new Response(response.body.pipeThrough(counted), { headers: response.headers }));
  const handle = new wasm_bindgen.WebHandle({
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
  await handle.start(at("viewer"));
  at("loading").hidden = true;
  handle.open_channel(CHANNEL, "haptic camera");
  viewer = handle;
  window.viewer = handle;
  follow();
  setInterval(() => {
    // Out of memory or a defect in rerun: a fresh page has neither.
    if (handle.has_panicked()) location.reload();
  }, 2000);
}

ask();
load().catch((error) => {
  show("loading", `The viewer could not be loaded (${error}). Reload this page.`);
  console.error(error);
});
