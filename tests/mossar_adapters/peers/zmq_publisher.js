// Publishes JSON frames, one part each. Arguments: endpoint, number of frames.
const zmq = require("zeromq");
const [endpoint, count] = process.argv.slice(2);
const pause = (ms) => new Promise((done) => setTimeout(done, ms));
(async () => {
  const socket = new zmq.Publisher({ linger: 500 });
  socket.connect(endpoint);
  await pause(300);
  for (let k = 0; k < Number(count); k += 1) {
    await socket.send(JSON.stringify({ type: "frame", performer: "js", seq: k, t: k / 60, xyz: [[0, 1, k], [0, 2, null]] }));
  }
  await pause(100);
  socket.close();
})();
