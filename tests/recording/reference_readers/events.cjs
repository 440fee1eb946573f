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
  process.stdout.write(events.map(([t, x, y, on]) => `${t} ${x} ${y} ${on ? 1 : 0}\n`).join(""));
}

module.exports = { eventsOfPacket, printEvents };
