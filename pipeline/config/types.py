"""The types of values in a configuration, and their checks."""

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Final, TypeVar

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    InstanceOf,
    ValidationError,
    ValidationInfo,
    create_model,
    model_validator,
)
from pydantic_core import InitErrorDetails, PydanticCustomError

from calib.effects.catalogue import EFFECTS, UnknownEffect, find_effect
from calib.effects.effect import OF_COLUMN
from calib.poses.triad_kind import TRIAD_KINDS
from pipeline.cameras import cameras_file, known_cameras
from pipeline.config.file_patterns import NoSuchFile, find_files
from pipeline.files import LONGEST_NAME
from pipeline.logs.columns import SAMPLE_RATES_HZ, Renamed
from pipeline.text.names import nearest_name
from vision.rate.terms import CONSTANT_RATE, TERMS

STOPPED = "stopped"  #: the run's rate that means: the plate did not turn


@dataclass(frozen=True)
class ValidationContext:
    """Data that the values of one file are checked against.

    Parameters
    ----------
    folder : Path
        The configuration's folder.
    rates, user_effects : tuple of str
        Names defined under ``rate:`` and ``effects:`` in the same file.
    files_may_be_missing : bool
        Names of files that are still to be recorded stand for no files, instead of a mistake.
    keys_of : dict
        Filled during validation: the keys that a mapping of the file may have, by its ``id``.
    """

    folder: Path
    rates: tuple[str, ...] = ()
    user_effects: tuple[str, ...] = ()
    files_may_be_missing: bool = False
    keys_of: dict[int, tuple[str, ...]] = field(default_factory=dict)


def _context(info: ValidationInfo) -> ValidationContext:
    """The context of the validation; sections built in Python stand in the working folder."""
    context = info.context
    return context if isinstance(context, ValidationContext) else ValidationContext(Path())


def may_be_missing(info: ValidationInfo) -> bool:
    """Whether names of files that are not there yet stand for none."""
    return _context(info).files_may_be_missing


#: The kinds of error that this package adds to pydantic's.
REFUSED: Final = "refused"
MISSING_FILE: Final = "missing_file"


def refusal(problem: str) -> PydanticCustomError:
    """The error a validator raises; ``problem`` is the message."""
    return PydanticCustomError(REFUSED, "{problem}", {"problem": problem})


def missing_file(fault: NoSuchFile, at: tuple[int, ...]) -> InitErrorDetails:
    """The error for a file that is not there, ``at`` a list item; as its input it has the fault.

    pydantic writes the text of everything else in an error, and this text takes a while.
    """
    return InitErrorDetails(type=PydanticCustomError(MISSING_FILE, "there is no such file"),
                            loc=at, input=fault)


def no_such(kind: str, name: str, right: tuple[str, ...]) -> PydanticCustomError:
    """The error for a name that is not among ``right``, with the nearest that is."""
    listed = ", ".join(dict.fromkeys(right)) or "none"
    return refusal(f"no {kind} is named '{name}'{nearest_name(name, right)}; there are: {listed}")


def one_of(kind: str, known: Collection[str]) -> AfterValidator:
    """The check of a name that must be among ``known``."""
    def checked(name: str) -> str:
        if name not in known:
            raise no_such(kind, name, tuple(known))
        return name

    return AfterValidator(checked)


# --- kinds of values ---------------------------------------------------------------------------


SHOWN = 60  #: characters of a wrong name that a message repeats
#: No length, rate, count or share of a session is larger, and none but 0 is smaller than its
#: inverse: squares neither overflow nor vanish.
LARGEST = 1e12


def _not_vanishing(value: float) -> float:
    if value < 1 / LARGEST:
        raise refusal(f"found {value:g}, expected a number of at least {1 / LARGEST:g}")
    return value


Number = Annotated[
    float, Field(strict=True, allow_inf_nan=False, ge=-LARGEST, le=LARGEST)
]
Positive = Annotated[
    float, Field(strict=True, allow_inf_nan=False, gt=0, le=LARGEST), AfterValidator(_not_vanishing)
]
SampleRate = Annotated[Positive, Field(ge=SAMPLE_RATES_HZ[0], le=SAMPLE_RATES_HZ[1])]
Count = Annotated[int, Field(strict=True, ge=1)]
Three = tuple[Number, Number, Number]


def _effect(name: str, info: ValidationInfo) -> str:
    user_effects = _context(info).user_effects
    if name in user_effects:
        return name
    try:
        return find_effect(name).name
    except UnknownEffect as error:
        near = nearest_name(name, (*EFFECTS, *user_effects, f"{OF_COLUMN}NAME"))
        raise refusal(
            f"no effect is named '{name}'{near}; `pipeline effects` lists them all"
        ) from error


def _user_effect_name(name: str) -> str:
    if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", name) or name in EFFECTS:
        raise refusal(f"'{name}' cannot name a user-defined effect: letters, digits and _ are "
                      "expected, and a name that no listed effect has")
    return name


