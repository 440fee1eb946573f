// What read_bag.cjs and read_mcap.cjs share.

/** Events of an EventPacket of encoding mono. */
function eventsOfPacket(message) {
  if (message.encoding !== "mono" || message.is_bigendian) throw new Error(`encoding ${message.encoding}`);
  const bytes = Buffer.from(message.events.buffer, message.events.byteOffset, message.events.byteLength);
  const events = [];
  for (let at = 0; at < bytes.length; at += 8) {
    const word = bytes.readBigUInt64LE(at);
    events.push([message.time_base + (word & 0xffffffffn), Number((word >> 32n) & 0xffffn), Number((word >> 48n) & 0x7fffn),
                 word >> 63n !== 0n]);
  }
  return events;
}

function printEvents(events) {
  process.stdout.write(events.map(([t, x, y, on, camera]) => `${t} ${x} ${y} ${on ? 1 : 0} ${camera}\n`).join(""));
}

/** 1 for a topic of the right camera, otherwise 0. */
function cameraOf(topic) {
  return topic.includes("right") ? 1 : 0;
}

module.exports = { cameraOf, eventsOfPacket, printEvents };
