"""Pages of result folders: `python3 -m ballservo.report DIR...` draws report.html into each.

The program measures and writes files; this package only reads and draws them. report.json names the page and holds
what the page shows and says beside the tables. One module makes one page, and its text is the template of that name.
"""


class NothingToDraw(Exception):
    """Results as ballservo writes them, but without anything that a page could show."""
