#!/usr/bin/env python3
"""Writes the float32 arrays of an NPZ file as C++: a function that returns them as saccade::ModelArrays.

usage: embed_arrays.py FILE.npz FUNCTION OUT.cpp
"""
import ast
import struct
import sys
import zipfile


def values_of(data, name):
    """The numbers of an array in NumPy's format (version 1 or 2)."""
    if data[:6] != b"\x93NUMPY" or data[6] not in (1, 2):
        sys.exit(f"{name}: not an array in NumPy's format 1 or 2")
    size = 2 if data[6] == 1 else 4
    begin = 8 + size + int.from_bytes(data[8 : 8 + size], "little")
    header = ast.literal_eval(data[8 + size : begin].decode("latin-1"))
    if header["descr"] != "<f4" or header["fortran_order"]:
        sys.exit(f"{name}: found {header}, expected '<f4' in C order")
    return struct.unpack(f"<{(len(data) - begin) // 4}f", data[begin:])


def main():
    source, function, target = sys.argv[1:]
    lines = [
        "// Made by cmake/embed_arrays.py.",
        '#include "core/model_arrays.h"',
        "",
        "namespace saccade {",
        f"ModelArrays {function}();",
        "namespace {",
    ]
    names = []
    with zipfile.ZipFile(source) as file:
        for number, member in enumerate(sorted(file.namelist())):
            names.append(member.removesuffix(".npy"))
            values = [float(value).hex() + "F" for value in values_of(file.read(member), member)]
            lines.append(f"constexpr float array_{number}[] = {{")
            lines += [", ".join(values[i : i + 8]) + "," for i in range(0, len(values), 8)]
            lines.append("};")
    lines += ["}  // namespace", f"ModelArrays {function}() {{", "  ModelArrays arrays;"]
    lines += [
        f'  arrays.add("{name}", {{std::begin(array_{i}), std::end(array_{i})}});' for i, name in enumerate(names)
    ]
    lines += ["  return arrays;", "}", "}  // namespace saccade", ""]
    with open(target, "w") as file:
        file.write("\n".join(lines))


if __name__ == "__main__":
    main()
