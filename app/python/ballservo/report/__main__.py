"""python3 -m ballservo.report DIR...: draws report.html, and of a comparison the tables in words and in LaTeX, into each
folder from the files in it. Exit: 0 done, 2 not."""
import importlib
import sys
from pathlib import Path

PAGES = ("run", "sweep", "grid", "comparison", "camera", "difference", "demo")


def draw(folder):
    """Draws one folder's page; each file is there whole or as it was."""
    from . import page
    for file in sorted(folder.iterdir()):
        if file.suffix in (".csv", ".json") and not file.is_file():
            raise ValueError(f"{file.name}: found no regular file")
    name = page.read_json(folder / "report.json")["page"]
    if name not in PAGES:
        raise ValueError(f"page: found {name}; allowed: {', '.join(PAGES)}")
    module = importlib.import_module(f".{name}", __package__)
    files = {"report.html": module.page(folder), **(module.tables(folder) if hasattr(module, "tables") else {})}
    for file, text in files.items():
        partial = folder / f"{file}.partial"
        try:
            partial.write_text(text, encoding="utf-8")
            partial.replace(folder / file)
        finally:
            partial.unlink(missing_ok=True)


def main(folders):
    try:
        for folder in folders:
            draw(Path(folder))
    except ImportError as error:
        sys.exit(f"{error}: install python3-matplotlib python3-jinja2")
    except OSError as error:
        print(f"{error.filename or folder}: {error.strerror or error}", file=sys.stderr)
        return 2
    except (ValueError, KeyError, TypeError, IndexError, RecursionError) as error:
        what = f"no {error}" if isinstance(error, KeyError) else str(error)
        print(f"{folder}: not as ballservo writes it: {what}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
