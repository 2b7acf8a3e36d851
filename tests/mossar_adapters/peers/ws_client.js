// Prints the text frames of a WebSocket server. Arguments: URL, number of messages.
const WebSocket = require("ws");
const [url, count] = process.argv.slice(2);
const socket = new WebSocket(url);
let received = 0;
socket.on("open", () => console.log("ready"));
socket.on("message", (data) => {
  console.log(data.toString());
  received += 1;
  if (received === Number(count)) socket.close();
});
