"""Links of built pages that lead nowhere: a file that is not there, or a place that a page does not have. Other sites are not asked."""

import html.parser
import pathlib
import urllib.parse


class Page(html.parser.HTMLParser):
    def __init__(self, text: str):
        super().__init__()
        self.links: set[str] = set()
        self.places: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.add(value)
            elif name == "id" and value:
                self.places.add(value)


def dead_links(folder: pathlib.Path) -> list[str]:
    pages = {file.resolve(): Page(file.read_text()) for file in sorted(folder.rglob("*.html"))}
    dead = []
    for file, page in pages.items():
        for link in sorted(page.links):
            address = urllib.parse.urlsplit(link)
            if address.scheme or address.netloc:
                continue
            target = (file.parent / urllib.parse.unquote(address.path)).resolve() if address.path else file
            place = urllib.parse.unquote(address.fragment)
            if not target.is_file():
                dead.append(f"{file.name}: {link}: no such file")
            elif place and target in pages and place not in pages[target].places:
                dead.append(f"{file.name}: {link}: no such place")
    return dead
