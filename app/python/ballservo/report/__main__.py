"""python3 -m ballservo.report [--figures] DIR...: draws report.html, and of a comparison the tables in words and in
LaTeX, into each folder from the files in it; with --figures each figure for a paper, too (figures.py). Exit: 0 done, 2
not."""
import sys
from pathlib import Path


def draw(folder, for_paper=False):
    """Draws one folder's page."""
    from . import figures, page
    for file in sorted(folder.iterdir()):
        if file.suffix in (".csv", ".json") and not file.is_file():
            raise ValueError(f"{file.name}: found no regular file")
    module = page.module_of(folder)
    tables = module.tables(folder) if hasattr(module, "tables") else {}
    page.write({folder / "report.html": page.render(module, folder),
                **{folder / name: text for name, text in tables.items()}})
    if for_paper:
        figures.write_figures(module, folder)


def main(words):
    folders = [word for word in words if word != "--figures"]
    try:
        for folder in folders:
            draw(Path(folder), len(folders) < len(words))
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
