// The page around rerun's viewer: large figures, and a stream that is opened again whenever it was lost.
//
// `wasm_bindgen` comes from re_viewer.js, the program that rerun publishes for browsers.
"use strict";

// How often the figures are asked for, ms.
const ASK_EVERY = 500;
// How long an answer may take, ms: longer than a browser without a graphics card draws one picture.
const ANSWER_LIMIT = 10000;
// The stream has stopped when nothing arrived between so many answers while the run went on. Answers are counted, not
// seconds: a browser that is too slow hears few of them, and something always arrives in between.
const STREAM_STOPPED = 40;

const query = new URLSearchParams(location.search);
const at = (id) => document.getElementById(id);

/** The viewer once it runs. */
let viewer = null;
/** What the stream is known by: its address, the process that gives it, the recording that was brought to the front. */
let stream = { url: null, instance: null, recording: null };
/** Up to where the stream reached, where the run was then, and how many answers were heard since. */
let arrived = { newest: null, time_s: 0, answers: 0 };
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

/** Opens the stream. rerun does not open one a second time: for that the page loads itself again. */
function open(status) {
  if (stream.url) {
    location.reload();
    return;
  }
  const url = `rerun+http://${location.host.replace(/:\d+$/, "")}:${status.stream_port}/proxy`;
  viewer.add_receiver(url);
  stream = { url, instance: status.instance, recording: null };
  arrived = { newest: arrived.newest, time_s: status.time_s, answers: 0 };
  document.body.dataset.instance = status.instance;
}

/** Up to where the viewer holds the run, in the timeline's own unit. */
function newest(status) {
  return viewer.get_timeline_time_range(status.recording, status.timeline)?.max ?? null;
}

/** Whether nothing arrives any more though the run goes on. */
function stopped(status) {
  const reached = newest(status);
  if (reached !== arrived.newest) arrived = { newest: reached, time_s: status.time_s, answers: 0 };
  arrived.answers += 1;
  document.body.dataset.newest = String(reached);
  return arrived.answers > STREAM_STOPPED && status.time_s > arrived.time_s + 1;
}

function look_after(status) {
  if (!viewer) return;
  if (stream.instance !== status.instance) open(status);
  else if (status.recording && stopped(status)) open(status);
  // A new run comes to the front once; after that the operator may look at another. rerun itself brings to the front
  // what every opened stream begins with, an empty recording that belongs to no run.
  const of_a_run = viewer.get_active_recording_id()?.startsWith("run-");
  if (status.recording && !(of_a_run && stream.recording === status.recording) && newest(status) != null) {
    viewer.set_active_recording_id(status.recording);
    stream.recording = status.recording;
  }
}

async function ask() {
  try {
    const answer = await fetch("status", { cache: "no-store", signal: AbortSignal.timeout(ANSWER_LIMIT) });
    heard = await answer.json();
    draw(heard);
    look_after(heard);
    banner("");
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
  viewer = handle;
  window.viewer = handle;
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
