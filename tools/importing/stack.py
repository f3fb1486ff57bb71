"""A file of several pictures: pages of a TIFF, a cube of FITS, Netpbm pictures one behind the other."""

import pathlib
from collections.abc import Iterator
from itertools import islice

from importing import fits, netpbm
from importing.decoding import black_is_zero, decode, name_in_utf8, pages_of_tiff, tags_of_pages, tiff_tags
from importing.formats import kind_of_file
from importing.page_interval import interval_s
from importing.source import NS, Account, Frame, Options, Source

from judge.errors import BadInput
from judge.levels import luminance

PAGES_AT_ONCE = 16
SAME_INTERVAL = 0.01  # rates are rounded
NETPBM = ("pgm", "pnm")
UNREADABLE_PAGE = "page that can't be read"


def is_stack(path: pathlib.Path) -> bool:
    return _pages_of(path) > 1


def _pages_of(path: pathlib.Path) -> int:
    kind = kind_of_file(path)
    if kind in NETPBM:
        return len(netpbm.pages_of(path))
    return pages_of_tiff(path) if kind == "tiff" else fits.pages_of(path) if kind == "fits" else 1


def open_stack(path: pathlib.Path, options: Options) -> Source:
    account, count = Account(), _pages_of(path)
    interval, is_told = _interval_s(path, count, options.rate_hz, account)
    times_ns = [round(index * NS * interval) for index in range(count)]
    kind = kind_of_file(path)
    words, frames = {"tiff": (f"TIFF of {count} pages", _pages_of_tiff), "fits": (f"FITS of {count} pages", _cube)}.get(
        kind, (f"{count} Netpbm pictures in one file", _pages_of_netpbm))
    return Source(words, frames(path, times_ns, account), account, times_ns, count, nominal_time=not is_told)


def _interval_s(path: pathlib.Path, count: int, rate_hz: float | None, account: Account) -> tuple[float, bool]:
    """(seconds from page to page, whether anybody tells them)."""
    told_s, who = interval_s(tiff_tags(path), count) if kind_of_file(path) == "tiff" else (0.0, "")
    if rate_hz:
        other = f"; {who} says {told_s:g} s" if told_s and abs(told_s * rate_hz - 1) > SAME_INTERVAL else ""
        account.assumed.append(f"pages are {1 / rate_hz:g} s apart, as --rate-hz says{other}")
        return 1 / rate_hz, True
    account.assumed.append(f"pages are {told_s:g} s apart, as {who} says" if told_s else
                           "pages tell no time: one a second is assumed, so rates and velocity are per picture; give --rate-hz")
    return told_s or 1.0, told_s > 0


def _cube(path: pathlib.Path, times_ns: list[int], account: Account) -> Iterator[Frame]:
    for time_ns, (pixels, remark) in zip(times_ns, fits.pages(path)):
        account.note(remark)
        yield Frame(time_ns, pixels=pixels)


def _pages_of_netpbm(path: pathlib.Path, times_ns: list[int], account: Account) -> Iterator[Frame]:
    with open(path, "rb") as file:
        for time_ns, (begin, end) in zip(times_ns, netpbm.pages_of(path)):
            file.seek(begin)
            try:
                page = decode(file.read(end - begin).lstrip(), str(path))
            except BadInput:
                account.dropped[UNREADABLE_PAGE] += 1
                continue
            account.note(page.remark)
            yield Frame(time_ns, pixels=page.pixels, bits=page.bits)


def _pages_of_tiff(path: pathlib.Path, times_ns: list[int], account: Account) -> Iterator[Frame]:
    import cv2
    tags = tags_of_pages(path)
    for first in range(0, len(times_ns), PAGES_AT_ONCE):
        times = times_ns[first:first + PAGES_AT_ONCE]
        of_batch = list(islice(tags, len(times)))
        with name_in_utf8(path) as name:
            _, pages = cv2.imreadmulti(name, first, len(times), flags=cv2.IMREAD_UNCHANGED)
        if len(pages) < len(times):
            account.dropped[UNREADABLE_PAGE] += len(times) - len(pages)
        for time_ns, page, own_tags in zip(times, pages, of_batch):
            pixels, remark = black_is_zero(luminance(page, "BGR"), own_tags)
            account.note(remark)
            yield Frame(time_ns, pixels=pixels)
