// node read_bag.cjs FILE: prints a line `t_ns x y p camera` for each event of a bag, then `TOPIC,... TYPE MESSAGES`.
const { Bag } = require("@foxglove/rosbag");
const { FileReader } = require("@foxglove/rosbag/node");
const { cameraOf, eventsOfPacket, printEvents } = require("./events.cjs");

async function main() {
  const bag = new Bag(new FileReader(process.argv[2]));
  await bag.open();
  const lines = [];
  let messages = 0;
  let last = 0n;
  for await (const { message, timestamp, topic } of bag.messageIterator()) {
    ++messages;
    const recorded = BigInt(timestamp.sec) * 1000000000n + BigInt(timestamp.nsec);
    if (recorded < last) throw new Error("the index is not sorted");
    last = recorded;
    if (message.encoding !== undefined) {
      lines.push(...eventsOfPacket(message).map((event) => [...event, cameraOf(topic)]));
    } else {
      for (const event of message.events)
        lines.push([BigInt(event.ts.sec) * 1000000000n + BigInt(event.ts.nsec), event.x, event.y, event.polarity,
                    cameraOf(topic)]);
    }
  }
  printEvents(lines);
  const connections = [...bag.connections.values()];
  console.log(connections.map((connection) => connection.topic).join(), connections[0].type, messages);
}

main();
