// What the page says in rows: motion, shape, health, prediction, alarms and events. `now` holds the last value of each parameter.
"use strict";

function fill(id, rows) {
  element(id).innerHTML = rows.map(([name, value, bad]) => `<tr><td class="dim">${name}</td><td class="${bad ? "bad" : ""}">${value}</td></tr>`).join("");
}

function triple(values, digits) {
  return values.map((value, i) => `<span class="${axes[i]}">${value.toFixed(digits)}</span>`).join(" &nbsp;");
}

const three = (now, prefix, factor = 1) => axes.map(a => now[prefix + a] * factor);
const four = (now, prefix) => "wxyz".split("").map(a => now[prefix + a]);
const lengthUnit = flag => flag ? "m" : "map units";

function motionTable(now) {
  const unit = lengthUnit(now.motion_flag_scale_known);
  const if_ = (flag, text) => now[flag] ? text() : "unknown";
  fill("motion", [
    ["angular velocity, deg/s", if_("motion_flag_rate", () => triple(three(now, "motion_w_T_rad_s_", degrees), 4))],
    ["position, " + unit, if_("motion_flag_pose", () => triple(three(now, "motion_p_CT_"), 3))],
    ["velocity, " + unit + "/s", if_("motion_flag_velocity", () => triple(three(now, "motion_v_C_"), 5))],
    ["sigma of attitude", if_("motion_flag_pose", () => (now.motion_sigma_att_rad * degrees).toFixed(3) + " deg")],
    ["sigma of rate", if_("motion_flag_rate", () => (now.motion_sigma_rate_rad_s * degrees).toFixed(4) + " deg/s")],
    ["sigma of position", if_("motion_flag_pose", () => now.motion_sigma_pos.toFixed(4) + " " + unit)],
    ["number of the scale", now.motion_scale_number]]);
}

// The measured body, or null.
function bodyOf(now) {
  return now.shape_flag_shape ? { dimensions: three(now, "shape_dimensions_"), q_TB: four(now, "shape_q_TB_") } : null;
}

function shapeTable(now) {
  if (!now.shape_flag_shape) { fill("shape", [["shape", "unknown"]]); return; }
  const unit = lengthUnit(now.shape_flag_scale_known), bases = { NOTHING: "flat there", POINTS: "at least", SURFACES: "between surfaces" };
  const rows = axes.map(a => [`length along ${a}, ${unit}`, `${now["shape_dimensions_" + a].toFixed(3)} ± ` +
    `${now["shape_sigma_dimensions_" + a].toFixed(3)}, ${bases[now["shape_dimension_basis_" + a]]}`]);
  rows.push(["axes from", String(now.shape_frame_source).toLowerCase()], ["completed to", String(now.shape_completion).toLowerCase()],
    ["flat faces / points", `${now.shape_plane_count} / ${now.shape_cloud_points}`]);
  if (now.shape_flag_cylinder) rows.push(["cylinder, radius, length", `${now.shape_cylinder_radius.toFixed(3)}, ${now.shape_cylinder_length.toFixed(3)} ${unit}`]);
  fill("shape", rows);
}

function healthTable(now) {
  const of = name => now["housekeeping_" + name] ?? "-";
  fill("health", [["frames in / used", `${of("frames_in")} / ${of("frames_used")}`], ["with a pose", of("poses")],
    ["unreadable / dark", `${of("frames_unreadable")} / ${of("frames_dark")}`, of("frames_unreadable") > 0],
    ["times lost", of("lost"), of("lost") > 0], ["landmarks / keyframes", `${now.motion_landmarks ?? "-"} / ${now.motion_keyframes ?? "-"}`],
    ["commands taken / refused", `${of("commands_accepted")} / ${of("commands_rejected")}`, of("commands_rejected") > 0],
    ["last command", of("last_command")],
    ["memory of the tables", now.housekeeping_memory_octets ? (now.housekeeping_memory_octets / 1e6).toFixed(1) + " MB" : "-"],
    ["parameter table", now.housekeeping_table_crc === undefined ? "-" : now.housekeeping_table_crc.toString(16).padStart(8, "0")]]);
}

// A prediction packet as the page keeps it. t: ms, the time that it is for; w: deg/s or null.
function predictionOf(now) {
  const base = now.prediction_timestamp_ns / 1e6, t = now.prediction_predicted_timestamp_ns / 1e6;
  return { base, t, ahead_s: Math.round((t - base) / 1000), unit: lengthUnit(now.prediction_flag_scale_known),
    w: now.prediction_flag_rate ? three(now, "prediction_w_T_rad_s_", degrees) : null,
    p: now.prediction_flag_position ? three(now, "prediction_p_CT_") : null, attitude: Boolean(now.prediction_flag_attitude) };
}

// predictions: the latest of each look-ahead, by look-ahead.
function predictionTable(predictions) {
  const rows = predictions.map(p => `<tr><td class="dim">${clock(p.base, 1)} + ${p.ahead_s} s</td><td>${p.w ? triple(p.w, 2) : "unknown"}</td>` +
    `<td>${p.p ? triple(p.p, 2) : "unknown"}</td><td>${p.attitude ? "known" : "unknown"}</td></tr>`);
  const unit = predictions.length ? ", " + predictions[0].unit : "";
  element("prediction").innerHTML = `<tr><th>from, UTC</th><th>rate, deg/s</th><th>position${unit}</th><th>attitude</th></tr>` +
    (rows.join("") || `<tr><td class="dim">none yet</td><td></td><td></td><td></td></tr>`);
}

function line(className, text) {
  const item = document.createElement("li");
  item.className = className;
  item.textContent = text;
  return item;
}

// alarms: of the server, by parameter. Those whose cause is still there come first, of these the severest.
function alarmList(alarms) {
  const order = alarm => 2 * alarm.over + (alarm.severity !== "CRITICAL");
  const rows = alarms.sort((a, b) => order(a) - order(b)).map(({ parameter, severity, since, value, over }) => line(`${severity} ${over ? "over" : ""}`,
    `${severity}  ${parameter}${over ? "" : ` = ${value}`}, since ${since} UTC${over ? ", over now, not acknowledged" : ""}`));
  element("alarms").replaceChildren(...(rows.length ? rows : [line("dim", "none")]));
}

// events: latest first.
function eventList(events) {
  element("events").replaceChildren(...events.map(e => line(e.severity,
    `frame ${e.frame}  ${e.severity}  ${e.text}${e.words ? `  (${e.words})` : ""}`)));
}
