// Rates, attitude, body, prediction, alarms and health of Polhode, from a YAMCS server's WebSocket and archive. No libraries.
//   ?yamcs=PORT of the server, 8090   ?stale=SECONDS without a motion packet from which on what is shown is marked as old, 5
"use strict";

const wish = new URLSearchParams(location.search);
const port = wish.get("yamcs") || "8090", staleMs = 1000 * Number(wish.get("stale") || 5);
const server = `${location.hostname}:${port}`, instance = "polhode", processor = "realtime";
const samplesMax = 600, eventsShown = 8, lookAheads = 9;
const archiveMargin = 16;  // more than packets of one kind in a frame, and than come while the archive is asked
const of = (packet, ...fields) => fields.map(field => `${packet}_${field}`);
const each = (prefix, elements = axes) => elements.map(e => prefix + e), quaternion = "wxyz".split("");
const motionNames = of("motion", "frame", "flag_rate", ...each("w_T_rad_s_"));
const predictionNames = of("prediction", "timestamp_ns", "predicted_timestamp_ns", "flag_attitude", "flag_rate", "flag_position", "flag_scale_known",
  ...each("w_T_rad_s_"), ...each("p_CT_"));
const eventNames = of("event", "id", "severity", "text", "frame", "value_0", "value_1");
const names = [...motionNames, ...predictionNames, ...eventNames,
  ...of("motion", "mode", "flag_pose", "flag_velocity", "flag_scale_known", "sigma_att_rad", "sigma_pos", "sigma_rate_rad_s", "landmarks",
    "keyframes", ...each("q_CT_", quaternion), ...each("p_CT_"), ...each("v_C_")),
  ...of("shape", "flag_shape", "flag_cylinder", "flag_scale_known", ...each("q_TB_", quaternion), ...each("dimensions_"), ...each("sigma_dimensions_"),
    ...each("dimension_basis_"), "frame_source", "completion", "plane_count", "cloud_points", "cylinder_radius", "cylinder_length"),
  ...of("housekeeping", "frames_in", "frames_used", "frames_unreadable", "frames_dark", "poses", "lost", "commands_accepted", "commands_rejected",
    "last_command", "memory_octets", "table_crc")];
const now = {}, idOf = {}, cameAt = {};  // cameAt: ms of the server's clock, by which packets came
const predictions = new Map(), alarms = new Map();  // by look-ahead; by parameter
let rates = [], events = [];  // by time; the latest first
let serverAheadMs = 0, connected = false;

function number(value) {
  const key = { FLOAT: "floatValue", DOUBLE: "doubleValue", UINT32: "uint32Value", SINT32: "sint32Value", UINT64: "uint64Value",
    SINT64: "sint64Value", STRING: "stringValue", ENUMERATED: "stringValue", BOOLEAN: "booleanValue" }[value.type];
  const raw = value[key];
  return key === "stringValue" ? raw || "" : key === "booleanValue" ? Boolean(raw) : Number(raw || 0);
}

function rateOf(values, t) {
  return { t, w: values.motion_flag_rate ? three(values, "motion_w_T_rad_s_", degrees) : null };
}

function eventOf(values, t) {
  const codes = eventCodes[values.event_id] || [];
  const words = codes.map((code, i) => code && (codeNames[code][values[`event_value_${i}`]] || "unknown")).filter(Boolean);
  return { t, frame: values.event_frame, severity: values.event_severity, text: String(values.event_text).replace(/\0+$/, ""), words: words.join(" to ") };
}

// What came live and what the archive has overlap: of two of a time one is kept, but several events may be of one time.
function addRates(more) {
  const known = new Set(rates.map(s => s.t));
  rates = [...rates, ...more.filter(s => !known.has(s.t))].sort((a, b) => a.t - b.t).slice(-samplesMax);
}

function addEvents(more) {
  const known = new Set(events.map(e => `${e.t} ${e.text}`));
  events = [...more.filter(e => !known.has(`${e.t} ${e.text}`)), ...events].sort((a, b) => b.t - a.t).slice(0, eventsShown);
  eventList(events);
}

function addPrediction(values) {
  const made = predictionOf(values), old = predictions.get(made.ahead_s);
  if (!old || old.base <= made.base) predictions.set(made.ahead_s, made);
}

function take(values) {
  const times = {};
  for (const value of values) {
    const name = idOf[value.numericId];
    if (!name || !value.engValue) continue;
    now[name] = number(value.engValue);
    cameAt[name] = Date.parse(value.acquisitionTime);
    times[name] = Date.parse(value.generationTime);
  }
  if ("motion_frame" in times) addRates([rateOf(now, times.motion_frame)]);
  if ("prediction_timestamp_ns" in times) addPrediction(now);
  if ("event_id" in times) addEvents([eventOf(now, times.event_id)]);
  draw();
}

// The last values of a parameter, earliest first: [{t, nth, value}], the nth value of that time.
async function column(name, count) {
  const reply = await fetch(`http://${server}/api/archive/${instance}/parameters/polhode/${name}?order=desc&limit=${count}&source=replay`);
  const seen = new Map(), found = reply.ok ? (await reply.json()).parameter || [] : [];
  return found.reverse().map(one => {
    const t = Date.parse(one.generationTime), nth = seen.get(t) || 0;
    seen.set(t, nth + 1);
    return { t, nth, value: number(one.engValue) };
  });
}

