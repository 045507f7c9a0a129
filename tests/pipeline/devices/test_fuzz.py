"""Any bytes whatever: no parser raises, hangs, or keeps more than a bounded part of them.

A hundred thousand cases are run by tests/bench/bench_record.py; here are enough to notice.
"""

import pytest

from tests.pipeline.devices.random_streams import PARSERS, fuzz, kept

MOST_KEPT = 20_000  #: bytes


@pytest.mark.parametrize("name", PARSERS)
def test_random_bytes_do_no_harm(name: str) -> None:
    _, most = fuzz(name, 1000, seed=1)
    assert most < MOST_KEPT


@pytest.mark.parametrize("name", PARSERS)
@pytest.mark.parametrize("filler", [b"\xff", b"\xfa\xff\x36\xff\x07\xff", b"x", b"\0", b"1,"])
def test_240_kilobytes_of_the_same_are_neither_kept_nor_slow(name: str, filler: bytes) -> None:
    parser = PARSERS[name]()
    for _ in range(12):
        parser.feed(filler * (20_000 // len(filler)))
        assert kept(parser) < MOST_KEPT
