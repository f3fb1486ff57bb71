"""One thing that somebody else made."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Material:
    name: str
    version: str
    licences: tuple[str, ...]  # SPDX where there is one for it, else in the source's own words; never empty
    purl: str  # package URL
    use: str  # loaded, compiled in, tool
    direct: bool = True  # asked for by ourselves, not only by another one
    needs: tuple[str, ...] = ()  # package URLs
