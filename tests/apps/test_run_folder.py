"""Output folders: a second run is refused while the first one runs, and works after it."""

import subprocess
import sys
from pathlib import Path

import pytest

from eyehand.apps.grasp.bench.row_store import open_rows
from eyehand.apps.main import main
from eyehand.apps.run_folder import claim_folder, release_folders
from eyehand.errors import InputError

SAMPLE = Path(__file__).resolve().parents[2] / "apps" / "sample" / "depth.png"
HOLDER = (
    "import sys\n"
    "from pathlib import Path\n"
    "from eyehand.apps.run_folder import claim_folder\n"
    "claim_folder(Path(sys.argv[1]))\n"
    "print('held', flush=True)\n"
    "sys.stdin.read()\n"
)
"""A program that holds a folder until its input ends."""


@pytest.fixture
def held(tmp_path):
    """Yield a folder that another process holds, and a function that kills this process."""
    folder = tmp_path / "out"
    program = [sys.executable, "-c", HOLDER, str(folder)]
    with subprocess.Popen(program, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == b"held\n"

        def kill():
            other.kill()
            other.wait()

        yield folder, kill
        kill()


def test_second_run_into_one_folder_is_refused_until_the_first_is_gone(held):
    folder, kill = held
    with pytest.raises(InputError, match=r"another run writes to .*out: wait for its end"):
        claim_folder(folder)
    kill()
    claim_folder(folder)
    claim_folder(folder)
    release_folders()
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize("command", [["perceive", str(SAMPLE)], ["synth"]])
def test_command_is_refused_in_one_line(held, capsys, command):
    with pytest.raises(SystemExit) as exit_info:
        main([*command, "--out", str(held[0])])
    err = capsys.readouterr().err
    assert exit_info.value.code == 2
    assert err.startswith("eyehand: another run writes to ")
    assert len(err.splitlines()) == 1


def test_temporaries_of_a_live_run_are_kept_and_those_of_a_killed_one_removed(held):
    folder, kill = held
    temporary = folder / "rows" / ".abc.json"
    temporary.parent.mkdir()
    temporary.write_bytes(b"half a row")
    with pytest.raises(InputError, match="another run"):
        open_rows(folder, {})
    assert temporary.exists()
    kill()
    open_rows(folder, {})
    release_folders()
    assert not temporary.exists()


def test_folder_that_cannot_be_created_is_refused(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot create the folder"):
        claim_folder(tmp_path / "file" / "out")
