"""The workspace: what is unchanged is skipped, what is killed leaves nothing torn, two writers never meet."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

from neurframe_cli.errors import NotValid, StageError, TooNewFile, UnreadableFile, UsageError, WorkspaceBusy
from neurframe_cli.mesh.arrays import silent
from neurframe_cli.pipeline.atomic import TEMPORARY_PREFIX, atomic_path, sha256_of, write_json
from neurframe_cli.pipeline.lock import exclusive
from neurframe_cli.pipeline.manifest import MANIFEST_NAME, read_manifest, write_manifest
from neurframe_cli.pipeline.runner import StageContext, Step, run_stage
from neurframe_cli.pipeline.workspace import Workspace, find_workspace, workspace_for_input


def doubling_step(folder: Path, calls: list[int], factor: int = 2, version: int = 1) -> Step:
    """A stage that multiplies the number in `source` and writes it to the workspace."""

    def work(context: StageContext) -> dict[str, int]:
        calls.append(factor)
        value = factor * int((folder / "source").read_text())
        with atomic_path(context.workspace / "product") as temporary:
            temporary.write_text(str(value))
        return {"value": value}

    return Step("double", version, {"source": folder / "source"}, ("product",), {"factor": factor}, work)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "source").write_text("21")
    return tmp_path


def test_unchanged_stage_is_skipped_and_every_change_runs_it_again(folder: Path) -> None:
    workspace, calls = Workspace(folder), []
    assert not run_stage(workspace, doubling_step(folder, calls), silent).skipped
    assert (folder / "product").read_text() == "42"
    again = run_stage(workspace, doubling_step(folder, calls), silent)
    assert again.skipped
    assert again.record.report == {"value": 42}
    (folder / "product").write_text("spoilt")
    assert not run_stage(workspace, doubling_step(folder, calls), silent).skipped
    (folder / "product").unlink()
    assert not run_stage(workspace, doubling_step(folder, calls), silent).skipped
    (folder / "source").write_text("4")
    assert not run_stage(workspace, doubling_step(folder, calls), silent).skipped
    assert not run_stage(workspace, doubling_step(folder, calls, factor=3), silent).skipped
    assert not run_stage(workspace, doubling_step(folder, calls, factor=3, version=2), silent).skipped
    assert not run_stage(
        workspace, doubling_step(folder, calls, factor=3, version=2), silent, force=True
    ).skipped
    assert (folder / "product").read_text() == "12"
    assert len(calls) == 7


def test_failure_is_recorded_and_tried_again(folder: Path) -> None:
    (folder / "source").write_text("1")
    step = doubling_step(folder, [])

    def fail(context: StageContext) -> dict[str, int]:
        raise StageError("no luck")

    broken = Step(step.name, 1, step.inputs, step.outputs, step.options, fail)
    with pytest.raises(StageError, match="no luck"):
        run_stage(Workspace(folder), broken, silent)
    record = read_manifest(folder).stages["double"]
    assert (record.status, record.error) == ("failed", "no luck")
    assert not run_stage(Workspace(folder), step, silent).skipped


def test_invalid_result_is_kept_and_said_again_without_doing_it_again(folder: Path) -> None:
    calls: list[int] = []
    sound = doubling_step(folder, calls)

    def work(context: StageContext) -> dict[str, int]:
        report = sound.work(context)
        context.invalid = "two cells are inverted"
        return report

    step = Step(sound.name, 1, sound.inputs, sound.outputs, sound.options, work)
    for _ in range(2):
        with pytest.raises(NotValid, match="two cells"):
            run_stage(Workspace(folder), step, silent)
    assert calls == [2]
    assert (folder / "product").read_text() == "42"
    assert read_manifest(folder).stages["double"].report == {"value": 42}


def test_what_an_unfinished_or_outdated_stage_left_is_refused(folder: Path) -> None:
    workspace = Workspace(folder)
    run_stage(workspace, doubling_step(folder, []), silent)

    def copy(context: StageContext) -> dict[str, int]:
        with atomic_path(context.workspace / "copy") as temporary:
            temporary.write_text((folder / "product").read_text())
        return {}

    def reader() -> Step:
        return Step("copy", 1, {"product": folder / "product"}, ("copy",), {}, copy)

    run_stage(workspace, reader(), silent)
    (folder / "source").write_text("5")
    with pytest.raises(UsageError, match="another source"):
        run_stage(workspace, reader(), silent)
    manifest = read_manifest(folder)
    manifest.stages["double"].status = "running"
    write_manifest(folder, manifest)
    with pytest.raises(UsageError, match="did not finish"):
        run_stage(workspace, reader(), silent)
    run_stage(workspace, doubling_step(folder, []), silent)
    run_stage(workspace, reader(), silent)
    assert (folder / "copy").read_text() == "10"


def test_a_stage_never_writes_over_its_own_input(folder: Path) -> None:
    (folder / "product").write_text("4")
    step = doubling_step(folder, [])
    greedy = Step("double", 1, {"source": folder / "product"}, step.outputs, step.options, step.work)
    with pytest.raises(UsageError, match="write over its input"):
        run_stage(Workspace(folder), greedy, silent)
    assert (folder / "product").read_text() == "4"


def test_a_lock_that_is_a_link_is_refused_and_its_target_kept(tmp_path: Path) -> None:
    (tmp_path / "victim").write_text("precious")
    (tmp_path / "ws").mkdir()
    (tmp_path / "ws" / ".lock").symlink_to(tmp_path / "victim")
    with pytest.raises(StageError, match="cannot write"), exclusive(tmp_path / "ws"):
        pass
    assert (tmp_path / "victim").read_text() == "precious"


def test_manifest_records_hashes_options_and_versions(folder: Path) -> None:
    run_stage(Workspace(folder), doubling_step(folder, []), silent)
    record = read_manifest(folder).stages["double"]
    assert record.outputs == {"product": sha256_of(folder / "product")}
    assert record.inputs == {"source": sha256_of(folder / "source")}
    assert record.options == {"factor": 2}
    assert "neurframe" in record.versions
    assert record.peak_mib > 0


def test_atomic_file_keeps_the_old_content_when_writing_fails(tmp_path: Path) -> None:
    target = tmp_path / "artifact.txt"
    target.write_text("old")

    def write_half_and_fail() -> None:
        with atomic_path(target) as temporary:
            temporary.write_text("ne")
            raise RuntimeError("stopped in the middle")

    with pytest.raises(RuntimeError):
        write_half_and_fail()
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_write_into_missing_folder_is_a_stage_error(tmp_path: Path) -> None:
    with pytest.raises(StageError, match="cannot write"):
        write_json(tmp_path / "nowhere" / "file.json", {})


def test_same_value_gives_same_json_bytes(tmp_path: Path) -> None:
    write_json(tmp_path / "a", {"x": 1, "y": [0.1, 2]})
    write_json(tmp_path / "b", {"y": [0.1, 2], "x": 1})
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()


HOLDER = """
    import sys, time
    from pathlib import Path
    from neurframe_cli.pipeline.lock import exclusive
    with exclusive(Path(sys.argv[1])):
        print("held", flush=True)
        time.sleep(60)
