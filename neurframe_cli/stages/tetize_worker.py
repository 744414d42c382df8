"""The process in which fTetWild runs: it may crash here, and only here.

    python -m neurframe_cli.stages.tetize_worker INPUT.npz OUTPUT.npz SETTINGS

INPUT holds V (n,3) and F (m,3), OUTPUT gets V and T; SETTINGS is a JSON object of arguments for
`pytetwild.tetrahedralize`.  fTetWild's log goes to stderr, where the parent reads how far it is.
Exit codes: 0, 1 for any failure of fTetWild, REFUSED where the system did not let OUTPUT be written; the last line on
stderr is then the number of the system's error.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

REFUSED = 3


def main(argv: list[str]) -> int:
    source, target, settings = argv
    os.dup2(2, 1)  # fTetWild logs to stdout from C++
    import numpy as np
    import pytetwild

    with np.load(source, allow_pickle=False) as arrays:
        V, F = arrays["V"], arrays["F"]
    V, T = pytetwild.tetrahedralize(V, F.astype(np.int32), quiet=False, loglevel=6, **json.loads(settings))
    partial = Path(target).with_suffix(".partial.npz")
    try:
        np.savez(partial, V=V.astype(np.float64), T=T.astype(np.int64))
        partial.rename(target)
    except OSError as error:
        print(error.errno, file=sys.stderr)
        return REFUSED
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
