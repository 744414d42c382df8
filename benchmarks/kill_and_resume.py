"""Kill a stage with SIGKILL at random moments, run it again, and compare with an undisturbed run.

    python benchmarks/kill_and_resume.py samples/cube.stl --edge-length 0.2 --kills 20

For each stage: one undisturbed run, then per kill a fresh copy, the same command killed at a random moment of the
stage's work, every file that is left checked (an artifact is whole or not there), the command run again, and the
outputs compared byte by byte.  The work lasts while the manifest says "running": the moment is a random share of what
it took undisturbed.  Where it was over by then, because the machine has become faster, another moment is drawn.
Prints one JSON line a kill and a summary; exit status 1 where anything differed.
"""

from __future__ import annotations

import argparse
import json
import random
import shutil
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
POLL_S = 0.005
OPTIONS = {
    "discretize": ["--no-pictures"],
    "quad": ["--no-pictures", "--scale", "30"],
    "hex": ["--no-pictures", "--scale", "8"],
}


def main() -> None:
    arguments = parse_arguments()
    with tempfile.TemporaryDirectory() as scratch:
        before = Path(scratch) / "before"
        before.mkdir()
        done: set[str] = set()
        failures = 0
        for stage in (name for name in OUTPUTS if name in arguments.stages):
            for earlier in (name for name in BEFORE[stage] if name not in done):
                subprocess.run(command(earlier, arguments, before), check=True)
                done.add(earlier)
            rng = random.Random(arguments.seed)
            failures += kill_stage(stage, arguments, before, Path(scratch) / stage, rng)
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


def kill_stage(
    stage: str, arguments: argparse.Namespace, before: Path, scratch: Path, rng: random.Random
) -> int:
    """Number of kills after which the second run did not end as the undisturbed one did."""
    scratch.mkdir()
    reference, seconds = undisturbed(stage, arguments, before, scratch / "reference")
    failures, at_work, too_late, number = 0, 0, 0, 0
    while number < arguments.kills:
        outcome = kill_once(stage, arguments, before, scratch / "victim", rng.random() * seconds, reference)
        if outcome is None:
            too_late += 1
            continue
        number += 1
        outcome = {"stage": stage, "kill": number, **outcome}
        failures += bool(outcome["torn"] or outcome["left_over"] or outcome["exit"] or not outcome["same"])
        at_work += outcome["status"] == "running"
        print(json.dumps(outcome), flush=True)
    print(
        f"{stage}: {arguments.kills} kills within {seconds:.1f} s, {at_work} of them at work, "
        f"{failures} with another result; {too_late} moments too late",
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
    """The outputs' hashes, and the seconds of the stage's work."""
    shutil.copytree(before, folder)
    process = subprocess.Popen(command(stage, arguments, folder))
    wait_for_work(process, stage, folder)
    began = time.monotonic()
    while process.poll() is None and status_of(stage, folder) == "running":
        time.sleep(POLL_S)
    seconds = time.monotonic() - began
    if process.wait() != 0:
        sys.exit(f"{stage}: exit code {process.returncode} of the undisturbed run")
    return hashes(stage, folder), seconds


def wait_for_work(process: subprocess.Popen[bytes], stage: str, folder: Path) -> None:
    """Return when the manifest says that the stage has begun, or when the process has ended."""
    while process.poll() is None and status_of(stage, folder) is None:
        time.sleep(POLL_S)


def status_of(stage: str, folder: Path) -> str | None:
    """What the manifest says of the stage, None where it says nothing."""
    record = read_manifest(folder).stages.get(stage)
    return None if record is None else record.status


def kill_once(
    stage: str,
    arguments: argparse.Namespace,
    before: Path,
    folder: Path,
    delay: float,
    reference: dict[str, str],
) -> dict[str, object] | None:
    """Kill `delay` seconds into the work, look for torn files, run again, compare with the outputs in `reference`.

    None where the work had ended by then.
    """
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(before, folder)
    victim = subprocess.Popen(
        command(stage, arguments, folder), start_new_session=True, stderr=subprocess.DEVNULL
    )
    wait_for_work(victim, stage, folder)
    time.sleep(delay)
    if status_of(stage, folder) != "running":
        victim.wait()
        return None
    victim.kill()
    victim.wait()
    status = status_of(stage, folder)
    torn = torn_files(stage, folder, reference)
    again = subprocess.run(command(stage, arguments, folder), check=False)
    return {
        "after_s": round(delay, 2),
        "status": status,
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
