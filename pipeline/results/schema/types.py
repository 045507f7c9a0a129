"""The kinds of values in results.json."""

from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from pipeline.results.json_values import Json, json_value

LARGEST = 1e100  #: far beyond every result, and its cube is still a number
LONGEST_TEXT = 10_000  #: characters
PROBLEMS_SHOWN = 3  #: problems shown of a damaged file, and the number of the others; chosen
BEFORE_OURS = "Value error, "  #: pydantic's words before those of a rule of ours

Number = Annotated[float, Field(allow_inf_nan=False, ge=-LARGEST, le=LARGEST)]
NotNegative = Annotated[float, Field(allow_inf_nan=False, ge=0, le=LARGEST)]
MaybeNumber = Number | None
MaybeSd = NotNegative | None
Probability = Annotated[float, Field(allow_inf_nan=False, ge=0, le=1 + 1e-9)]  # sums of roundings
Count = Annotated[int, Field(ge=0, le=10**12)]
Positive = Annotated[int, Field(ge=1, le=10**12)]
Text = Annotated[str, Field(max_length=LONGEST_TEXT)]
Three = Annotated[list[Number], Field(min_length=3, max_length=3)]
ThreeSds = Annotated[list[MaybeSd], Field(min_length=3, max_length=3)]
ThreeOrNull = Annotated[list[MaybeNumber], Field(min_length=3, max_length=3)]
Matrix = Annotated[list[Three], Field(min_length=3, max_length=3)]
Direction = Literal["ccw", "cw"]


class Part(BaseModel):
    """A mapping of results.json. Keys of later versions are passed over."""

    model_config = ConfigDict(frozen=True, strict=True, extra="ignore")

    @classmethod
    def of(cls, source: object = None, /, **values: Any) -> Self:
        """The mapping with these ``values`` and else with what ``source`` has under its keys.

        Arrays become lists, numbers that are not finite null.
        """
        keys = {field.alias or name for name, field in cls.model_fields.items()} - {*values}
        there = {key: getattr(source, key) for key in keys if hasattr(source, key)}
        return cls.model_validate(json_value(there | values))

    @classmethod
    def parsed(cls, contents: Any) -> Self:
        """The mapping that ``contents`` of a file are.

        Raises
        ------
        ValueError
            What is wrong with them, in the first few places.
        """
        try:
            return cls.model_validate(contents)
        except ValidationError as error:
            details = error.errors(include_url=False, include_input=False)
        shown = [f"{'.'.join(map(str, detail['loc']))}: {detail['msg'].removeprefix(BEFORE_OURS)}"
                 for detail in details[:PROBLEMS_SHOWN]]
        more = len(details) - len(shown)
        raise ValueError("; ".join(shown) + (f"; and {more} more" if more > 0 else ""))

    def as_json(self) -> Json:
        """Plain values for JSON, the keys in the order of their declaration."""
        return self.model_dump(by_alias=True, exclude_unset=True)


def means(meaning: str, **limits: Any) -> Any:
    """A key with its meaning."""
    return Field(description=meaning, **limits)
