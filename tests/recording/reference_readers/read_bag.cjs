// node read_bag.cjs FILE: writes the events of a bag to standard output, as events.cjs says, then a line
// `TOPIC,... TYPE MESSAGES` to standard error.
const { Bag } = require("@foxglove/rosbag");
const { FileReader } = require("@foxglove/rosbag/node");
const { cameraOf, run, writeArray, writePacket } = require("./events.cjs");

run(async () => {
  const bag = new Bag(new FileReader(process.argv[2]));
  await bag.open();
  let messages = 0;
  let last = 0n;
  for await (const { message, timestamp, topic } of bag.messageIterator()) {
    ++messages;
    const recorded = BigInt(timestamp.sec) * 1000000000n + BigInt(timestamp.nsec);
    if (recorded < last) throw new Error("the index is not sorted");
    last = recorded;
    (message.encoding === undefined ? writeArray : writePacket)(message, cameraOf(topic));
  }
  const connections = [...bag.connections.values()];
  console.error(connections.map((connection) => connection.topic).join(), connections[0].type, messages);
});
