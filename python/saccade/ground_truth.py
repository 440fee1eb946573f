"""The ground truth of every pixel that a run has written (docs/ground_truth.md)."""

import ast
import os
import zipfile

import numpy as np


class GroundTruth:
    """The arrays of ground_truth.npz or ground_truth.h5 by their names: truth["left/depth_m"].

    path: the file, or the run folder that has it. Those of a .npz are mapped into memory, so that only what is used is read;
    a .h5 needs h5py (Debian package python3-h5py), and its arrays are datasets of h5py. Iteration gives one dict per
    instant, with t_us and the arrays that have an instant per row.
    """

    def __init__(self, path):
        path = os.fspath(path)
        if os.path.isdir(path):
            names = [os.path.join(path, name) for name in ("ground_truth.npz", "ground_truth.h5")]
            found = [name for name in names if os.path.exists(name)]
            if not found:
                raise ValueError(f"{path}: found no ground_truth.npz or ground_truth.h5, expected the folder of a run with "
                                 "output.ground_truth")
            path = found[0]
        self.path = path
        self._arrays = _hdf5_arrays(path) if path.endswith(".h5") else npz_arrays(path)
        if "t_us" not in self._arrays:
            raise ValueError(f"{path}: found no array t_us, expected ground truth of saccade")

    @property
    def names(self):
        """Names of the arrays."""
        return list(self._arrays)

    @property
    def t_us(self):
        """Times of the instants."""
        return np.asarray(self._arrays["t_us"])

    def __getitem__(self, name):
        if name not in self._arrays:
            raise KeyError(f"{name}: found no such array in {self.path}, expected one of {', '.join(self._arrays)}")
        array = self._arrays[name]
        return [text.decode() for text in np.asarray(array)] if array.dtype.kind == "S" else array

    def __contains__(self, name):
        return name in self._arrays

    def __len__(self):
        return len(self._arrays["t_us"])

    def __iter__(self):
        names = [name for name, array in self._arrays.items() if _is_per_instant(name)]
        for i in range(len(self)):
            yield {name: self._arrays[name][i] for name in names}

    def at(self, t_us):
        """The dict of the newest instant up to t_us; None before the first one."""
        i = int(np.searchsorted(self.t_us, t_us, side="right")) - 1
        if i < 0:
            return None
        return {name: array[i] for name, array in self._arrays.items() if _is_per_instant(name)}


def _is_per_instant(name):
    return not (name in ("objects", "poses/bodies", "poses/joints") or name.startswith("imu/") or "/camera/" in name)


def npz_arrays(path, wanted=None):
    """The members of a .npz without compression, mapped; only those named in `wanted` where it is given."""
    arrays = {}
    try:
        with zipfile.ZipFile(path) as archive:
            members = archive.infolist()
        mapped = np.memmap(path, np.uint8, "r")
        for member in members:
            name = member.filename.removesuffix(".npy")
            if wanted is not None and name not in wanted:
                continue
            if member.compress_type != zipfile.ZIP_STORED:
                raise ValueError(f"{path}: found the compressed member {member.filename}, expected an array as saccade writes it")
            lengths = mapped[member.header_offset + 26:member.header_offset + 30].view("<u2")  # of name and extra bytes
            arrays[name] = _array_at(mapped, member.header_offset + 30 + int(lengths.sum()))
    except (OSError, SyntaxError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path}: found {error}, expected arrays as saccade writes them") from error
    return arrays


def npy_array(path):
    """The array of a .npy file, mapped."""
    try:
        return _array_at(np.memmap(path, np.uint8, "r"), 0)
    except (OSError, SyntaxError, ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{path}: found {error}, expected an array as saccade writes it") from error


def _array_at(mapped, start):
    """The array of a .npy file that begins at a byte of a mapped file. np.load() takes a millisecond for a header."""
    if bytes(mapped[start:start + 8]) != b"\x93NUMPY\x01\x00":
        raise ValueError("no array of NumPy")
    begin = start + 10
    end = begin + int(mapped[start + 8:begin].view("<u2")[0])
    header = ast.literal_eval(bytes(mapped[begin:end]).decode("latin1").strip())
    return np.ndarray(header["shape"], np.dtype(header["descr"]), mapped, end, order="F" if header["fortran_order"] else "C")


def _hdf5_arrays(path):
    try:
        import h5py
    except ImportError as error:
        raise ImportError(f"{path}: needs h5py (Debian package python3-h5py), or output.ground_truth.format: npz") from error
    try:
        file = h5py.File(path, "r")
    except OSError as error:
        raise ValueError(f"{path}: found {error}, expected ground truth of saccade") from error
    arrays = {}
    file.visititems(lambda name, item: arrays.update({name: item}) if isinstance(item, h5py.Dataset) else None)
    return arrays
