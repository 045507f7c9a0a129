"""Every foreign file that is read, by the name of its writer."""

from tests.pipeline.guess.clock_files import CLOCKS
from tests.pipeline.guess.foreign import Writer
from tests.pipeline.guess.layout_files import FILES
from tests.pipeline.guess.object_files import OBJECTS
from tests.pipeline.guess.table_files import NAMED, UNNAMED
from tests.pipeline.guess.unit_files import NUMBERS, UNITS
from tests.pipeline.guess.word_files import LABELS, MARKUP

GROUPS = (UNNAMED, NAMED, UNITS, NUMBERS, CLOCKS, LABELS, MARKUP, OBJECTS, FILES)
READ: dict[str, Writer] = {name: writer for group in GROUPS for name, writer in group.items()}
assert len(READ) == sum(map(len, GROUPS))  # no name comes twice
