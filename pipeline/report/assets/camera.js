"use strict";
// Where the machine is seen from: four views, and turns from wherever one is.

const UP = { x: 0, y: 0, z: 1 };
const MIDDLE = { x: 0, y: 0, z: 0 };
const CAMERAS = {
  Overview: { eye: { x: -0.95, y: -1.8, z: 0.66 }, up: UP, center: { x: -0.03, y: 0, z: -0.06 } },
  Front: { eye: { x: 0, y: -2, z: 0 }, up: UP, center: MIDDLE },
  Side: { eye: { x: 2.15, y: 0, z: 0 }, up: UP, center: MIDDLE },
  Top: { eye: { x: 0, y: -0.001, z: 2.05 }, up: { x: 0, y: 1, z: 0 }, center: MIDDLE },
};
const TURNS = {
  "Turn left": { sign: "↺", around: -15 },
  "Turn right": { sign: "↻", around: 15 },
  "Look from higher up": { sign: "↑", up: 15 },
  "Look from lower down": { sign: "↓", up: -15 },
  Closer: { sign: "+", away: 0.85 },
  Farther: { sign: "−", away: 1 / 0.85 },
};
const STEEPEST = 85;

/** A camera that sees everything: farther away where the plot is narrow. */
function cameraOf(name, div) {
  const { eye, up, center } = CAMERAS[name];
  const away = Math.min(1.5, Math.max(1, (1.22 * div.clientHeight) / div.clientWidth));
  // Labels are to the left of the machine: a narrow plot needs room there.
  const middle = { ...center, x: center.x - 0.55 * (away - 1) };
  return { up: { ...up }, center: middle, eye: { x: away * eye.x, y: away * eye.y, z: away * eye.z } };
}

/** The camera after a turn: `around` the vertical and `up` in degrees, and so many times as far `away`. */
function turned({ eye, center }, { around = 0, up = 0, away = 1 }) {
  const far = away * Math.hypot(eye.x, eye.y, eye.z);
  const azimuth = Math.atan2(eye.y, eye.x) + around / DEGREES;
  const steep = DEGREES * Math.atan2(eye.z, Math.hypot(eye.x, eye.y)) + up;
  const height = Math.max(-STEEPEST, Math.min(STEEPEST, steep)) / DEGREES;
  const level = far * Math.cos(height);
  const place = { x: level * Math.cos(azimuth), y: level * Math.sin(azimuth), z: far * Math.sin(height) };
  return { up: { ...UP }, center: { ...center }, eye: place };
}
