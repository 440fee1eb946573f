// node read_bag.cjs FILE: prints a line `t_ns x y p` for each event of a bag, then `topic TYPE MESSAGES`.
const { Bag } = require("@foxglove/rosbag");
const { FileReader } = require("@foxglove/rosbag/node");
const { eventsOfPacket, printEvents } = require("./events.cjs");

async function main() {
  const bag = new Bag(new FileReader(process.argv[2]));
  await bag.open();
  const lines = [];
  let messages = 0;
  let last = 0n;
  for await (const { message, timestamp } of bag.messageIterator()) {
    ++messages;
    const recorded = BigInt(timestamp.sec) * 1000000000n + BigInt(timestamp.nsec);
    if (recorded < last) throw new Error("the index is not sorted");
    last = recorded;
    if (message.encoding !== undefined) {
      lines.push(...eventsOfPacket(message));
    } else {
      for (const event of message.events)
        lines.push([BigInt(event.ts.sec) * 1000000000n + BigInt(event.ts.nsec), event.x, event.y, event.polarity]);
    }
  }
  printEvents(lines);
  const [connection] = bag.connections.values();
  console.log(connection.topic, connection.type, messages);
}

main();
