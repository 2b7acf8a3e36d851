// Prints OSC messages as JSON. Arguments: port, number of messages.
const { Server } = require("node-osc");
const [port, count] = process.argv.slice(2).map(Number);
let received = 0;
const server = new Server(port, "127.0.0.1", () => console.log("ready"));
server.on("message", (message) => {
  console.log(JSON.stringify(message));
  received += 1;
  if (received === count) server.close();
});
