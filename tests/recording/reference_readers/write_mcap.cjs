// node write_mcap.cjs FILE COMPRESSION: writes an MCAP file of EventPacket with the reference writer. Event i of 1000 is at
// 1000000 + 7 i us, x = i % 300, y = i % 200, ON where i is even; 50 events a message.
const fs = require("fs");
const { McapWriter } = require("@mcap/core");
const { parse } = require("@foxglove/rosmsg");
const { MessageWriter } = require("@foxglove/rosmsg2-serialization");

const definition = `std_msgs/Header header
uint32 height
uint32 width
uint64 seq
uint64 time_base
string encoding
bool is_bigendian
uint8[] events
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
`;

async function main() {
  const parts = [];
  let position = 0n;
  const writable = {
    write: async (bytes) => { parts.push(Buffer.from(bytes)); position += BigInt(bytes.byteLength); },
    position: () => position,
  };
  const writer = new McapWriter({ writable, chunkSize: 2000 });
  await writer.start({ profile: "ros2", library: "reference" });
  const schemaId = await writer.registerSchema({ name: "event_camera_msgs/msg/EventPacket", encoding: "ros2msg", data: Buffer.from(definition) });
  const channelId = await writer.registerChannel({ topic: "/camera/events", messageEncoding: "cdr", schemaId, metadata: new Map() });
  const serializer = new MessageWriter(parse(definition, { ros2: true }));
  for (let message = 0; message < 20; ++message) {
    const timeBase = 1000000000n + BigInt(message) * 350000n;
    const events = Buffer.alloc(400);
    for (let k = 0; k < 50; ++k) {
      const i = message * 50 + k;
      const word = (BigInt(i % 2 === 0) << 63n) | (BigInt(i % 200) << 48n) | (BigInt(i % 300) << 32n) | BigInt(k * 7000);
      events.writeBigUInt64LE(word, 8 * k);
    }
    const data = serializer.writeMessage({ header: { stamp: { sec: 1, nanosec: 0 }, frame_id: "odd" }, height: 240, width: 304,
      seq: BigInt(message), time_base: timeBase, encoding: "mono", is_bigendian: false, events });
    await writer.addMessage({ channelId, sequence: message, logTime: timeBase, publishTime: timeBase, data });
  }
  await writer.end();
  fs.writeFileSync(process.argv[2], Buffer.concat(parts));
}

main();
