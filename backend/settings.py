"""Settings of the server: environment variables with the prefix FILTERROOM_, or arguments of the command."""

from __future__ import annotations

import os
import re
import secrets
from pathlib import Path
from typing import Annotated, Self

from pydantic import Field, SecretStr, field_validator, model_validator
from pydantic_settings import BaseSettings, NoDecode, SettingsConfigDict

from backend.errors import StorageError, unusable_folder

LOOPBACK = ("127.0.0.1", "localhost", "::1")


def default_data_dir() -> Path:
    """Return the folder that the XDG base directory specification gives to this program's data."""
    base = os.environ.get("XDG_DATA_HOME", "")
    # The specification asks to ignore relative paths.
    root = Path(base) if base and Path(base).is_absolute() else Path.home() / ".local" / "share"
    return root / "filterroom"


class Settings(BaseSettings):
    """Everything about a server that may differ between installations."""

    model_config = SettingsConfigDict(
        env_prefix="FILTERROOM_",
        extra="forbid",
        frozen=True,
        use_attribute_docstrings=True,
        env_ignore_empty=True,
    )

    data_dir: Path = Field(default_factory=default_data_dir)
    """Folder of the database, the stored files and the token."""
    host: str = "127.0.0.1"
    """Address to listen on. Anything but loopback needs a token from you."""
    port: int = Field(default=8000, ge=0, le=65535)
    """Port to listen on; 0 takes a free one."""
    token: SecretStr | None = None
    """Secret that scripts send as `Authorization: Bearer`; if none is given, one is generated and kept."""
    token_file: Path | None = None
    """File that holds the token, instead of `token`."""
    insecure_no_token: bool = False
    """Serve everybody who can reach the address. Only for networks where everybody may see everything."""
    allowed_hosts: Annotated[tuple[str, ...], NoDecode] = ()
    """Names under which the server may be addressed besides localhost, separated by commas."""
    database_url: SecretStr = SecretStr("")
    """Address `postgresql://USER:PASSWORD@HOST/DATABASE`; empty means SQLite in the data folder."""
    scheduler: str = ""
    """Address of an existing Dask scheduler such as `tls://10.0.0.5:8786`; empty starts local workers."""
    insecure_scheduler: bool = False
    """Allow a scheduler at `tcp://...`: work goes there unencrypted, and whoever reaches it can run code."""
    tls_ca: Path | None = None
    """Certificate authority of an existing scheduler, PEM."""
    tls_cert: Path | None = None
    """Certificate of this server for an existing scheduler, PEM."""
    tls_key: Path | None = None
    """Private key that belongs to `tls_cert`, PEM."""
    workers: int = Field(default_factory=lambda: os.cpu_count() or 1, ge=1, le=1024)
    """Local worker processes; one thread each."""
    worker_memory_bytes: int | None = Field(default=None, ge=2**30)
    """Memory that one local worker may take, bytes, 1 GiB at least; by default its part of four fifths of all."""
    max_upload_bytes: int = Field(default=256 * 2**20, ge=1024)
    """Largest body of an upload, bytes."""
    max_json_bytes: int = Field(default=2**20, ge=1024)
    """Largest body of any other request, bytes."""
    max_rows: int = Field(default=5_000_000, ge=1)
    """Most rows that one recording may have."""
    reader_memory_bytes: int = Field(default=4 * 2**30, ge=2**28)
    """Memory that reading one upload may take, bytes."""
    reader_timeout_s: float = Field(default=600, gt=0)
    """Longest time that reading one upload may take, seconds."""
    kernel_cache: Path | None = None
    """Folder for compiled kernels; by default one in the user's cache folder, shared with the command line."""
    samples: bool = True
    """Import the bundled sample recording and run three algorithms on it when the data folder is new."""

    @field_validator("allowed_hosts", mode="before")
    @classmethod
    def _split_commas(cls, value: object) -> object:
        return tuple(h.strip() for h in value.split(",") if h.strip()) if isinstance(value, str) else value

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.token is not None and self.token_file is not None:
            raise ValueError("token and token_file exclude each other; give one of them")
        if self.scheduler and not re.fullmatch(r"(tls|tcp)://[^/\s]+:\d+", self.scheduler):
            raise ValueError(f"the scheduler {self.scheduler!r} is no address such as tls://10.0.0.5:8786")
        if self.scheduler.startswith("tcp://") and not self.insecure_scheduler:
            raise ValueError(
                f"the scheduler {self.scheduler} would get work unencrypted; give a tls:// address, or set "
                "FILTERROOM_INSECURE_SCHEDULER=true in a network where everybody may run code on it"
            )
        if self.scheduler.startswith("tls://") and None in (self.tls_ca, self.tls_cert, self.tls_key):
            raise ValueError("a scheduler at tls:// needs tls_ca, tls_cert and tls_key")
        return self

    @property
    def is_loopback(self) -> bool:
        """Whether only programs of this machine can reach the server."""
        return self.host in LOOPBACK or self.host.startswith("127.")

    @property
    def url(self) -> str:
        """SQLAlchemy URL of the database."""
        return self.database_url.get_secret_value() or f"sqlite:///{(self.data_dir / 'filterroom.sqlite').resolve()}"

    @property
    def store_dir(self) -> Path:
        """Folder of the content-addressed store."""
        return self.data_dir / "store"

    @property
    def has_own_token(self) -> bool:
        """Whether the user gave a token (one is generated otherwise)."""
        return self.token is not None or self.token_file is not None

    def read_token(self) -> str:
        """Return the token: given, read from its file, or generated once and kept in the data folder."""
        if self.token is not None:
            return self.token.get_secret_value()
        if self.token_file is not None:
            return _not_empty(self.token_file, self.token_file.read_text(encoding="utf-8").strip())
        return _kept_secret(self.data_dir / "token", 32)

    def read_instance_id(self) -> str:
        """Return a short id of this data folder; it keeps the cookies of two servers on one host apart."""
        return _kept_secret(self.data_dir / "instance", 6)


def _kept_secret(path: Path, size: int) -> str:
    """Return the text of `path`; generate it on first use so that no other user can ever read it."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        if path.is_file():
            return _not_empty(path, path.read_text(encoding="ascii").strip())
        raise
    except OSError as error:
        raise unusable_folder(path.parent, error) from error
    with os.fdopen(descriptor, "w", encoding="ascii") as out:
        # Lower case and no dash at the ends: the instance id becomes part of a cookie's name.
        value = secrets.token_hex(size) if size < 16 else secrets.token_urlsafe(size)
        out.write(value + "\n")
    return value


def _not_empty(path: Path, value: str) -> str:
    # An empty token would let everybody in.
    if not value:
        raise StorageError(f"{path} is empty.", remedy="Remove it or write a secret into it.", code="token_empty")
    return value
