// What read_bag.cjs and read_mcap.cjs share.

const fs = require("fs");

const recordBytes = 16;

/**
 * Writes events to standard output in records of 16 bytes, little-endian: int64 time in ns, uint16 x, uint16 y, uint8 polarity
 * (1 is ON), uint8 camera, two bytes 0. Nothing but one message is kept in memory.
 */
class RecordWriter {
  constructor(events, camera) {
    this.bytes = Buffer.alloc(recordBytes * events);
    this.camera = camera;
    this.at = 0;
  }
  add(timeNs, x, y, on) {
    this.bytes.writeBigInt64LE(timeNs, this.at);
    this.bytes.writeUInt16LE(x, this.at + 8);
    this.bytes.writeUInt16LE(y, this.at + 10);
    this.bytes[this.at + 12] = on ? 1 : 0;
    this.bytes[this.at + 13] = this.camera;
    this.at += recordBytes;
  }
  flush() {
    for (let done = 0; done < this.at;) done += fs.writeSync(1, this.bytes, done, this.at - done);
  }
}

/** Writes the events of an EventPacket of encoding mono. */
function writePacket(message, camera) {
  if (message.encoding !== "mono" || message.is_bigendian) throw new Error(`encoding ${message.encoding}`);
  const bytes = Buffer.from(message.events.buffer, message.events.byteOffset, message.events.byteLength);
  const writer = new RecordWriter(bytes.length / 8, camera);
  for (let at = 0; at < bytes.length; at += 8) {
    const place = bytes.readUInt32LE(at + 4);
    writer.add(message.time_base + BigInt(bytes.readUInt32LE(at)), place & 0xffff, (place >>> 16) & 0x7fff, place >>> 31);
  }
  writer.flush();
}

/** Writes the events of an EventArray. */
function writeArray(message, camera) {
  const writer = new RecordWriter(message.events.length, camera);
  for (const event of message.events)
    writer.add(BigInt(event.ts.sec) * 1000000000n + BigInt(event.ts.nsec), event.x, event.y, event.polarity);
  writer.flush();
}

/** 1 for a topic of the right camera, otherwise 0. */
function cameraOf(topic) {
  return topic.includes("right") ? 1 : 0;
}

/** A failure of the reader is one of the program. */
function run(main) {
  main().catch((error) => {
    console.error(error);
    process.exit(1);
  });
}

module.exports = { cameraOf, run, writeArray, writePacket };
