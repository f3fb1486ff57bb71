// Rates, attitude, mode and health of Polhode, from a YAMCS server's WebSocket. No libraries.
//   ?yamcs=PORT of the server, 8090   ?stale=SECONDS without a motion packet from which on what is shown is marked as old, 5
"use strict";

const wish = new URLSearchParams(location.search);
const port = wish.get("yamcs") || "8090", staleMs = 1000 * Number(wish.get("stale") || 5);
const axes = ["x", "y", "z"], colours = { x: "#ff7b72", y: "#7ee787", z: "#79c0ff" };
const degrees = 180 / Math.PI, samplesMax = 600;
const names = ["motion_mode", "motion_frame", "motion_timestamp_ns", "motion_flag_pose", "motion_flag_rate", "motion_flag_velocity",
  "motion_flag_scale_known", "motion_sigma_att_rad", "motion_sigma_pos", "motion_sigma_rate_rad_s", "motion_inliers", "motion_landmarks",
  "motion_keyframes", ..."wxyz".split("").map(a => "motion_q_CT_" + a),
  ...axes.flatMap(a => ["motion_p_CT_" + a, "motion_v_C_" + a, "motion_w_T_rad_s_" + a]),
  ...["frames_in", "frames_used", "frames_unreadable", "frames_dark", "poses", "lost", "commands_accepted", "commands_rejected",
    "events_suppressed", "packets_not_sent", "memory_octets", "table_crc"].map(n => "housekeeping_" + n),
  ...["id", "severity", "text", "frame"].map(n => "event_" + n)];
const now = {}, rates = [], idOf = {}, cameAt = {};  // cameAt: ms of the server's clock, by which packets came
let serverAheadMs = 0, connected = false;
const element = id => document.getElementById(id);

function number(value) {
  const key = { FLOAT: "floatValue", DOUBLE: "doubleValue", UINT32: "uint32Value", SINT32: "sint32Value", UINT64: "uint64Value",
    SINT64: "sint64Value", STRING: "stringValue", ENUMERATED: "stringValue", BOOLEAN: "booleanValue" }[value.type];
  const raw = value[key];
  return key === "stringValue" ? raw || "" : key === "booleanValue" ? Boolean(raw) : Number(raw || 0);
}

function take(values) {
  let motion = false, event = false;
  for (const value of values) {
    const name = idOf[value.numericId];
    if (!name || !value.engValue) continue;
    now[name] = number(value.engValue);
    cameAt[name] = Date.parse(value.acquisitionTime);
    motion = motion || name === "motion_frame";
    event = event || name === "event_id";
  }
  if (motion) {
    rates.push(now.motion_flag_rate ? axes.map(a => now["motion_w_T_rad_s_" + a] * degrees) : null);
    if (rates.length > samplesMax) rates.shift();
  }
  if (event) tellEvent();
  draw();
}

function tellEvent() {
  const line = document.createElement("li");
  line.className = now.event_severity;
  line.textContent = `frame ${now.event_frame}  ${now.event_severity}  ${String(now.event_text).replace(/\0+$/, "")}`;
  element("events").prepend(line);
  while (element("events").children.length > 8) element("events").lastChild.remove();
}

function context(id) {
  const canvas = element(id), scale = window.devicePixelRatio || 1, width = canvas.clientWidth, height = 230;
  canvas.width = width * scale; canvas.height = height * scale; canvas.style.height = height + "px";
  const c = canvas.getContext("2d");
  c.scale(scale, scale);
  c.font = "11px system-ui, sans-serif";
  return [c, width, height];
}

function drawRates() {
  const [c, width, height] = context("rates"), left = 44;
  const known = rates.filter(Boolean).flat();
  const top = Math.max(0.1, ...known) * 1.1, bottom = Math.min(-0.1, ...known) * 1.1;
  const y = value => height - 8 - (value - bottom) / (top - bottom) * (height - 16);
  c.strokeStyle = "#2b3440"; c.fillStyle = "#8b98a8";
  for (const value of [bottom, 0, top]) {
    c.beginPath(); c.moveTo(left, y(value)); c.lineTo(width, y(value)); c.stroke();
    c.fillText(value.toFixed(2), 2, y(value) + 4);
  }
  axes.forEach((axis, i) => {
    c.strokeStyle = colours[axis]; c.lineWidth = 1.6; c.beginPath();
    let pen = false;
    rates.forEach((sample, n) => {
      const x = left + n / Math.max(1, rates.length - 1) * (width - left - 4);
      if (sample) { pen ? c.lineTo(x, y(sample[i])) : c.moveTo(x, y(sample[i])); }
      pen = Boolean(sample);
    });
    c.stroke();
  });
}

