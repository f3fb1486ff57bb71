// The two drawings: rates over time with what is predicted, and the measured body in its attitude. No libraries.
"use strict";

const axes = ["x", "y", "z"], colours = { x: "#ff7b72", y: "#7ee787", z: "#79c0ff" };
const lineColour = "#2b3440", dimColour = "#8b98a8";
const degrees = 180 / Math.PI;
const element = id => document.getElementById(id);

function context(id) {
  const canvas = element(id), scale = window.devicePixelRatio || 1, width = canvas.clientWidth, height = 230;
  canvas.width = width * scale; canvas.height = height * scale; canvas.style.height = height + "px";
  const c = canvas.getContext("2d");
  c.scale(scale, scale);
  c.font = "11px system-ui, sans-serif";
  return [c, width, height];
}

// The step between labels, s: the shortest that leaves no more than `most` of them.
function timeStep(span_s, most) {
  const steps = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 21600, 86400];
  return steps.find(step => span_s / step <= most) || 86400;
}

function clock(ms, step_s) {
  return new Date(ms).toISOString().slice(11, step_s < 1 ? 21 : 19);
}

// Times of the labels, ms since 1970, on whole steps.
function timeTicks(from, to, width) {
  const step = timeStep((to - from) / 1000, Math.max(2, Math.floor(width / 90)));
  const ticks = [];
  for (let t = Math.ceil(from / 1000 / step) * step * 1000; t <= to; t += step * 1000) ticks.push([t, clock(Math.round(t), step)]);
  return ticks;
}

// Predictions that the axis has room for: no further ahead than the curve goes back, but 10 s at least.
function shownPredictions(samples, predictions) {
  if (!samples.length) return [];
  const first = samples[0].t, last = samples[samples.length - 1].t, ahead = Math.max(10000, last - first);
  return predictions.filter(p => p.w && p.t > last && p.t <= last + ahead);
}

// samples: {t: ms, w: three rates in deg/s or null}, by time; predictions alike.
function drawRates(samples, predictions) {
  const [c, width, height] = context("rates"), left = 44, foot = 20;
  const dots = shownPredictions(samples, predictions), known = [...samples, ...dots].filter(s => s.w).flatMap(s => s.w);
  const top = Math.max(0.1, ...known) * 1.1, bottom = Math.min(-0.1, ...known) * 1.1;
  const from = samples.length ? samples[0].t : 0, to = Math.max(from + 1000, ...samples.slice(-1).map(s => s.t), ...dots.map(s => s.t));
  const y = value => height - foot - (value - bottom) / (top - bottom) * (height - foot - 8);
  const x = t => left + (t - from) / (to - from) * (width - left - 6);
  c.strokeStyle = lineColour; c.fillStyle = dimColour;
  for (const value of [bottom, 0, top]) {
    c.beginPath(); c.moveTo(left, y(value)); c.lineTo(width, y(value)); c.stroke();
    c.fillText(value.toFixed(2), 2, y(value) + 4);
  }
  for (const [t, label] of samples.length ? timeTicks(from, to, width - left) : []) {
    c.beginPath(); c.moveTo(x(t), 8); c.lineTo(x(t), height - foot + 4); c.stroke();
    c.fillText(label, Math.min(x(t) - 20, width - 54), height - 4);
  }
  if (dots.length) {
    c.setLineDash([3, 3]); c.beginPath(); c.moveTo(x(samples[samples.length - 1].t), 8); c.lineTo(x(samples[samples.length - 1].t), height - foot); c.stroke();
    c.setLineDash([]);
  }
  axes.forEach((axis, i) => {
    c.strokeStyle = c.fillStyle = colours[axis]; c.lineWidth = 1.6; c.beginPath();
    let pen = false;
    for (const { t, w } of samples) {
      if (w) { pen ? c.lineTo(x(t), y(w[i])) : c.moveTo(x(t), y(w[i])); }
      pen = Boolean(w);
    }
    c.stroke();
    for (const { t, w } of dots) { c.beginPath(); c.arc(x(t), y(w[i]), 2.5, 0, 7); c.fill(); }
  });
}

// q p: the vector, rotated by the quaternion w, x, y, z.
function turned([w, x, y, z], [a, b, c]) {
  const tx = 2 * (y * c - z * b), ty = 2 * (z * a - x * c), tz = 2 * (x * b - y * a);
  return [a + w * tx + y * tz - z * ty, b + w * ty + z * tx - x * tz, c + w * tz + x * ty - y * tx];
}

// Lines of the body in T, about its centre, the longest half being 1. body: {dimensions, q_TB} or, unknown, a cube.
function bodyLines(body) {
  const half = body ? body.dimensions.map(d => d / Math.max(...body.dimensions)) : [0.6, 0.6, 0.6];
  const q_TB = body ? body.q_TB : [1, 0, 0, 0];
  const corner = n => turned(q_TB, [0, 1, 2].map(i => (n & 1 << i ? 1 : -1) * half[i]));
  const lines = [];
  for (let n = 0; n < 8; ++n) for (const bit of [1, 2, 4]) if (!(n & bit)) lines.push([corner(n), corner(n | bit)]);
  return lines;
}

// q: attitude q_CT, or null.
function drawAttitude(q, body) {
  const [c, width, height] = context("attitude");
  c.fillStyle = dimColour;
  if (!q) { c.fillText("unknown", width / 2 - 22, height / 2); return; }
  const size = 0.3 * height;
  const place = p => { const [x, y, z] = turned(q, p), s = size / (1 + 0.12 * z); return [width / 2 + s * x, height / 2 + s * y, z]; };
  c.fillText(body ? "box of the measured lengths" : "shape unknown: a cube", 4, height - 6);
  c.lineWidth = 1.2;
  for (const line of bodyLines(body)) {
    const [from, to] = line.map(place);
    c.strokeStyle = from[2] + to[2] > 0 ? lineColour : dimColour;  // z forward: what is nearer is brighter
    c.beginPath(); c.moveTo(from[0], from[1]); c.lineTo(to[0], to[1]); c.stroke();
  }
  axes.forEach((axis, i) => {
    const end = place([0, 1, 2].map(n => n === i ? 1.35 : 0));
    c.strokeStyle = c.fillStyle = colours[axis]; c.lineWidth = 2.4;
    c.beginPath(); c.moveTo(width / 2, height / 2); c.lineTo(end[0], end[1]); c.stroke();
    c.fillText(axis, end[0] + 4, end[1] + 4);
  });
}
