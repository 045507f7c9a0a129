"""Files that are dropped on a page: kept apart and hidden until they are used."""

from collections.abc import AsyncIterator, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from pipeline.errors import ConfigError, UnwritableOutput
from pipeline.guess.files import is_clip
from pipeline.results.json_values import Json
from pipeline.served.serve import REFUSED, answering

DEEPEST = 4  #: parts of a file's path in a dropped folder; chosen
LONGEST_NAME = 120  #: characters of a file's name; chosen
MOST_FILES = 2000  #: files of one session; chosen
MOST_BYTES = 1 << 32  #: bytes of a session: the clips of an evening; chosen
PART = ".part"  #: end of the name of a file that is not whole yet
LOGS = {".csv", ".txt", ".log", ".tsv", ".dat", ".gz", ".zip", ".json", ".jsonl", ".ndjson", ".mat",
        ".npy", ".npz", ".h5", ".hdf5", ".parquet", ".bag", ".mcap", ".db3", ".ulg", ".bin",
        ".xml", ".sens", ".out", ".asc", ".tab", ".prn"}
"""Extensions of logs. Fact: those that :mod:`pipeline.logs` reads and that loggers use."""


class Dropped:
    """Files dropped on the page of ``folder``; they stay hidden there until they are used."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._place: TemporaryDirectory[str] | None = None
        self.forget()

    def forget(self) -> None:
        """Remove the dropped files."""
        self._bytes = 0
        if self._place is not None:
            self._place.cleanup()

    @property
    def routes(self) -> list[BaseRoute]:
        """Routes by which a page brings files and forgets them."""

        async def bring(request: Request) -> Response:
            await self.save(request.path_params["name"], request.stream())
            return JSONResponse({"files": len(self.files)})

        def forgotten(_: Json) -> Json:
            self.forget()
            return {}

        return [Route("/bring/{name:path}", bring, methods=["POST"]),
                answering("/forget", forgotten)]

    @property
    def files(self) -> list[Path]:
        """The dropped files, in the order of the names."""
        return sorted(path for path in self.root.rglob("*")
                      if path.is_file() and path.suffix != PART)

    @property
    def root(self) -> Path:
        """The hidden folder of the files.

        Raises
        ------
        UnwritableOutput
            It cannot be made.
        """
        if self._place is None or not Path(self._place.name).is_dir():
            try:
                self._place = TemporaryDirectory(prefix=".brought-", dir=self.folder)
            except OSError as error:
                raise UnwritableOutput(
                    f"{self.folder}: cannot be written ({error.strerror}). Open a folder of your "
                    f"own.") from error
        return Path(self._place.name)

    async def save(self, name: str, chunks: AsyncIterator[bytes]) -> None:
        """Keep one file.

        Raises
        ------
        ConfigError
            It is neither log nor clip, its name leads elsewhere, or all of them are too many.
        """
        path = self.root / checked_name(name)
        if not (is_clip(path) or path.suffix.lower() in LOGS):
            raise ConfigError(f"{name}: is neither a log nor a clip by its name; not taken.")
        if path.exists() or len(self.files) >= MOST_FILES:
            raise ConfigError(f"{name}: is there already, or there are {MOST_FILES} files.")
        part = path.with_name(f"{path.name}{PART}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with part.open("wb") as file:
                async for chunk in chunks:
                    self._bytes += len(chunk)
                    if self._bytes > MOST_BYTES:
                        raise ConfigError(f"{name}: with it the files are larger than "
                                          f"{MOST_BYTES >> 30} GB.")
                    file.write(chunk)
            part.replace(path)
        except OSError as error:
            raise UnwritableOutput(f"{name}: cannot be kept ({error.strerror}).") from error
        finally:
            with suppress(OSError):
                part.unlink()

    @property
    def logs(self) -> list[Path]:
        """The dropped files that are no clips."""
        return [path for path in self.files if not is_clip(path)]

    @contextmanager
    def kept_as(self, target: Path) -> Iterator[None]:
        """The files in the folder ``target`` while a block works with them, and for good after it;
        a block that fails leaves them where they were."""
        hidden = self.root
        hidden.rename(target)
        is_done = False
        try:
            yield
            is_done = True
        finally:
            if not is_done:
                target.rename(hidden)
        target.chmod(0o755)
        self.forget()

    @contextmanager
    def by_their_names(self) -> Iterator[None]:
        """Refusals that name the files as they were dropped."""
        try:
            yield
        except REFUSED as error:
            text = str(error).replace(f"{self.root}/", "").replace(f"{self.root.name}/", "")
            raise ConfigError(text) from error


def checked_name(name: str) -> Path:
    """A relative path whose parts are plain names.

    Raises
    ------
    ConfigError
        It leads elsewhere, is hidden, or no file system holds it.
    """
    parts = PurePosixPath(name).parts
    if not 1 <= len(parts) <= DEEPEST or not all(
            part.isprintable() and len(part) <= LONGEST_NAME and not part.startswith(".")
            and not set(part) & set('/\\:*?"<>|') for part in parts):
        raise ConfigError(f"{name!r} is no name of a file of a session.")
    return Path(*parts)
