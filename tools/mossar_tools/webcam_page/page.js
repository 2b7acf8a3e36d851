// The browser's camera as a sensor: poses go to mossar on this computer, what it recognised comes back.
import { PoseLandmarker } from "/vision_bundle.mjs";

const AXES = [1, -1, -1]; // the maker's y points down and z away from the camera
const FIELD = Math.PI / 3; // across the longer side, as of usual webcams; see pose/travel.py
const VISIBLE = 0.5;
const HIDDEN = 0.5; // s
const SHOWN = 12; // events
const HIPS = [23, 24];
const at = (id) => document.getElementById(id);
const about = await (await fetch("/about.json")).json();
const video = at("video");
const canvas = at("skeleton");

function say(text) {
  at("state").textContent = text;
}

// Reconnects for as long as the page is open.
class Line {
  constructor(url, opened, received) {
    Object.assign(this, { url, opened, received });
    this.connect();
  }

  connect() {
    this.socket = new WebSocket(this.url);
    this.socket.onopen = () => this.opened(this);
    this.socket.onmessage = (message) => this.received(JSON.parse(message.data));
    this.socket.onclose = () => setTimeout(() => this.connect(), 1000);
  }

  // What the line cannot take at once is old by the time it can.
  send(value) {
    if (this.socket.readyState === WebSocket.OPEN && this.socket.bufferedAmount < 65536) {
      this.socket.send(JSON.stringify(value));
    }
  }
}

const poses = new Line(about.poses, (line) => line.send(about.meta), () => {});
new Line(about.events, () => {}, show);

function show(event) {
  const text = said(event);
  if (text === null) return;
  const row = document.createElement("li");
  row.textContent = text;
  at("events").prepend(row);
  while (at("events").children.length > SHOWN) at("events").lastChild.remove();
}

function said(event) {
  if (event.type === "key_frame" && event.status === "confirmed") return `key frame: ${event.kind}`;
  if (event.type === "move" && event.status === "confirmed") return `move: ${event.name}`;
  if (event.type === "repetition") return `repetition ${event.total}`;
  if (event.type === "follow" && event.status === "done") return `${event.name} ${event.count}: score ${event.score.toFixed(2)}`;
  if (event.type === "pose" && event.status !== "left") return `pose ${event.status}: ${event.name}`;
  if (event.type === "step" && event.status === "strike") return `step: ${event.side}`;
  if (event.type === "stream") return event.event + (event.reason ? `: ${event.reason}` : "");
  return null;
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
  const pixels = landmarks.map((point) => [point.x * video.videoWidth, point.y * video.videoHeight]);
  const metre = Math.exp(scale.next(Math.log(Math.max(1, pixelsAMetre(world, pixels))), time));
  const middle = [0, 1].map((n) => (pixels[HIPS[0]][n] + pixels[HIPS[1]][n]) / 2);
  const focal = Math.max(video.videoWidth, video.videoHeight) / 2 / Math.tan(FIELD / 2);
  const hips = [(middle[0] - video.videoWidth / 2) / metre, (middle[1] - video.videoHeight / 2) / metre, focal / metre];
  return world.map((joint) =>
    [joint.x, joint.y, joint.z].map((value, n) => Number(((value + hips[n]) * AXES[n]).toFixed(4))));
}

function draw(landmarks) {
  canvas.width = video.videoWidth;
  canvas.height = video.videoHeight;
  const pen = canvas.getContext("2d");
  pen.strokeStyle = "#4fc3f7";
  pen.lineWidth = Math.max(2, canvas.width / 200);
  for (const [joint, parent] of about.meta.parents.entries()) {
    if (!landmarks || parent < 0) continue;
    const ends = [landmarks[joint], landmarks[parent]];
    if (ends.some((point) => point.visibility < VISIBLE)) continue;
    pen.beginPath();
    for (const point of ends) pen.lineTo(point.x * canvas.width, point.y * canvas.height);
    pen.stroke();
  }
}

let landmarker = null;
let count = 0;
let last = 0; // ms
let recent = [];

function look(now) {
  if (landmarker && video.videoWidth && now > last) {
    last = now;
    const found = landmarker.detectForVideo(video, now);
    const world = found.worldLandmarks[0];
    draw(found.landmarks[0]);
    if (world) {
      const time = now / 1000;
      poses.send({
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
    recent = [...recent.filter((time) => now - time < 1000), now];
    at("rate").textContent = recent.length;
    say(world ? "a person is in the picture" : "nobody is in the picture");
  }
  video.requestVideoFrameCallback(look);
}

async function load(model) {
  say(`loading model ${model}`);
  const before = landmarker;
  landmarker = null;
  before?.close();
  const loader = { wasmLoaderPath: "/vision_wasm_internal.js", wasmBinaryPath: "/vision_wasm_internal.wasm" };
  landmarker = await PoseLandmarker.createFromOptions(loader, {
    baseOptions: { modelAssetPath: `/${model}.task`, delegate: "CPU" },
    runningMode: "VIDEO",
    numPoses: 1,
  });
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
    say(REFUSALS[error.name] ?? `the camera cannot be used: ${error.message}`);
    return;
  }
  const cameras = (await navigator.mediaDevices.enumerateDevices()).filter((one) => one.kind === "videoinput");
  const used = video.srcObject.getVideoTracks()[0].getSettings().deviceId;
  at("camera").replaceChildren(...cameras.map((one, k) => new Option(one.label || `camera ${k}`, one.deviceId)));
  at("camera").value = used;
}

at("model").replaceChildren(...about.models.map((name) => new Option(name)));
at("model").value = about.model;
at("model").onchange = () => load(at("model").value).catch((error) => say(error.message));
at("camera").onchange = () => open(at("camera").value);
navigator.mediaDevices.ondevicechange = () => { if (!video.srcObject?.active) open(); };
video.requestVideoFrameCallback(look);
await open();
await load(about.model).catch((error) => say(`the model cannot be loaded: ${error.message}`));
