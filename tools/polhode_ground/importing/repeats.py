"""Pictures that repeat the one before: a frozen stream, 24 pictures a second made 30. They tell the motion wrong."""

from collections import Counter
from dataclasses import dataclass, field

import numpy as np

from polhode_ground.importing.source import Account

SAMPLES = 64  # rows and columns that are compared
ALIKE = 0.05  # of the usual difference of neighbours: coding leaves a little
TELL_COUNT, TELL_SHARE = 3, 0.05


@dataclass
class Repeats:
    """Differences of the pictures from the ones before."""

    differences: list[float] = field(default_factory=list)
    _before: np.ndarray | None = None

    def add(self, pixels: np.ndarray) -> None:
        some = pixels[:: max(1, pixels.shape[0] // SAMPLES), :: max(1, pixels.shape[1] // SAMPLES)].astype(np.float32)
        if self._before is not None:
            self.differences.append(float(np.abs(some - self._before).mean()))
        self._before = some

    def tell(self, account: Account) -> None:
        usual = float(np.median(self.differences or [0]))
        alike = [place for place, difference in enumerate(self.differences, 1) if difference <= ALIKE * usual]
        if len(alike) < max(TELL_COUNT, TELL_SHARE * len(self.differences)):
            return
        steps = Counter(np.diff(alike).tolist()).most_common(1)
        period = f", one of {steps[0][0]} as if made of a lower rate" if steps[0][1] >= 0.8 * (len(alike) - 1) and steps[0][0] > 1 else ""
        account.assumed.append(
            f"{len(alike)} of {len(self.differences) + 1} pictures repeat the one before{period}, first picture {alike[0] + 1}: a body that turns "
            "does not stand still, so their times are not those of the exposures"
        )
