"""Why the part of saccade in C++ cannot be imported."""
import re
import sys
from pathlib import Path


def reason(error):
    """The versions of Python that the module is built for where this one is not among them, else the loader's reason."""
    built = sorted(match[1] for file in sorted(Path(__file__).parent.glob("_saccade.*.so"))
                   if (match := re.match(r"_saccade\.cpython-(3\d+)-", file.name)))
    this = f"{sys.version_info.major}{sys.version_info.minor}"
    if this in built:
        return f"saccade cannot be loaded: {error}"
    names = ", ".join(f"{version[0]}.{version[1:]}" for version in built) or "no Python"
    return f"saccade is built for Python {names}: found Python {sys.version.split()[0]}"
