// Sends /joint messages; this library turns whole numbers into integers. Arguments: port, number of frames.
const { Client } = require("node-osc");
const [port, frames] = process.argv.slice(2).map(Number);
const client = new Client("127.0.0.1", port);
(async () => {
  for (let k = 0; k < frames; k += 1) {
    for (const [i, name] of ["head", "neck", "torso", "l_hand", "r_hand"].entries()) {
      await new Promise((done) => client.send("/joint", name, 1, 0.5, i, 2.0, done));
    }
  }
  await client.close();
})();
