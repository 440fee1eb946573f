"""python3 read_ros2_bag.py FILE: writes the events of a ROS 2 bag in SQLite, as Python's sqlite3 reads it, to standard output, as
events.cjs says, then a line `TOPIC,... TYPE MESSAGES` to standard error. A member that an EventPacket of encoding mono does not
have, or bytes after the last one, end it with an error."""

import sqlite3
import struct
import sys

import numpy as np

MONO = np.dtype("<u8")
RECORD = np.dtype({"names": ["t", "x", "y", "p", "camera"], "formats": ["<i8", "<u2", "<u2", "?", "u1"],
                   "offsets": [0, 8, 10, 12, 13], "itemsize": 16})


class Cdr:
    """OMG's CDR, little-endian: numbers at multiples of their size, counted from the byte after the encapsulation."""

    def __init__(self, message):
        if message[:4] != b"\0\1\0\0":
            sys.exit(f"read_ros2_bag: encapsulation {message[:4].hex()}")
        self.bytes, self.at = message[4:], 0

    def number(self, kind):
        size = struct.calcsize(kind)
        self.at += -self.at % size
        self.at += size
        return struct.unpack_from("<" + kind, self.bytes, self.at - size)[0]

    def octets(self):
        length = self.number("I")
        self.at += length
        return self.bytes[self.at - length:self.at]

    def text(self):
        octets = self.octets()
        if not octets.endswith(b"\0"):
            sys.exit("read_ros2_bag: a text without its NUL")
        return octets[:-1].decode()


def packet(message, camera):
    """The events of an EventPacket."""
    cdr = Cdr(message)
    cdr.number("i"), cdr.number("I"), cdr.text()  # header: stamp, frame
    height, width = cdr.number("I"), cdr.number("I")
    cdr.number("Q")  # seq
    time_base_ns = cdr.number("Q")
    encoding, is_big = cdr.text(), cdr.number("B")
    words = np.frombuffer(cdr.octets(), MONO)
    if encoding != "mono" or is_big or cdr.at != len(cdr.bytes):
        sys.exit(f"read_ros2_bag: {encoding}, is_bigendian {is_big}, {len(cdr.bytes) - cdr.at} bytes after the events")
    events = np.zeros(len(words), RECORD)
    events["t"] = time_base_ns + (words & 0xffffffff).astype(np.int64)
    events["x"], events["y"], events["p"] = words >> 32 & 0xffff, words >> 48 & 0x7fff, words >> 63
    events["camera"] = camera
    if len(events) and (events["x"].max() >= width or events["y"].max() >= height):
        sys.exit("read_ros2_bag: an event outside the image")
    return events


database = sqlite3.connect(f"file:{sys.argv[1]}?mode=ro", uri=True)
if database.execute("PRAGMA integrity_check").fetchone() != ("ok",):
    sys.exit("read_ros2_bag: the database is damaged")
((schema_version,),) = database.execute("SELECT schema_version FROM schema")
topics = {number: (name, kind) for number, name, kind, form, _, _ in database.execute(
    "SELECT id, name, type, serialization_format, offered_qos_profiles, type_description_hash FROM topics ORDER BY id")
    if form == "cdr"}
((defined,),) = database.execute("SELECT topic_type FROM message_definitions WHERE encoding = 'ros2msg'")
if schema_version != 4 or any(kind != defined for _, kind in topics.values()):
    sys.exit(f"read_ros2_bag: schema version {schema_version}, types {topics}, a definition of {defined}")
messages = 0
for topic, data in database.execute("SELECT topic_id, data FROM messages ORDER BY timestamp, id"):
    sys.stdout.buffer.write(packet(data, int("right" in topics[topic][0])).tobytes())
    messages += 1
print(",".join(name for name, _ in topics.values()), defined, messages, file=sys.stderr)
