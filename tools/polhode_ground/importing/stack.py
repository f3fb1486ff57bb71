"""A file of several pictures: pages of a TIFF, a cube of FITS, Netpbm pictures one behind the other."""

import pathlib
from collections import Counter
from collections.abc import Iterator
from itertools import islice

from polhode_ground.common.errors import BadInput
from polhode_ground.common.levels import luminance
from polhode_ground.importing import fits, netpbm
from polhode_ground.importing.decoding import black_is_zero, decode, name_in_utf8, pages_of_tiff, tags_of_pages, tiff_tags
from polhode_ground.importing.formats import kind_of_file
from polhode_ground.importing.page_interval import frames_in, header_of
from polhode_ground.importing.source import NS, OTHER_CAMERA, Account, Frame, Options, Source

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
    account, count, kind = Account(), _pages_of(path), kind_of_file(path)
    header = header_of(tiff_tags(path)) if kind == "tiff" else None
    places, told_s, chosen = frames_in(header, count, options.camera, str(path))
    interval, is_told = _interval_s(told_s, header.who_tells_time if header else "", options.rate_hz, account)
    account.note(chosen)
    account.dropped += Counter({OTHER_CAMERA: count - len(places)})
    times_ns = [round(index * NS * interval) for index in range(len(places))]
    of_pages = dict(zip(places, times_ns))
    words, frames = {"tiff": (f"TIFF of {count} pages", _pages_of_tiff), "fits": (f"FITS of {count} pages", _cube)}.get(
        kind, (f"{count} Netpbm pictures in one file", _pages_of_netpbm)
    )
    return Source(
        words,
        frames(path, [of_pages.get(page) for page in range(count)], account),
        account,
        times_ns,
        len(places),
        nominal_time=not is_told,
    )


def _interval_s(told_s: float, who: str, rate_hz: float | None, account: Account) -> tuple[float, bool]:
    """(seconds from page to page, whether anybody tells them). @param told_s  as who says; 0: nobody does"""
    if rate_hz:
        other = f"; {who} says {told_s:g} s" if told_s and abs(told_s * rate_hz - 1) > SAME_INTERVAL else ""
        account.assumed.append(f"pages are {1 / rate_hz:g} s apart, as --rate-hz says{other}")
        return 1 / rate_hz, True
    account.assumed.append(
        f"pages are {told_s:g} s apart, as {who} says"
        if told_s
        else "pages tell no time: one a second is assumed, so rates and velocity are per picture; give --rate-hz"
    )
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


def _pages_of_tiff(path: pathlib.Path, times_ns: list[int | None], account: Account) -> Iterator[Frame]:
    """@param times_ns  None of pages that are not taken"""
    import cv2

    tags = tags_of_pages(path)
    for first in range(0, len(times_ns), PAGES_AT_ONCE):
        times = times_ns[first : first + PAGES_AT_ONCE]
        of_batch = list(islice(tags, len(times)))
        with name_in_utf8(path) as name:
            _, pages = cv2.imreadmulti(name, first, len(times), flags=cv2.IMREAD_UNCHANGED)
        if len(pages) < len(times):
            account.dropped[UNREADABLE_PAGE] += sum(time is not None for time in times[len(pages) :])
        for time_ns, page, own_tags in zip(times, pages, of_batch):
            if time_ns is None:
                continue
            pixels, remark = black_is_zero(luminance(page, "BGR"), own_tags)
            account.note(remark)
            yield Frame(time_ns, pixels=pixels)
