"""Every link of the built site leads to a page and to a place in it.

python docs/site/check_links.py build/site
python docs/site/check_links.py build/site --external

The second line lists the links to other sites and asks nobody: their form is checked, not whether
somebody answers. ``sphinx-build -b linkcheck docs build/links`` asks, where there is a network.
"""

import argparse
import re
from collections import defaultdict
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

OF_THEIR_OWN = ("_static", "_downloads")
"""Folders whose pages are shown in frames: drawings of drystone, without links."""
HOST = re.compile(r"([a-z0-9-]+\.)+[a-z]{2,}")
HERE = ("127.0.0.1", "localhost")


class Page(HTMLParser):
    """Places of a page, and the addresses that it names."""

    def __init__(self) -> None:
        super().__init__()
        self.places: set[str] = {"", "top"}
        self.links: list[str] = []
        self.shown: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Keep ids, and what a link or a picture leads to."""
        for key, value in attrs:
            if key == "id" or (key == "name" and tag == "a"):
                self.places.add(value or "")
            elif key == "href" or (key == "src" and tag != "iframe"):
                self.links.append(value or "")
        if ("property", "og:image") in attrs:
            self.shown.append(dict(attrs).get("content") or "")


def read(path: Path) -> Page:
    """A page of the site."""
    page = Page()
    page.feed(path.read_text("utf-8"))
    return page


def wrong_form(address: str) -> str:
    """What is wrong with the address of another site, as far as it can be seen; else empty."""
    parts = urlsplit(address)
    if parts.scheme == "mailto":
        return "" if "@" in parts.path else "no @"
    if parts.hostname in HERE:
        return ""
    if parts.scheme != "https":
        return "not https"
    if HOST.fullmatch(parts.hostname or "") is None:
        return "no name of a host"
    return "a blank in it" if re.search(r"\s", address) else ""


def broken(site: Path, pages: dict[Path, Page]) -> tuple[list[str], dict[str, set[str]], int]:
    """Links that lead nowhere, links to other sites with their pages, and the number of all."""
    found, external, count = [], defaultdict(set), 0
    for path, page in pages.items():
        here = path.relative_to(site).as_posix()
        others = "others load this picture: its address is whole, or left out"
        found += [f"{here}: {one}: {others}" for one in page.shown if wrong_form(one)]
        for link in page.links:
            count += 1
            parts = urlsplit(link)
            if parts.scheme == "data":
                continue
            if parts.scheme or parts.netloc:
                external[link].add(here)
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if not target.exists():
                found.append(f"{here}: {link}: no such file")
            elif target in pages and unquote(parts.fragment) not in pages[target].places:
                found.append(f"{here}: {link}: no such place in the page")
    found += [f"{link}: {wrong_form(link)}" for link in external if wrong_form(link)]
    return found, external, count


def main() -> int:
    """Check a built site."""
    parser = argparse.ArgumentParser(description="Check the links of the built site.")
    parser.add_argument("site", type=Path)
    parser.add_argument("--external", action="store_true", help="list the links to other sites")
    asked = parser.parse_args()
    site = asked.site.resolve()
    pages = {
        path: read(path)
        for path in sorted(site.rglob("*.html"))
        if path.relative_to(site).parts[0] not in OF_THEIR_OWN
    }
    if not pages:
        print(f"no pages in {site}")
        return 1
    found, external, count = broken(site, pages)
    if asked.external:
        print("\n".join(sorted(external)))
    print("\n".join(found), end="\n" if found else "")
    print(f"{len(pages)} pages, {count} links, {len(external)} other sites, {len(found)} broken")
    return 1 if found else 0


if __name__ == "__main__":
    raise SystemExit(main())
