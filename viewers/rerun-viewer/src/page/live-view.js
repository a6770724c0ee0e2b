// The page around rerun's viewer: large figures, and what is drawn, fetched as fast as the viewer takes it in.
"use strict";

// How often the figures are asked for, ms.
const ASK_EVERY = 500;
// How often it is looked whether the viewer has taken in what it was given, ms.
const LOOK_EVERY = 100;
// How long an answer may take, ms: longer than a browser without a graphics card draws one picture.
const ANSWER_LIMIT = 10000;
// How long it may take to fetch what was drawn, ms: megabytes at first, over a slow line at that.
const FETCH_LIMIT = 60000;
// How long the viewer may take to take in what it was given before it is given more regardless, ms.
const TAKE_LIMIT = 20000;
// Failed fetches in a row before a warning is shown.
const FAILURES_TOLD = 8;
// Lag up to which the past is fetched besides the present, and from which on the strip warns, s.
const LAG_TO_LOOK_BACK = 1;
const LAG_TOLD = 3;
// How often a portion of the past is fetched, ms: it costs a browser without a graphics card a picture or two.
const LOOK_BACK_EVERY = 2000;
// Most pixels that are drawn without a graphics card; what more the window has is filled by enlarging them.
const SOFTWARE_PIXELS = 550000;
// rerun's name for the way by which what was drawn enters.
const CHANNEL = "live view";

const query = new URLSearchParams(location.search);
const at = (id) => document.getElementById(id);

/** The viewer once it runs. */
let viewer = null;
/** The process that draws, and the number of the frame to come. */
let fetched = { instance: null, next: 0 };
/** Ranges of frames that were skipped because newer ones were there, the newest last. */
let gaps = [];
/** What the viewer was given last, and when. */
let given = null;
/** When a portion of the past was fetched last. */
let looked_back = 0;
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
  // Zero takes the sign from what rounds to zero.
  return value == null ? "–" : (Number(value.toFixed(digits)) + 0).toFixed(digits).replace("-", "−");
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
  if (us == null) return "–";
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
  status.readings.forEach(({ name, value, decimals }, place) => {
    const id = ["angle", "velocity", "torque"][place];
    show(id, figure(value, decimals));
    show(`${id}-name`, name);
  });
  if (status.sticking == null) show("motion", "–");
  else show("motion", status.sticking ? "sticking" : "slipping", status.sticking ? "sticking" : "good");
  show("enough", all ? `${known} of ${all}` : "–", all && known === all ? "good" : "wait");
  show("missed", String(status.missed_ticks ?? "–"), status.missed_ticks ? "bad" : "");
  show("lateness", lateness(status.max_lateness_us));
  chips(
    "parameters",
    status.parameters.map(({ name, enough }) => ({
      text: enough ? name : `${name} not yet`,
      className: enough ? "good" : "wait",
    })),
  );
  const processes = status.processes.map(({ name, condition, alarm }) => ({
    text: condition === "alive" ? name : `${name} ${condition}`,
    className: alarm ? "bad" : "good",
  }));
  const behind = status.finished ? null : lag();
  if (behind != null) processes.push({ text: `plots ${behind.toFixed(1)} s behind`, className: behind > LAG_TOLD ? "wait" : "good" });
  chips("processes", processes);
}

/** Up to where the viewer holds a recording, ns. */
function newest(recording) {
  return viewer.get_timeline_time_range(recording, heard.timeline)?.max ?? null;
}

/** How far what is drawn lies behind the figures, s. */
function lag() {
  const reached = viewer && heard?.recording ? newest(heard.recording) : null;
  return reached == null ? null : Math.max(heard.time_s - reached / 1e9, 0);
}

function look_after(status) {
  if (!viewer || !status.recording) return;
  const reached = newest(status.recording);
  document.body.dataset.newest = String(reached);
  // A new run comes to the front once; after that the operator may look at another. rerun itself brings to the front
  // what came first, an empty recording that belongs to no run.
  const of_a_run = viewer.get_active_recording_id()?.startsWith("run-");
  if (!(of_a_run && shown === status.recording) && reached != null) {
    viewer.set_active_recording_id(status.recording);
    shown = status.recording;
  }
}

