// node read_mcap.cjs FILE: prints a line `t_ns x y p camera` for each event of an MCAP file, read by its index, then
// `TOPIC,... TYPE MESSAGES`.
const fs = require("fs");
const { McapIndexedReader } = require("@mcap/core");
const { loadDecompressHandlers } = require("@mcap/support");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { cameraOf, eventsOfPacket, printEvents } = require("./events.cjs");

async function main() {
  const bytes = fs.readFileSync(process.argv[2]);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => bytes.subarray(Number(offset), Number(offset + length)),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
  const decoders = new Map();
  const events = [];
  let messages = 0;
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    if (!decoders.has(channel.id)) {
      const schema = reader.schemasById.get(channel.schemaId);
      decoders.set(channel.id, new MessageReader(parse(Buffer.from(schema.data).toString(), { ros2: true })));
    }
    const packet = eventsOfPacket(decoders.get(channel.id).readMessage(message.data));
    events.push(...packet.map((event) => [...event, cameraOf(channel.topic)]));
    ++messages;
  }
  printEvents(events);
  const channels = [...reader.channelsById.values()];
  if (reader.statistics.messageCount !== BigInt(messages)) throw new Error("the statistics count other messages");
  console.log(channels.map((channel) => channel.topic).join(), reader.schemasById.get(channels[0].schemaId).name, messages);
}

main();
