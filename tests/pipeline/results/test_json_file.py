"""Files of ours that are no longer what was written: every fault is told as what it is."""

from pathlib import Path

import pytest

from pipeline.errors import UnreadableInput
from pipeline.results import noise
from pipeline.results.noise import load_noise
from pipeline.results.read import load_results


@pytest.mark.parametrize(("data", "fault"), [
    (b"{", r"is not JSON \(Expecting"), (b"\xff\xfe", r"is not JSON \('utf-8' codec"),
    (b"[" * 100_000, "is not JSON"), (b" " * 2000, "2000 bytes, at most 1000 are expected"),
])
def test_a_damaged_file_is_refused_with_what_is_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, data: bytes, fault: str
) -> None:
    if len(data) == 2000:
        monkeypatch.setattr(noise, "LARGEST_BYTES", 1000)
    for name, load in (("results.json", load_results), ("noise.json", load_noise)):
        (tmp_path / name).write_bytes(data)
        with pytest.raises(UnreadableInput, match=fault) as caught:
            load(tmp_path)
        assert f"Name the {name} that `pipeline" in str(caught.value)


def test_a_file_that_is_not_there_is_told_with_what_writes_it(tmp_path: Path) -> None:
    for load, command in ((load_results, "pipeline run"), (load_noise, "pipeline noise")):
        with pytest.raises(UnreadableInput, match=f"cannot be read.*`{command}` has written"):
            load(tmp_path)
