// node read_foxglove.cjs FILE TOPIC...: reads an MCAP file of JSON messages by its index. Each message is held to the schema in
// the file, and where that is one of Foxglove's to Foxglove's own. Writes one JSON text to standard output: `topics` by name with
// `schema`, `encoding`, `messages`, `first` and `last` (ns), and `messages` of the topics that are named, [ns, message] each.
const fs = require("fs");
const Ajv = require("ajv");
const foxglove = require("@foxglove/schemas/jsonschema");
const { McapIndexedReader } = require("@mcap/core");
const { loadDecompressHandlers } = require("@mcap/support");
const { run } = require("./events.cjs");

run(async () => {
  const bytes = fs.readFileSync(process.argv[2]);
  const readable = {
    size: async () => BigInt(bytes.length),
    read: async (offset, length) => {
      const part = bytes.subarray(Number(offset), Number(offset + length));
      if (part.length !== Number(length)) throw new Error("the file is shorter than its index says");
      return part;
    },
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers: await loadDecompressHandlers() });
  const ajv = new Ajv({ strict: false });
  const checks = new Map();
  const topics = {};
  for (const channel of reader.channelsById.values()) {
    const schema = reader.schemasById.get(channel.schemaId);
    if (schema.encoding !== "jsonschema") throw new Error(`${channel.topic}: a schema in ${schema.encoding}`);
    const valid = [ajv.compile(JSON.parse(Buffer.from(schema.data).toString()))];
    if (schema.name.startsWith("foxglove.")) valid.push(ajv.compile(foxglove[schema.name.slice("foxglove.".length)]));
    checks.set(channel.id, valid);
    topics[channel.topic] = { schema: schema.name, encoding: channel.messageEncoding, messages: 0 };
  }
  const messages = {};
  for (const topic of process.argv.slice(3)) messages[topic] = [];
  let count = 0;
  for await (const { channelId, logTime, data } of reader.readMessages()) {
    const topic = reader.channelsById.get(channelId).topic;
    const message = JSON.parse(Buffer.from(data).toString());
    for (const valid of checks.get(channelId))
      if (!valid(message)) throw new Error(`${topic}: ${JSON.stringify(valid.errors)}`);
    topics[topic].first ??= Number(logTime);
    topics[topic].last = Number(logTime);
    ++topics[topic].messages;
    ++count;
    if (topic in messages) messages[topic].push([Number(logTime), message]);
  }
  if (reader.statistics.messageCount !== BigInt(count)) throw new Error("the statistics count other messages");
  process.stdout.write(JSON.stringify({ topics, messages }));
});
