"""Small commands: `filterroom algorithms`, `migrate`, `backup`, `openapi`."""

from __future__ import annotations

import argparse
import json
import sys

from backend.cli.terminal import DONE, FAILED, UsageError, settings_of


def algorithms(options: argparse.Namespace) -> int:
    """List the algorithms."""
    from algorithms.registry import algorithms_by_name

    found = algorithms_by_name().values()
    if options.json:
        items = [
            {
                "name": a.name,
                "title": a.title,
                "family": a.family,
                "recommended": a.recommended,
                "takes": list(a.takes),
                "summary": a.summary,
            }
            for a in found
        ]
        print(json.dumps({"items": items}, indent=2, ensure_ascii=False))
        return DONE
    width = max((len(a.name) for a in found), default=0)
    for algorithm in found:
        print(f"{'*' if algorithm.recommended else ' '} {algorithm.name:<{width}}  {algorithm.title}")
    print("* what we would begin with")
    return DONE


def migrate(options: argparse.Namespace) -> int:
    """Bring the database to the tables of this version."""
    from backend.db.engine import Database
    from backend.db.migrate import upgrade
    from backend.files.lock import DataFolderLock

    settings = settings_of(data_dir=options.data)
    with DataFolderLock(settings.data_dir):
        database = Database(settings.url)
        try:
            upgrade(database)
        finally:
            database.close()
    where = settings.data_dir if not settings.database_url else "the given database"
    print(json.dumps({"migrated": True}) if options.json else f"{where} is up to date.")
    return DONE


def backup(options: argparse.Namespace) -> int:
    """Pack the data folder into one archive."""
    from backend.backup import back_up

    settings = settings_of(data_dir=options.data)
    if settings.database_url:
        raise UsageError(
            "FILTERROOM_DATABASE_URL names a database of its own: back it up with its tools, such as pg_dump, and then "
            f"copy the folder {settings.store_dir}; delete nothing in between."
        )
    done = back_up(settings.data_dir, options.file)
    lost = {"missing": list(done.missing), "damaged": list(done.damaged)}
    if options.json:
        print(json.dumps({"file": str(options.file), "files": done.files, "bytes": done.size_bytes, **lost}))
    else:
        print(f"{options.file}: the database and {done.files} files, {done.size_bytes / 2**20:.1f} MiB.")
        for what, hashes in lost.items():
            if hashes:
                print(f"filterroom: {len(hashes)} stored files are {what}: {', '.join(hashes)}", file=sys.stderr)
    return FAILED if done.missing or done.damaged else DONE


def openapi(options: argparse.Namespace) -> int:
    """Print the description of the HTTP API."""
    from backend.app import api_description

    print(json.dumps(api_description(), indent=2, ensure_ascii=False))
    return DONE
