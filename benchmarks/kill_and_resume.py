"""Kill a stage with SIGKILL at random moments, run it again, and compare with an undisturbed run.

    python benchmarks/kill_and_resume.py samples/cube.stl --edge-length 0.2 --kills 20

For each stage: one undisturbed run, then per kill a fresh copy, the same command killed after a random
share of the undisturbed time, every file that is left checked (an artifact is whole or not there), the command run
again, and the outputs compared byte by byte.  Prints one JSON line a kill and a summary; exit status 1 where anything
differed.  `status` is what the manifest said of the stage when it was killed, null where it had not begun.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from neurframe_cli.pipeline.atomic import TEMPORARY_PREFIX, sha256_of
from neurframe_cli.pipeline.manifest import read_manifest

OUTPUTS = {
    "tetize": ("surface.ply", "tets.mesh", "features.json"),
    "train": ("field.safetensors",),
    "discretize": ("tets.fra", "cross.npz"),
    "quad": ("map.obj", "quad.obj"),
    "hex": ("map.hexex", "hex.vtk"),
}
# what has to be there before a stage
BEFORE = {
    "tetize": (),
    "train": ("tetize",),
    "discretize": ("tetize", "train"),
    "quad": ("tetize", "train", "discretize"),
    "hex": ("tetize", "train", "discretize"),
}
OPTIONS = {
    "discretize": ["--no-pictures"],
    "quad": ["--no-pictures", "--scale", "30"],
    "hex": ["--no-pictures", "--scale", "8"],
}


def main() -> None:
    arguments = parse_arguments()
    with tempfile.TemporaryDirectory() as scratch:
        failures = sum(
            kill_stage(stage, arguments, Path(scratch) / stage, random.Random(arguments.seed))
            for stage in arguments.stages
        )
    sys.exit(1 if failures else 0)


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("model", type=Path)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--edge-length", default="0.05")
    parser.add_argument("--stages", nargs="+", choices=list(OUTPUTS), default=list(OUTPUTS))
    return parser.parse_args()


def kill_stage(stage: str, arguments: argparse.Namespace, scratch: Path, rng: random.Random) -> int:
    """Number of kills after which the second run did not end as the undisturbed one did."""
    scratch.mkdir()
    before = scratch / "before"
    before.mkdir()
    for earlier in BEFORE[stage]:
        subprocess.run(command(earlier, arguments, before), check=True)
    reference, seconds = undisturbed(stage, arguments, before, scratch / "reference")
    failures, at_work = 0, 0
    number = 0
    while number < arguments.kills:
        outcome = kill_once(stage, arguments, before, scratch / "victim", rng.random() * seconds, reference)
        if outcome is None:
            seconds *= 0.9  # the machine has become faster since the undisturbed run
            continue
        number += 1
        outcome = {"stage": stage, "kill": number, **outcome}
        failures += bool(outcome["torn"] or outcome["left_over"] or outcome["exit"] or not outcome["same"])
        at_work += outcome["status"] == "running"
        print(json.dumps(outcome), flush=True)
    print(
        f"{stage}: {arguments.kills} kills within {seconds:.1f} s, {at_work} of them at work, "
        f"{failures} with another result",
        flush=True,
    )
    return failures


def command(stage: str, arguments: argparse.Namespace, workspace: Path) -> list[str]:
    base = [sys.executable, "-m", "neurframe_cli", stage, "-q", "--threads", "1", "-w", str(workspace)]
    if stage == "tetize":
        return [*base, str(arguments.model), "--edge-length", arguments.edge_length]
    return [*base, *OPTIONS.get(stage, [])]


def undisturbed(
    stage: str, arguments: argparse.Namespace, before: Path, folder: Path
) -> tuple[dict[str, str], float]:
    shutil.copytree(before, folder)
    started = time.monotonic()
    subprocess.run(command(stage, arguments, folder), check=True)
    return hashes(stage, folder), time.monotonic() - started


def kill_once(
    stage: str,
    arguments: argparse.Namespace,
    before: Path,
    folder: Path,
    delay: float,
    reference: dict[str, str],
) -> dict[str, object] | None:
    """Kill after `delay` seconds, look for torn files, run again, compare with the outputs in `reference`.

    None where the command had ended by then.
    """
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(before, folder)
    victim = subprocess.Popen(
        command(stage, arguments, folder), start_new_session=True, stderr=subprocess.DEVNULL
    )
    time.sleep(delay)
    if victim.poll() is not None:
        return None
    os.kill(victim.pid, signal.SIGKILL)
    victim.wait()
    record = read_manifest(folder).stages.get(stage)
    torn = torn_files(stage, folder, reference)
    again = subprocess.run(command(stage, arguments, folder), check=False)
    return {
        "after_s": round(delay, 2),
        "status": None if record is None else record.status,
        "torn": torn,
        "exit": again.returncode,
        "left_over": sorted(path.name for path in folder.glob(TEMPORARY_PREFIX + "*")),
        "same": hashes(stage, folder) == reference,
    }


def torn_files(stage: str, folder: Path, reference: dict[str, str]) -> list[str]:
    """Artifacts that are neither what the manifest says of a finished stage nor what this stage writes in the end."""
    recorded = {
        name: digest
        for record in read_manifest(folder).stages.values()
        if record.status == "done"
        for name, digest in record.outputs.items()
    }
    expected = recorded | {name: reference[name] for name in hashes(stage, folder)}
    return [
        name
        for name, digest in expected.items()
        if not (folder / name).is_file() or sha256_of(folder / name) != digest
    ]


def hashes(stage: str, folder: Path) -> dict[str, str]:
    return {name: sha256_of(folder / name) for name in OUTPUTS[stage] if (folder / name).is_file()}


if __name__ == "__main__":
    main()
