// Sends a VMC stream the way the reference sender bundles it. Arguments: port, number of frames, frames per second.
const osc = require("osc");
const [port, frames, fps] = process.argv.slice(2).map(Number);
const names = [
  "Hips", "Spine", "Chest", "UpperChest", "Neck", "Head", "LeftShoulder", "LeftUpperArm", "LeftLowerArm", "LeftHand",
  "RightShoulder", "RightUpperArm", "RightLowerArm", "RightHand", "LeftUpperLeg", "LeftLowerLeg", "LeftFoot",
  "LeftToes", "RightUpperLeg", "RightLowerLeg", "RightFoot", "RightToes", "LeftIndexProximal", "LeftEye", "Jaw",
];
const f = (value) => ({ type: "f", value });
const s = (value) => ({ type: "s", value });
const bone = (name, k) => ({
  address: "/VMC/Ext/Bone/Pos",
  args: [s(name), f(0), f(0.1), f(0.001 * k), f(0), f(0), f(0), f(1)],
});
const root = {
  address: "/VMC/Ext/Root/Pos",
  args: [s("root"), f(0), f(0), f(0), f(0), f(0), f(0), f(1), f(1), f(1), f(1), f(0), f(0), f(0)],
};

const socket = new osc.UDPPort({ localAddress: "127.0.0.1", localPort: 0 });
const send = (packets) => socket.send({ timeTag: osc.timeTag(0), packets }, "127.0.0.1", port);
socket.on("ready", () => {
  let k = 0;
  const timer = setInterval(() => {
    const bones = names.map((name) => bone(name, k));
    send(bones.slice(0, 13));
    send([
      root,
      { timeTag: osc.timeTag(3600), packets: bones.slice(13) },
      { address: "/VMC/Ext/OK", args: [{ type: "i", value: 1 }] },
      { address: "/VMC/Ext/T", args: [f(k / fps)] },
    ]);
    k += 1;
    if (k === frames) {
      clearInterval(timer);
      setTimeout(() => socket.close(), 100);
    }
  }, 1000 / fps);
});
socket.open();
