"""The configuration of a session: one YAML file, checked as a whole before anything slow runs."""

from pathlib import Path

from pydantic import ValidationError

from pipeline.config.contradictions import contradictions
from pipeline.config.messages import ConfigProblem, config_error, problems_in
from pipeline.config.session import Config as Config
from pipeline.config.session import session_model
from pipeline.config.types import ValidationContext
from pipeline.config.yaml_text import YamlSource, parse_source, read_source


def load_config(path: Path, *, files_may_be_missing: bool = False) -> Config:
    """Read and check a configuration, and find the files it names.

    Parameters
    ----------
    path : Path
        The YAML file.
    files_may_be_missing : bool
        For commands that plan or record: names of files that are not there yet stand for none.

    Raises
    ------
    MissingFiles
        Nothing is wrong but that files it names are not there.
    ConfigError
        With one paragraph for every mistake in the file: line, keys, what was found, what was
        expected.
    """
    return config_from(read_source(path), files_may_be_missing=files_may_be_missing)


def parse_config(path: Path, text: str) -> Config:
    """Check ``text`` as if it stood in the file ``path``; errors as :func:`load_config`.

    Raises
    ------
    ConfigError
        With a paragraph for each mistake.
    """
    return config_from(parse_source(path, text))


def config_from(source: YamlSource, *, files_may_be_missing: bool = False) -> Config:
    """The configuration in a file that is read; errors and arguments as :func:`load_config`."""
    context = ValidationContext(
        source.path.parent, _names(source, "rate"), _names(source, "effects"), files_may_be_missing
    )
    config, error = None, None
    try:
        config = session_model().model_validate(source.values, context=context)
    except ValidationError as invalid:
        error = invalid
    problems = list(problems_in(source, error, context))
    if config is not None and not files_may_be_missing:
        problems += [ConfigProblem(path, text) for path, text in contradictions(config)]
    if problems or config is None:
        raise config_error(source, problems)
    config._source = source
    return config


def _names(source: YamlSource, section: str) -> tuple[str, ...]:
    entries = source.values.get(section)
    return tuple(entries) if isinstance(entries, dict) else ()
