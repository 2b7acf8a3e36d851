// The browser's camera as the sensor: poses are estimated here and go to mossar on this computer; pictures go nowhere.
import { PoseLandmarker } from "/vision_bundle.mjs";

const AXES = [1, -1, -1]; // the maker's y points down and z away from the camera
const FIELD = Math.PI / 3; // across the longer side, as of usual webcams; see pose/travel.py
const VISIBLE = 0.5;
const HIDDEN = 0.5; // s
const HIPS = [23, 24];
const SLOW = 12; // pictures a second; fewer lose fast movements
const SLOW_FOR = 3000; // ms, before the page says so
const STANDS = 10000; // ms for which a warning stays as it is

const video = document.createElement("video");
const still = new OffscreenCanvas(1, 1); // the picture that is looked at, and shown with what was found in it
const ink = still.getContext("2d", { willReadFrequently: true });
let about, stage, controls, poses;
let said = "starting"; // what keeps the camera from being of use
let strays = null;

// Whether this window has the camera: one window of a browser does, the others show the figure.
export let sees = false;

// What keeps the camera from being of use; empty if nothing does.
export function trouble() {
  return said;
}

// Degrees by which each bone strays.
export function colour(angles) {
  strays = angles;
}

function connect() {
  poses = new WebSocket(about.poses);
  poses.onopen = () => send(about.meta);
  poses.onclose = () => setTimeout(connect, 1000);
}

// What the line cannot take at once is old by the time it can.
function send(value) {
  if (poses.readyState === WebSocket.OPEN && poses.bufferedAmount < 65536) poses.send(JSON.stringify(value));
}

// One-Euro filter of one number, as pose/smoothing.py has it.
class Steady {
  constructor(cutoff, beta) {
    Object.assign(this, { cutoff, beta, slope: 0, value: null });
  }

  next(raw, time) {
    const share = (cutoff, step) => 1 / (1 + 1 / (2 * Math.PI * cutoff * step));
    if (this.value === null) {
      this.value = raw;
    } else {
      const step = Math.max(time - this.time, 1e-4);
      this.slope += share(1, step) * ((raw - this.raw) / step - this.slope);
      this.value += share(this.cutoff + this.beta * Math.abs(this.slope), step) * (raw - this.value);
    }
    Object.assign(this, { raw, time });
    return this.value;
  }
}

// Pixels that a metre of the body takes up: least squares over its joints, weighted by visibility.
function pixelsAMetre(world, pixels) {
  let total = 0;
  const mean = [0, 0, 0, 0];
  const rows = world.map((joint, k) => [joint.x, joint.y, ...pixels[k]]);
  world.forEach((joint, k) => {
    total += joint.visibility;
    rows[k].forEach((value, n) => { mean[n] += joint.visibility * value; });
  });
  let both = 0;
  let squares = 0;
  world.forEach((joint, k) => {
    const [x, y, u, v] = rows[k].map((value, n) => value - mean[n] / Math.max(total, 1e-9));
    both += joint.visibility * (x * u + y * v);
    squares += joint.visibility * (x * x + y * y);
  });
  return squares > 0 ? both / squares : 0;
}

let scale = new Steady(0.3, 1);
let seen = []; // s, when each joint was last visible

// How sure each joint is; 0 for one that was hidden over the last half second, which is missing rather than invented.
function certain(world, time) {
  return world.map((joint, k) => {
    if (joint.visibility >= VISIBLE || seen[k] === undefined) seen[k] = time;
    const hidden = time - seen[k] > HIDDEN && k !== HIPS[0]; // the body centre always counts as seen
    return hidden ? 0 : Math.max(0.001, Number(joint.visibility.toFixed(3)));
  });
}

// Positions in the room, m: the hips travel with the picture, the other joints with them.
function placed(world, landmarks, time) {
  const pixels = landmarks.map((point) => [point.x * still.width, point.y * still.height]);
  const metre = Math.exp(scale.next(Math.log(Math.max(1, pixelsAMetre(world, pixels))), time));
  const middle = [0, 1].map((n) => (pixels[HIPS[0]][n] + pixels[HIPS[1]][n]) / 2);
  const focal = Math.max(still.width, still.height) / 2 / Math.tan(FIELD / 2);
  const hips = [(middle[0] - still.width / 2) / metre, (middle[1] - still.height / 2) / metre, focal / metre];
  return world.map((joint) =>
    [joint.x, joint.y, joint.z].map((value, n) => Number(((value + hips[n]) * AXES[n]).toFixed(4))));
}


function points(landmarks) {
  return about.outline.places.map((pair) => {
    const ends = pair.map((joint) => landmarks[joint]);
    if (ends.some((point) => point.visibility < VISIBLE)) return null;
    return [(ends[0].x + ends[1].x) / 2, (ends[0].y + ends[1].y) / 2];
  });
}

