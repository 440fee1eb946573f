// node read_mcap.cjs FILE: writes the events of an MCAP file, read by its index, to standard output, as events.cjs says, then a
// line `TOPIC,... TYPE MESSAGES` to standard error.
const fs = require("fs/promises");
const { McapIndexedReader } = require("@mcap/core");
const { loadDecompressHandlers } = require("@mcap/support");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");
const { cameraOf, run, writePacket } = require("./events.cjs");

run(async () => {
  const file = await fs.open(process.argv[2]);
  const readable = {
    size: async () => BigInt((await file.stat()).size),
    read: async (offset, length) => {
      const bytes = new Uint8Array(Number(length));
      for (let done = 0; done < bytes.length;) {
        const { bytesRead } = await file.read(bytes, done, bytes.length - done, Number(offset) + done);
        if (bytesRead === 0) throw new Error("the file is shorter than its index says");
        done += bytesRead;
      }
      return bytes;
    },
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
  const decoders = new Map();
  let messages = 0;
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    if (!decoders.has(channel.id)) {
      const schema = reader.schemasById.get(channel.schemaId);
      decoders.set(channel.id, new MessageReader(parse(Buffer.from(schema.data).toString(), { ros2: true })));
    }
    writePacket(decoders.get(channel.id).readMessage(message.data), cameraOf(channel.topic));
    ++messages;
  }
  const channels = [...reader.channelsById.values()];
  if (reader.statistics.messageCount !== BigInt(messages)) throw new Error("the statistics count other messages");
  console.error(channels.map((channel) => channel.topic).join(), reader.schemasById.get(channels[0].schemaId).name, messages);
});