// p_C = R p_T, by the quaternion w, x, y, z.
function turned([w, x, y, z], [a, b, c]) {
  const tx = 2 * (y * c - z * b), ty = 2 * (z * a - x * c), tz = 2 * (x * b - y * a);
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

function drawAttitude() {
  const [c, width, height] = context("attitude");
  if (!now.motion_flag_pose) {
    c.fillStyle = "#8b98a8"; c.fillText("unknown", width / 2 - 22, height / 2);
    return;
  }
  const q = "wxyz".split("").map(a => now["motion_q_CT_" + a]), size = 0.27 * height;
  const place = p => { const [x, y, z] = turned(q, p), s = size / (1 + 0.12 * z); return [width / 2 + s * x, height / 2 + s * y, z]; };
  const corners = [0, 1, 2, 3, 4, 5, 6, 7].map(n => place([n & 1 ? 1 : -1, n & 2 ? 1 : -1, n & 4 ? 1 : -1]));
  c.lineWidth = 1.2;
  for (let a = 0; a < 8; ++a) for (const bit of [1, 2, 4]) if (!(a & bit)) {
    const from = corners[a], to = corners[a | bit];
    c.strokeStyle = from[2] + to[2] > 0 ? "#2b3440" : "#8b98a8";  // z forward: what is nearer is brighter
    c.beginPath(); c.moveTo(from[0], from[1]); c.lineTo(to[0], to[1]); c.stroke();
  }
  axes.forEach((axis, i) => {
    const end = place([0, 1, 2].map(n => n === i ? 1.7 : 0));
    c.strokeStyle = c.fillStyle = colours[axis]; c.lineWidth = 2.4;
    c.beginPath(); c.moveTo(width / 2, height / 2); c.lineTo(end[0], end[1]); c.stroke();
    c.fillText(axis, end[0] + 4, end[1] + 4);
  });
}

function fill(id, rows) {
  element(id).innerHTML = rows.map(([name, value, bad]) => `<tr><td class="dim">${name}</td><td class="${bad ? "bad" : ""}">${value}</td></tr>`).join("");
}

function triple(flag, prefix, factor, digits) {
  return now[flag] ? axes.map(a => `<span class="${a}">${(now[prefix + a] * factor).toFixed(digits)}</span>`).join(" &nbsp; ") : "unknown";
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

function draw() {
  const mode = now.motion_mode || "no telemetry", unit = now.motion_flag_scale_known ? "m" : "map units";
  element("mode").textContent = mode; element("mode").className = mode;
  element("frame").textContent = "motion_frame" in now ? `frame ${now.motion_frame}` : "";
  drawAge();
  drawRates();
  drawAttitude();
  const sigma = (flag, name, factor, digits, unit) => now[flag] ? (now[name] * factor).toFixed(digits) + " " + unit : "unknown";
  fill("motion", [["angular velocity, deg/s", triple("motion_flag_rate", "motion_w_T_rad_s_", degrees, 4)],
    ["position, " + unit, triple("motion_flag_pose", "motion_p_CT_", 1, 3)],
    ["velocity, " + unit + "/s", triple("motion_flag_velocity", "motion_v_C_", 1, 5)],
    ["sigma of attitude", sigma("motion_flag_pose", "motion_sigma_att_rad", degrees, 3, "deg")],
    ["sigma of rate", sigma("motion_flag_rate", "motion_sigma_rate_rad_s", degrees, 4, "deg/s")],
    ["sigma of position", sigma("motion_flag_pose", "motion_sigma_pos", 1, 4, unit)]]);
  const of = name => now["housekeeping_" + name] ?? "-";
  fill("health", [["frames in / used", `${of("frames_in")} / ${of("frames_used")}`], ["with a pose", of("poses")],
    ["unreadable / dark", `${of("frames_unreadable")} / ${of("frames_dark")}`, of("frames_unreadable") > 0],
    ["times lost", of("lost"), of("lost") > 0], ["landmarks / keyframes", `${now.motion_landmarks ?? "-"} / ${now.motion_keyframes ?? "-"}`],
    ["commands taken / refused", `${of("commands_accepted")} / ${of("commands_rejected")}`, of("commands_rejected") > 0],
    ["memory of the tables", now.housekeeping_memory_octets ? (now.housekeeping_memory_octets / 1e6).toFixed(1) + " MB" : "-"],
    ["parameter table", now.housekeeping_table_crc === undefined ? "-" : now.housekeeping_table_crc.toString(16).padStart(8, "0")]]);
}

function connect() {
  const socket = new WebSocket(`ws://${location.hostname}:${port}/api/websocket`);
  socket.onopen = () => {
    connected = true;
    element("link").textContent = "connected";
    socket.send(JSON.stringify({ type: "time", id: 2, options: { instance: "polhode", processor: "realtime" } }));
    socket.send(JSON.stringify({ type: "parameters", id: 1, options: { instance: "polhode", processor: "realtime",
      id: names.map(name => ({ name: "/polhode/" + name })), sendFromCache: true, abortOnInvalid: false, updateOnExpiration: false } }));
  };
  socket.onmessage = message => {
    const { type, data } = JSON.parse(message.data);
    if (type === "time" && data && data.value) serverAheadMs = Date.parse(data.value) - Date.now();
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