def _rate_name(name: object, info: ValidationInfo) -> object:
    name = str(name) if isinstance(name, int) else name  # `33:` is the key "33"
    right = (*_context(info).rates, STOPPED)
    if isinstance(name, str) and name not in right:
        raise no_such("rate", name, right)
    return name


def _files(names: object, info: ValidationInfo) -> tuple[Path, ...]:
    """All files of a name, a pattern, or a list of these; each fault at its list item."""
    paths: list[Path] = []
    faults: list[InitErrorDetails] = []
    for i, name in enumerate(names if isinstance(names, list) else [names]):
        try:
            if not isinstance(name, str):
                raise FileNotFoundError(f"found {name!r}, a file's name or pattern is expected")
            paths += find_files(name, _context(info).folder)
        except FileNotFoundError as fault:
            if isinstance(fault, NoSuchFile) and _context(info).files_may_be_missing:
                continue
            at = (i,) if isinstance(names, list) else ()
            faults.append(missing_file(fault, at) if isinstance(fault, NoSuchFile) else
                          InitErrorDetails(type=refusal(str(fault)), loc=at, input=name))
        except (OSError, ValueError) as fault:  # no name that a file can have
            problem = getattr(fault, "strerror", None) or fault
            raise refusal(
                f"'{str(name)[:SHOWN]}' cannot be the name of a file ({problem})") from fault
    if faults:
        raise ValidationError.from_exception_data("files", faults)
    if not paths and not faults and not _context(info).files_may_be_missing:
        raise refusal("the list is empty; name a file or a pattern")
    places: set[Path] = set()
    for path in paths:
        if path.resolve() in places:  # one file has many paths
            raise refusal(f"{path} is named twice. Name each file once")
        places.add(path.resolve())
    return tuple(paths)


def _rows(columns: object) -> object:
    """One list of names, or one mapping, stands for a list of one."""
    names = isinstance(columns, list) and columns and all(isinstance(n, str) for n in columns)
    rows = [columns] if names or isinstance(columns, dict) else columns
    if not isinstance(rows, list):
        return rows
    return [_picked(row) if isinstance(row, dict) else row for row in rows]


def _picked(row: dict[Any, Any]) -> Renamed:
    """``{acc_x: Accel X}`` picks columns by the names in the file."""
    wrong = next((value for value in row.values() if not isinstance(value, str)), None)
    if wrong is not None:
        raise refusal(f"found {wrong!r}, the name of a column in the file is expected, in "
                      "quotation marks where it is a number")
    return Renamed(tuple((str(ours), theirs) for ours, theirs in row.items()))


def _folder_name(name: str) -> str:
    if "\0" in name or any(len(part.encode()) > LONGEST_NAME for part in Path(name).parts):
        raise refusal(f"'{name[:SHOWN]}' cannot be the name of a folder: names have no zero byte, "
                      f"and at most {LONGEST_NAME} bytes")
    return name


def _camera(name: str) -> str:
    known = known_cameras()
    if name not in known:
        raise refusal(f"the clock of '{name}' is not known{nearest_name(name, tuple(known))}; "
                      f"{cameras_file()} has: {', '.join(known) or 'none'}. Measure it "
                      f"(pipeline clock --camera NAME), or copy its entry from the computer where "
                      f"that was done")
    return name


CameraName = Annotated[str, AfterValidator(_camera)]
FolderName = Annotated[str, AfterValidator(_folder_name)]
TriadName = Annotated[str, one_of("triad", TRIAD_KINDS)]
RateName = Annotated[str, BeforeValidator(_rate_name)]
UserEffectName = Annotated[str, AfterValidator(_user_effect_name)]
Files = Annotated[tuple[Path, ...], BeforeValidator(_files)]
Effects = Annotated[tuple[Annotated[str, AfterValidator(_effect)], ...],
                    Field(min_length=1)]
VisionTerms = Annotated[tuple[Annotated[str, one_of("vision term", (CONSTANT_RATE, *TERMS))], ...],
                        Field(min_length=1)]
PoseNames = Annotated[tuple[Annotated[str, Field(min_length=1, strict=True)] | Count, ...],
                      BeforeValidator(lambda names: [names] if isinstance(names, str | int)
                                      else names)]
Columns = Annotated[
    tuple[InstanceOf[Renamed] | Annotated[tuple[str, ...], Field(min_length=1)], ...],
    BeforeValidator(_rows),
]


S = TypeVar("S", bound=BaseModel)


class Section(BaseModel):
    """A frozen mapping with known keys only."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @model_validator(mode="before")
    @classmethod
    def _note_keys(cls, section: object, info: ValidationInfo) -> object:
        if isinstance(section, dict):
            _context(info).keys_of[id(section)] = tuple(cls.model_fields)
        return section


def with_keys(section: type[S], name: str, keys: Mapping[str, Any]) -> type[S]:
    """A section with further keys: for each its type and its default, ``...`` where it has none."""
    return create_model(name, __base__=section, **dict(keys))