let landmarker = null;
let count = 0;
let last = 0; // ms
let recent = [];
let slowSince = null; // ms
let warning = null; // the rate, and when it was said, ms

function look(now) {
  if (landmarker && video.videoWidth && now > last) {
    last = now;
    if (still.width !== video.videoWidth || still.height !== video.videoHeight) [still.width, still.height] = [video.videoWidth, video.videoHeight];
    ink.drawImage(video, 0, 0);
    const found = landmarker.detectForVideo(still, now);
    const world = found.worldLandmarks[0];
    stage.showPicture(still, world ? [points(found.landmarks[0])] : [], about.outline, strays);
    if (world) {
      const time = now / 1000;
      send({
        type: "frame",
        performer: about.meta.performer,
        seq: count++,
        t: time,
        xyz: placed(world, found.landmarks[0], time),
        conf: certain(world, time),
      });
    } else {
      scale = new Steady(0.3, 1);
      seen = [];
    }
    recent = [...recent.filter((time) => now - time < 2000), now];
    judge(now, world);
  }
  video.requestVideoFrameCallback(look);
}

// Says what the player can do about it.
function judge(now, world) {
  const rate = recent.length > 1 ? (1000 * (recent.length - 1)) / (now - recent[0]) : SLOW;
  slowSince = rate < SLOW ? slowSince ?? now : null;
  const isSlow = slowSince !== null && now - slowSince > SLOW_FOR;
  if (!warning || now - warning.at > STANDS) warning = isSlow ? { at: now, rate: rate.toFixed(0) } : null;
  const fetched = about.models.includes("lite") ? "" : "; to fetch it: mossar view webcam:browser?model=lite";
  const faster = controls.model.value === "lite" ? "close other programs" : `the model lite is faster${fetched}`;
  if (!world) said = "nobody is in the picture: step back until the whole body is in it";
  else said = warning ? `only ${warning.rate} pictures a second: ${faster}` : "";
  video.dataset.rate = rate.toFixed(1);
}

async function load(model) {
  said = `loading the model ${model}`;
  const before = landmarker;
  landmarker = null;
  before?.close();
  const loader = { wasmLoaderPath: "/vision_wasm_internal.js", wasmBinaryPath: "/vision_wasm_internal.wasm" };
  landmarker = await PoseLandmarker.createFromOptions(loader, {
    baseOptions: { modelAssetPath: `/${model}.task`, delegate: "CPU" },
    runningMode: "VIDEO",
    numPoses: 1,
  });
  [recent, slowSince, warning] = [[], null, null];
}

const REFUSALS = {
  NotAllowedError: "the browser may not use the camera: allow it beside the address of this page",
  NotFoundError: "no camera was found: plug one in",
  NotReadableError: "another program uses the camera: close it",
};

async function open(device) {
  video.srcObject?.getTracks().forEach((track) => track.stop());
  try {
    const wanted = device ? { deviceId: { exact: device } } : true;
    video.srcObject = await navigator.mediaDevices.getUserMedia({ video: wanted });
    await video.play();
  } catch (error) {
    said = REFUSALS[error.name] ?? `the camera cannot be used: ${error.message}`;
    return;
  }
  const cameras = (await navigator.mediaDevices.enumerateDevices()).filter((one) => one.kind === "videoinput");
  const used = video.srcObject.getVideoTracks()[0].getSettings().deviceId;
  controls.camera.replaceChildren(...cameras.map((one, k) => new Option(one.label || `camera ${k}`, one.deviceId)));
  controls.camera.value = used;
  controls.cameras.hidden = false;
}

// Opens the camera once no other window has it, and goes on with it for as long as the page is open.
export function start(...given) {
  [about, stage, controls] = given;
  said = "another window shows the camera";
  return navigator.locks.request("mossar camera", () => {
    sees = true;
    see();
    return new Promise(() => {}); // until the window is closed
  });
}

async function see() {
  said = "opening the camera";
  video.muted = video.playsInline = true;
  connect();
  controls.model.replaceChildren(...about.models.map((name) => new Option(name)));
  controls.model.value = about.model;
  controls.models.hidden = false;
  controls.model.onchange = () => load(controls.model.value).catch((error) => { said = error.message; });
  controls.camera.onchange = () => open(controls.camera.value);
  navigator.mediaDevices.ondevicechange = () => { if (!video.srcObject?.active) open(); };
  video.requestVideoFrameCallback(look);
  await open();
  if (video.srcObject) await load(about.model).catch((error) => { said = `the model cannot be loaded: ${error.message}`; });
}
