"""Where the project's own data and the measured data of others are."""

from pathlib import Path

ROOT = Path(__file__).parents[1]
DATA = ROOT / "data"
SHARED = ROOT.parent / "shared"  #: measured sessions, beside the project; absent on most machines
REAL = SHARED / "real"