/** Fetches what was drawn and hands it to the viewer; gives what was in it. */
async function fetch_drawn(wanted) {
  const question = `drawn?instance=${fetched.instance}&${wanted}`;
  const answer = await fetch(question, { cache: "no-store", signal: AbortSignal.timeout(FETCH_LIMIT) });
  if (!answer.ok) throw new Error(`${question}: ${answer.status}`);
  const bytes = new Uint8Array(await answer.arrayBuffer());
  const head_length = bytes.indexOf("\n".charCodeAt(0));
  const contents = JSON.parse(new TextDecoder().decode(bytes.subarray(0, head_length)));
  const file = bytes.subarray(head_length + 1);
  if (file.length) {
    viewer.send_rrd_to_channel(CHANNEL, file);
    if (contents.recording) given = { ...contents, at: performance.now() };
  }
  return contents;
}

/** Whether the viewer has taken in what it was given: what it is given faster than that waits, and makes it show the past. */
function has_taken() {
  if (document.hidden) return false;
  if (!given || performance.now() - given.at > TAKE_LIMIT) return true;
  return newest(given.recording) >= given.newest_ns;
}

async function fetch_present() {
  const contents = await fetch_drawn(`from=${fetched.next}`);
  if (contents.instance !== fetched.instance) {
    gaps = [];
    fetched = { instance: contents.instance, next: 0 };
    document.body.dataset.instance = fetched.instance;
  }
  if (contents.first > fetched.next) gaps.push({ from: fetched.next, to: contents.first });
  fetched.next = contents.next;
}

async function fetch_past() {
  looked_back = performance.now();
  const gap = gaps.at(-1);
  const contents = await fetch_drawn(`from=${gap.from}&to=${gap.to}`);
  // Another process answers: the next question for the present begins anew.
  if (contents.instance !== fetched.instance) return;
  gap.to = contents.first;
  if (gap.to <= gap.from) gaps.pop();
}

/** Fetches what is new once the viewer has shown the last of it, and a portion of the past now and then if it keeps up. */
async function follow() {
  try {
    if (has_taken()) {
      const keeps_up = lag() < LAG_TO_LOOK_BACK && performance.now() - looked_back > LOOK_BACK_EVERY;
      await fetch_present();
      if (gaps.length && (keeps_up || heard?.finished)) await fetch_past();
    }
    failures = 0;
  } catch (error) {
    // The next answer goes on where the last one ended.
    failures += 1;
    console.debug(`nothing drawn: ${error}`);
  }
  setTimeout(follow, LOOK_EVERY);
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

/** Whether the browser draws without a graphics card. */
function draws_in_software() {
  const context = document.createElement("canvas").getContext("webgl2");
  const info = context?.getExtension("WEBGL_debug_renderer_info");
  const renderer = info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  context?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(renderer);
}

/** Lays the viewer's frame out so that it draws at most so many pixels, and enlarges it to fill its place. */
function fit(most_pixels) {
  const { clientWidth: width, clientHeight: height } = document.querySelector("main");
  const scale = Math.max(1, Math.sqrt((width * height * devicePixelRatio ** 2) / most_pixels));
  Object.assign(at("viewer").style, {
    width: `${width / scale}px`,
    height: `${height / scale}px`,
    transform: `scale(${scale})`,
  });
}

async function load() {
  const in_software = draws_in_software();
  const most_pixels = in_software ? SOFTWARE_PIXELS : Infinity;
  new ResizeObserver(() => fit(most_pixels)).observe(document.querySelector("main"));
  const frame = at("viewer");
  frame.src = "plots";
  await new Promise((loaded) => frame.addEventListener("load", loaded, { once: true }));
  const progress = (share) => show("loading", `loading the viewer: ${Math.round(100 * share)} %`);
  const handle = await frame.contentWindow.start(in_software, query, progress);
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
