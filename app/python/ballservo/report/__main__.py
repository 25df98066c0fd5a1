"""python3 -m ballservo.report [--figures] DIR|FILE...: draws report.html, and of a comparison the tables in words and in
LaTeX, into each folder from the files in it, and beside each file of tracks its page; with --figures each figure for a
paper, too (figures.py). Exit: 0 done, 2 not."""
import sys
from pathlib import Path

from . import NothingToDraw


def draw(results, for_paper=False):
    """Draws the page of a folder, or of a file of tracks."""
    from . import figures, page
    folder = results.is_dir()
    for file in sorted(results.iterdir()) if folder else [results]:
        if (not folder or file.suffix in (".csv", ".json")) and not file.is_file():
            raise ValueError(f"{file.name}: found no regular file")
    module = page.module_of(results)
    tables = module.tables(results) if hasattr(module, "tables") else {}
    page.write({results / "report.html" if folder else results.with_suffix(".html"): page.render(module, results),
                **{results / name: text for name, text in tables.items()}})
    if for_paper:
        figures.write_figures(module, results)


def main(words):
    everything = [word for word in words if word != "--figures"]
    try:
        for results in everything:
            draw(Path(results), len(everything) < len(words))
    except ImportError as error:
        sys.exit(f"{error}: install python3-matplotlib python3-jinja2")
    except OSError as error:
        print(f"{error.filename or results}: {error.strerror or error}", file=sys.stderr)
        return 2
    except NothingToDraw as error:
        print(f"{results}: {error}", file=sys.stderr)
        return 2
    except (ValueError, KeyError, TypeError, IndexError, RecursionError) as error:
        what = f"no {error}" if isinstance(error, KeyError) else str(error)
        print(f"{results}: not as ballservo writes it: {what}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