// The last values of these parameters of one packet, earliest first: [{t, name: value...}]. Each parameter is asked for by itself, and
// packets come meanwhile: values are of one packet where their time is one, and their place among the values of that time.
async function archived(parameters, limit) {
  const columns = await Promise.all(parameters.map(name => column(name, limit + archiveMargin)));
  const places = columns.map(values => new Map(values.map(one => [`${one.t} ${one.nth}`, one.value])));
  return columns[0].slice(-limit).filter(one => places.every(place => place.has(`${one.t} ${one.nth}`))).map(one => ({ t: one.t,
    ...Object.fromEntries(parameters.map((name, n) => [name, places[n].get(`${one.t} ${one.nth}`)])) }));
}

// What came before the page was opened.
async function takeArchive() {
  const none = () => [];
  addEvents((await archived(eventNames, eventsShown).catch(none)).map(row => eventOf(row, row.t)).reverse());
  (await archived(predictionNames, lookAheads).catch(none)).forEach(addPrediction);
  addRates((await archived(motionNames, samplesMax).catch(none)).map(row => rateOf(row, row.t)));
  draw();
}

function takeAlarm(alarm) {
  const parameter = alarm.id.name, detail = alarm.parameterDetail || {};
  const latest = detail.currentValue || detail.triggerValue || {};
  // YAMCS leaves processOK where an alarm that is not acknowledged comes back: the value says it.
  const over = Boolean(alarm.processOK) && ["IN_LIMITS", undefined].includes(latest.monitoringResult);
  if (alarm.notificationType === "CLEARED" || (over && alarm.acknowledged)) alarms.delete(parameter);
  else alarms.set(parameter, { parameter, severity: alarm.severity, over, since: clock(Date.parse(alarm.triggerTime), 1),
    value: latest.engValue ? number(latest.engValue) : "" });
  alarmList([...alarms.values()]);
}

function span(ms) {
  const s = Math.max(0, ms) / 1000;
  return s < 100 ? s.toFixed(1) + " s" : s < 6000 ? Math.round(s / 60) + " min" : Math.round(s / 3600) + " h";
}

// How old what is shown is. By the server's clock: the reader's may be wrong, and a page that is opened later gets old values at once.
function drawAge() {
  const age = name => Date.now() + serverAheadMs - cameAt[name];
  const came = "motion_frame" in now, old = came && !(age("motion_frame") <= staleMs);
  element("age").textContent = came ? `motion ${span(age("motion_frame"))} ago` +
    ("housekeeping_frames_in" in now ? `, health ${span(age("housekeeping_frames_in"))} ago` : "") : "";
  element("stale").hidden = !old && (connected || !came);
  element("stale").textContent = old ? `STALE: no motion packet for ${span(age("motion_frame"))}` : "STALE: the server is not reached";
  document.body.className = element("stale").hidden ? "" : "stale";
}

// Of the set that is being sent and the one before, by look-ahead: older ones may be of another map.
function latestPredictions() {
  const bases = [...new Set([...predictions.values()].map(p => p.base))].sort((a, b) => b - a).slice(0, 2);
  return [...predictions.values()].filter(p => bases.includes(p.base)).sort((a, b) => a.ahead_s - b.ahead_s);
}

function draw() {
  const mode = now.motion_mode || "no telemetry", latest = latestPredictions();
  element("mode").textContent = mode; element("mode").className = mode;
  element("frame").textContent = "motion_frame" in now ? `frame ${now.motion_frame}` : "";
  drawAge();
  drawRates(rates, latest.slice().sort((a, b) => a.t - b.t));
  drawAttitude(now.motion_flag_pose ? four(now, "motion_q_CT_") : null, bodyOf(now));
  motionTable(now); shapeTable(now); healthTable(now); predictionTable(latest);
}

function connect() {
  const socket = new WebSocket(`ws://${server}/api/websocket`);
  const ask = (type, id, options) => socket.send(JSON.stringify({ type, id, options: { instance, processor, ...options } }));
  socket.onopen = () => {
    connected = true;
    element("link").textContent = "connected";
    alarms.clear(); alarmList([]);
    ask("time", 2, {});
    ask("alarms", 3, {});
    ask("parameters", 1, { id: names.map(name => ({ name: "/polhode/" + name })), sendFromCache: true, abortOnInvalid: false, updateOnExpiration: false });
    takeArchive();
  };
  socket.onmessage = message => {
    const { type, data } = JSON.parse(message.data);
    if (type === "time" && data && data.value) serverAheadMs = Date.parse(data.value) - Date.now();
    if (type === "alarms" && data && data.id) takeAlarm(data);
    if (type !== "parameters" || !data) return;
    for (const [id, parameter] of Object.entries(data.mapping || {})) idOf[id] = parameter.name.replace("/polhode/", "");
    if (data.values) take(data.values);
  };
  socket.onclose = () => {
    connected = false;
    element("link").textContent = "server not reached, trying again";
    setTimeout(connect, 2000);
  };
}

draw();
connect();
setInterval(drawAge, 500);
window.addEventListener("resize", draw);