"""


def test_second_writer_is_refused_and_a_killed_one_frees_the_lock(tmp_path: Path) -> None:
    holder = subprocess.Popen(
        [sys.executable, "-c", textwrap.dedent(HOLDER), str(tmp_path)], stdout=subprocess.PIPE, text=True
    )
    assert holder.stdout is not None
    assert holder.stdout.readline() == "held\n"
    with pytest.raises(WorkspaceBusy, match=str(holder.pid)), exclusive(tmp_path):
        pass
    holder.kill()
    holder.wait()
    holder.stdout.close()
    with exclusive(tmp_path):
        pass


SLOW_WRITER = """
    import sys, time
    from pathlib import Path
    from neurframe_cli.mesh.arrays import silent
    from neurframe_cli.pipeline.atomic import atomic_path
    from neurframe_cli.pipeline.runner import Step, run_stage
    from neurframe_cli.pipeline.workspace import Workspace
    folder = Path(sys.argv[1])
    def work(context):
        for name in ("first", "second"):
            with atomic_path(context.workspace / name) as temporary, temporary.open("w") as out:
                for _ in range(200):
                    out.write("x" * 1000)
                    out.flush()
                    time.sleep(0.001)
        return {}
    run_stage(Workspace(folder), Step("slow", 1, {}, ("first", "second"), {}, work), silent)
