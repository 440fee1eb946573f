"""python3 read_array.py FILE: writes the events of a .npz or .npy file, as NumPy reads it, to standard output, as events.cjs says."""

import sys

import numpy as np

BLOCK = 1 << 20
RECORD = np.dtype({"names": ["t", "x", "y", "p", "camera"], "formats": ["<i8", "<u2", "<u2", "?", "u1"],
                   "offsets": [0, 8, 10, 12, 13], "itemsize": 16})

loaded = np.load(sys.argv[1])
events = loaded["events"] if sys.argv[1].endswith(".npz") else loaded
for begin in range(0, len(events), BLOCK):
    part = events[begin:begin + BLOCK]
    records = np.zeros(len(part), RECORD)
    for name in part.dtype.names:
        records[name] = part[name]
    records["t"] *= 1000
    sys.stdout.buffer.write(records.tobytes())
