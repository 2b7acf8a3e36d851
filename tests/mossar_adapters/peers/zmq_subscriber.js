// Prints topic and JSON of messages. Arguments: endpoint, topic, number of messages.
const zmq = require("zeromq");
const [endpoint, topic, count] = process.argv.slice(2);
(async () => {
  const socket = new zmq.Subscriber({ linger: 0 });
  socket.connect(endpoint);
  socket.subscribe(topic);
  console.log("ready");
  let received = 0;
  for await (const [name, data] of socket) {
    console.log(name.toString(), data.toString());
    received += 1;
    if (received === Number(count)) break;
  }
  socket.close();
})();