"""


@pytest.mark.parametrize("delay", [0.0, 0.1, 0.3])
def test_killed_stage_leaves_whole_files_and_runs_again(tmp_path: Path, delay: float) -> None:
    command = [sys.executable, "-c", textwrap.dedent(SLOW_WRITER), str(tmp_path)]
    victim = subprocess.Popen(command)
    deadline = time.monotonic() + 120
    while not list(tmp_path.glob(TEMPORARY_PREFIX + "*")) and time.monotonic() < deadline:
        time.sleep(0.01)
    time.sleep(delay)
    os.kill(victim.pid, signal.SIGKILL)
    victim.wait()
    for name in ("first", "second"):
        assert not (tmp_path / name).exists() or (tmp_path / name).stat().st_size == 200_000
    subprocess.run(command, check=True)
    assert read_manifest(tmp_path).stages["slow"].status == "done"
    assert not list(tmp_path.glob(TEMPORARY_PREFIX + "*"))


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", '{"format": "other"}', '{"format": "neurframe-workspace"}', "\xff", "[" * 100000]
    + [
        json.dumps({"format": "neurframe-workspace", "version": 1, "stages": stages})
        for stages in ([], {"train": 1}, {"train": {"status": 3, "key": ""}}, {"train": {"sttus": "done"}})
    ],
)
def test_malformed_manifest_is_named(tmp_path: Path, text: str) -> None:
    (tmp_path / MANIFEST_NAME).write_text(text, encoding="latin-1")
    with pytest.raises(UnreadableFile, match=r"manifest\.json"):
        read_manifest(tmp_path)


def test_manifest_of_a_later_version_is_refused(tmp_path: Path) -> None:
    write_json(tmp_path / MANIFEST_NAME, {"format": "neurframe-workspace", "version": 2, "stages": {}})
    with pytest.raises(TooNewFile, match="version 2"):
        read_manifest(tmp_path)


def test_workspace_is_found_by_the_rules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UsageError, match="no workspace here"):
        find_workspace(None)
    for name in ("part.stl", "other.stl"):
        Path(name).write_text("solid")
    made = workspace_for_input(Path("part.stl"), None)
    assert made.folder == Path("part.neurframe")
    assert find_workspace(None).folder == Path("part.neurframe")
    workspace_for_input(Path("other.stl"), None)
    with pytest.raises(UsageError, match=r"other\.neurframe, part\.neurframe"):
        find_workspace(None)
    assert find_workspace(Path("part.neurframe")).folder == Path("part.neurframe")
    write_json(tmp_path / MANIFEST_NAME, {})
    assert find_workspace(None).folder == Path()
    with pytest.raises(UsageError, match="no workspace"):
        find_workspace(Path("missing"))


def test_missing_input_makes_no_workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UnreadableFile, match=r"part\.stl"):
        workspace_for_input(Path("part.stl"), None)
    assert list(tmp_path.iterdir()) == []


def test_artifact_that_links_out_of_the_workspace_is_refused(tmp_path: Path) -> None:
    (tmp_path / "outside").mkdir()
    (tmp_path / "inside").mkdir()
    (tmp_path / "inside" / "tets.mesh").symlink_to(tmp_path / "outside" / "target")
    with pytest.raises(UsageError, match="outside the workspace"):
        _ = Workspace(tmp_path / "inside") / "tets.mesh"
